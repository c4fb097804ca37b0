//! Leaving a surface: no hit on the surface left, and no way out of a closed room, whatever its size.

use super::random::Random;
use super::rays::{OneRay, closest};
use super::shapes::{Placed, Shape};
use super::{Effort, Row};
use crate::accel::{Brute, BuildOptions, Stream};
use crate::geometry::{MISS, Ray, TriangleAt, TriangleRows, inner_weights, offset_origin, triangle_point};
use crate::kernel::World;
use crate::lane::{Bits, Vec3, f32x16};
use crate::plan::GeometryMode;
use rayon::prelude::*;

const GROUP: &str = "leaving a surface";

pub fn rows(effort: Effort) -> Vec<Row> {
    let count = effort.pick(20_000, 200_000, 4_000_000);
    let rooms = effort.pick(20_000, 200_000, 2_000_000);
    let mut rows = vec![self_hits(count)];
    let sizes: Vec<f64> = (-6..=7).map(|k| 10f64.powi(k)).collect();
    let (convex, dented) = (Shape::ball(6, 0.0), Shape::ball(6, 0.1));
    let cube = Shape::cube(&[-1.0, -0.3, 1.0]);
    for (case, center) in [("at the origin", [0.0; 3]), ("100 sizes from it", [100.0, -37.0, 61.0])] {
        let rooms_of = |shape: &Shape| sizes.iter().map(|&s| shape.placed(center, 1.0, s)).collect::<Vec<_>>();
        let tell = |name: &str| format!("{name} of 1e-6 … 1e7 units {case}");
        let mut never = |name: &str, shape: &Shape, scatter: Scatter| {
            let (tried, found) = leaks(&rooms_of(shape), rooms, scatter, inner_weights);
            let (_, naive) = leaks(&rooms_of(shape), rooms, scatter, |_, u, v| (u, v));
            let row = Row::never(GROUP, tell(name), tried, found, "leaks");
            rows.push(row.naive(format!("from the hit itself: {naive}")));
        };
        never("box, grazing bounces", &cube, grazing);
        never("convex ball, grazing bounces", &convex, grazing);
        never("dented ball, diffuse bounces", &dented, diffuse);
        never("dented ball, grazing bounces", &dented, grazing);
    }
    rows
}

/// Triangles from 1 down to 1e-13 of the scene, anywhere in it; half of the directions graze.
fn self_hits(count: usize) -> Row {
    const JOB: usize = 4096;
    let job = |job: usize| {
        let mut rng = Random::new(0x91 + job as u64);
        let mut found = [0u64; 3];
        for _ in 0..JOB.min(count - job * JOB) {
            let (place, size) = (rng.log_uniform(-20.0, 0.0), rng.log_uniform(-43.0, 0.0));
            let p = rng.point(place);
            let v = [(); 3].map(|_| [0, 1, 2].map(|k| (p[k] + size * rng.signed()).clamp(-1.999, 1.999)));
            let at = TriangleRows::new(&v, &[[0, 1, 2]]).fetch::<f32>(Bits::splat(0), true);
            let (a, b) = (rng.unit(), rng.unit());
            let (u, w) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            let d = grazing(&mut rng, at.ng.lane(0));
            let point = triangle_point(&at, u, w);
            let origin = offset_origin(point.p, point.error, at.ng, Vec3::splat(d));
            let accel = crate::accel::Accel::build(&v, &[[0, 1, 2]], &[], BuildOptions::lists());
            let hits = |o: Vec3<f32>| {
                let ray = Ray::new(o, Vec3::splat(d), f32::INFINITY);
                u64::from(accel.trace::<f32, Brute>(&ray, true).primitive.lane(0) != MISS)
            };
            found = [found[0] + 1, found[1] + hits(origin), found[2] + hits(point.p)];
        }
        found
    };
    let jobs = (0..count.div_ceil(JOB)).into_par_iter().map(job);
    let [tried, ours, naive] = jobs.reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    Row::never(GROUP, "a triangle of 1 … 1e-13 of the scene does not hit itself", tried, ours, "self-hits")
        .naive(format!("without offset: {:.1} % self-hits", 100.0 * naive as f64 / tried.max(1) as f64))
}

/// A direction; every other one grazes the plane of `n`.
fn grazing(rng: &mut Random, n: [f32; 3]) -> [f32; 3] {
    let d = rng.direction();
    if rng.below(2) == 0 {
        return d;
    }
    let along: f32 = (0..3).map(|k| d[k] * n[k]).sum();
    let keep = rng.log_uniform(-20.0, 0.0);
    [0, 1, 2].map(|k| d[k] - (1.0 - keep) * along * n[k])
}

/// By the cosine to `n`: a point of the sphere that stands on the surface.
fn diffuse(rng: &mut Random, n: [f32; 3]) -> [f32; 3] {
    loop {
        let v = rng.direction();
        let d = [0, 1, 2].map(|k| n[k] + v[k]);
        if d.iter().any(|x| x.abs() > 1e-6) {
            return d;
        }
    }
}

type Scatter = fn(&mut Random, [f32; 3]) -> [f32; 3];
/// From the weights of a hit to those of the point to leave from.
type Weights = fn(&TriangleAt<f32>, f32, f32) -> (f32, f32);

/// Paths that bounce in closed rooms: from a hit, off the surface to the side it was hit from, on in any direction.
/// One that meets nothing has leaked. Returns bounces and leaks.
fn leaks(rooms: &[Placed], rays: usize, scatter: Scatter, weights: Weights) -> (u64, u64) {
    const BOUNCES: usize = 32;
    let paths = rays / BOUNCES / rooms.len();
    let mut found = [0u64; 2];
    for room in rooms {
        let world = room.world(GeometryMode::Tree);
        let job = |job: usize| {
            let mut rng = Random::new(0xa7 + job as u64);
            let start = room.center.map(|x| x / world.unit);
            let mut ways: Vec<_> = (0..64).map(|_| OneRay { o: start, d: rng.direction() }).collect();
            let mut found = [0u64; 2];
            for _ in 0..BOUNCES {
                found[0] += ways.len() as u64;
                found[1] += bounce(&world, &mut ways, (&mut rng, start), scatter, weights);
            }
            found
        };
        let jobs = (0..paths.div_ceil(64).max(1)).into_par_iter().map(job);
        let here = jobs.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        found = [found[0] + here[0], found[1] + here[1]];
    }
    (found[0], found[1])
}

/// Moves each ray on to its next; returns how many met nothing. Those start again at `start`.
fn bounce(
    world: &World,
    ways: &mut [OneRay],
    (rng, start): (&mut Random, [f32; 3]),
    scatter: Scatter,
    weights: Weights,
) -> u64 {
    let hits = closest::<f32x16, Stream>(world, ways);
    let mut leaks = 0;
    for (way, hit) in ways.iter_mut().zip(&hits) {
        if hit.1 == MISS {
            leaks += 1;
            *way = OneRay { o: start, d: rng.direction() };
            continue;
        }
        let at = world.triangles.fetch::<f32>(Bits::splat(hit.1), true);
        let mut d = scatter(rng, at.ng.lane(0));
        // As the offset tells the sides apart: another order of summing would send what grazes to the other one.
        let side = |d: [f32; 3]| Vec3::splat(d).dot(at.ng) < 0.0;
        if side(d) == side(way.d) {
            d = d.map(|x| -x);
        }
        let (u, v) = weights(&at, hit.2, hit.3);
        let point = triangle_point(&at, u, v);
        let o = offset_origin(point.p, point.error, at.ng, Vec3::splat(d));
        *way = OneRay { o: o.lane(0), d };
    }
    leaks
}
