//! How far a computed hit lies from where the ray truly meets the surface, far away and at grazing angles.

use super::random::Random;
use super::ulp::spacing;
use super::{Effort, Row};
use crate::accel::{Accel, Brute, BuildOptions};
use crate::geometry::{MISS, Ray, SphereRows, TriangleRows, sphere_point, triangle_point};
use crate::lane::{Bits, Vec3};
use rayon::prelude::*;

const GROUP: &str = "hit point";

type V = [f64; 3];

pub fn rows(effort: Effort) -> Vec<Row> {
    let count = effort.pick(20_000, 200_000, 4_000_000);
    let mut rows = triangles("triangles", count, |rng| rng.log_uniform(-6.0, 0.0));
    rows.extend(triangles("triangles, grazing at 1e-5 … 1e-2", count, |rng| rng.log_uniform(-16.6, -6.6)));
    rows.extend(spheres("spheres", count, (-6.0, -1.0)));
    rows.extend(spheres("spheres of 1e-6 … 1e-3 of the scene", count, (-20.0, -10.0)));
    rows.push(small_spheres_found(count));
    rows
}

/// Of one hit, in ulp of the largest coordinate.
#[derive(Clone, Copy, Default)]
struct Off {
    /// Off the surface.
    surface: f32,
    /// Off the ray.
    ray: f32,
    /// Off the ray, as a share of the bound.
    share: f32,
    /// How far o + t·d is off the surface.
    naive: f32,
}

fn table(case: &str, bound: f64, found: Vec<Off>) -> Vec<Row> {
    let column = |f: fn(&Off) -> f32| {
        let mut values: Vec<f32> = found.iter().map(f).collect();
        values.sort_unstable_by(f32::total_cmp);
        let most = values.last().copied().unwrap_or(f32::NAN);
        (f64::from(most), values.get(values.len() * 999 / 1000).copied().unwrap_or(f32::NAN))
    };
    let (surface, surface_most) = column(|o| o.surface);
    let (ray, ray_most) = column(|o| o.ray);
    let (share, _) = column(|o| o.share);
    let (naive, naive_most) = column(|o| o.naive);
    let count = found.len() as u64;
    let off_surface = format!("{case}: off the surface (99.9 %: {surface_most:.2})");
    let off_ray = format!("{case}: off the ray by {ray:.1} ulp (99.9 %: {ray_most:.1})");
    vec![
        Row::new(GROUP, off_surface, count, surface, bound, "ulp")
            .naive(format!("o + t·d: {naive:.1} (99.9 %: {naive_most:.2})")),
        Row::new(GROUP, off_ray, count, share, 1.0, "of the bound"),
    ]
}

/// How far the edge test may move the crossing off the ray: the sheared vertices are off by 2⁻²⁰ at most
/// ([`BOX_MARGIN`](crate::geometry::BOX_MARGIN)), 8 ulp of a coordinate in [1, 2), on each axis across the ray, and the
/// point by 2 on each axis.
const VERTICES: f64 = 8.0 * core::f64::consts::SQRT_2 + 2.0 * 1.732_051;

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn along(o: V, t: f64, d: V) -> V {
    [0, 1, 2].map(|k| o[k] + t * d[k])
}
fn wide(v: [f32; 3]) -> V {
    v.map(f64::from)
}
fn length(v: V) -> f64 {
    dot(v, v).sqrt()
}
/// The distance of a point from the line.
fn across(p: V, o: V, d: V) -> f64 {
    length(cross(sub(p, o), d)) / length(d)
}

fn collect(count: usize, one: impl Fn(&mut Random) -> Option<Off> + Sync) -> Vec<Off> {
    const JOB: usize = 4096;
    let job = |job: usize| {
        let mut rng = Random::new(0x51 + job as u64);
        (0..JOB.min(count - job * JOB)).filter_map(|_| one(&mut rng)).collect::<Vec<_>>()
    };
    (0..count.div_ceil(JOB)).into_par_iter().flat_map_iter(job).collect()
}

fn trace(accel: &Accel, o: [f32; 3], d: [f32; 3]) -> Option<(f32, f32, f32)> {
    let ray = Ray::<f32>::new(Vec3::splat(o), Vec3::splat(d), f32::INFINITY);
    let hit = accel.trace::<f32, Brute>(&ray, true);
    (hit.primitive.lane(0) != MISS).then_some((hit.t, hit.u, hit.v))
}

/// Triangles of log-uniform size anywhere, met at an angle whose sine `sine` draws. Per coordinate the point is within 2 ulp
/// of p0 + u e1 + v e2 ([`triangle_point`]), so within 2·√3 of the plane.
fn triangles(case: &str, count: usize, sine: fn(&mut Random) -> f32) -> Vec<Row> {
    let found = collect(count, |rng| {
        let (center, size) = (rng.point(1.2), rng.log_uniform(-8.0, -1.0));
        let v = [(); 3].map(|_| [0, 1, 2].map(|k| center[k] + size * rng.signed()));
        let (p0, e1, e2) = (wide(v[0]), sub(wide(v[1]), wide(v[0])), sub(wide(v[2]), wide(v[0])));
        let n = cross(e1, e2);
        let doubled_area = length(n);
        // Slivers have their own case.
        if doubled_area < 0.05 * f64::from(size * size) {
            return None;
        }
        let n = n.map(|x| x / doubled_area);
        let (mut a, mut b) = (rng.unit(), rng.unit());
        if a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        let target = [0, 1, 2].map(|k| p0[k] + f64::from(a) * e1[k] + f64::from(b) * e2[k]);
        let s = f64::from(sine(rng));
        let flat = cross(n, wide(rng.direction()));
        let d = [0, 1, 2].map(|k| s * n[k] + (1.0 - s * s).sqrt() * flat[k] / length(flat));
        let distance = f64::from(rng.log_uniform(-4.0, 0.5));
        let o = along(target, -distance, d).map(|x| x as f32);
        if o.iter().any(|x| x.abs() >= 2.0) {
            return None;
        }
        let d = [0, 1, 2].map(|k| target[k] as f32 - o[k]);
        let accel = Accel::build(&v, &[[0, 1, 2]], &[], BuildOptions::lists());
        let (t, u, v_weight) = trace(&accel, o, d)?;
        let at = TriangleRows::new(&v, &[[0, 1, 2]]).fetch::<f32>(Bits::splat(0), true);
        let p = wide(triangle_point(&at, u, v_weight).p.lane(0));
        let largest = v.iter().flatten().fold(0f32, |m, x| m.max(x.abs()));
        let ulp = spacing(largest.into());
        let off = |p: V| (dot(sub(p, p0), n).abs() / ulp) as f32;
        let naive = [0, 1, 2].map(|k| f64::from(o[k] + t * d[k]));
        // An ulp of the origin counts as much as one of the vertices.
        let both = o.iter().fold(largest, |m, x| m.max(x.abs()));
        let (ray, ulp) = (across(p, wide(o), wide(d)), spacing(both.into()));
        // The three edge values, products of lengths up to the triangle's, are rounded three times each (2u of the products
        // and of their difference); relative to their sum, twice the area that the ray sees, that moves the weights.
        let longest = [e1, e2, sub(e2, e1)].map(length).into_iter().fold(0.0, f64::max);
        let seen = doubled_area * (dot(n, wide(d)) / length(wide(d))).abs();
        let bound = VERTICES * ulp + 9.0 * 2f64.powi(-24) * longest.powi(3) / seen;
        Some(Off { surface: off(p), ray: (ray / ulp) as f32, share: (ray / bound) as f32, naive: off(naive) })
    });
    table(case, 2.0 * 3f64.sqrt(), found)
}

/// Per coordinate the point is c + r·n: n within γ(6) of unit length, the sum rounded once; in ulp of |c| + r less than
/// 6/2·2 + √3.
fn spheres(case: &str, count: usize, size: (f32, f32)) -> Vec<Row> {
    let found = collect(count, |rng| {
        let (center, radius) = (rng.point(0.9), rng.log_uniform(size.0, size.1));
        let n = rng.direction();
        let target = [0, 1, 2].map(|k| center[k] + radius * n[k]);
        let o = rng.point(1.9);
        let d = [0, 1, 2].map(|k| target[k] - o[k]);
        let accel = Accel::build(&[], &[], &[(center, radius)], BuildOptions::lists());
        let (t, ..) = trace(&accel, o, d)?;
        let at = SphereRows::new(&[(center, radius)]).fetch::<f32>(Bits::splat(0), true);
        let naive = [0, 1, 2].map(|k| o[k] + t * d[k]);
        let ray = Ray::<f32>::new(Vec3::splat(o), Vec3::splat(d), f32::INFINITY);
        let p = wide(sphere_point(&at, ray.at(t)).0.p.lane(0));
        let size = center.iter().fold(0f32, |m, x| m.max(x.abs())) + radius;
        let ulp = spacing(size.into());
        let off = |p: V| ((length(sub(p, wide(center))) - f64::from(radius)).abs() / ulp) as f32;
        let both = o.iter().fold(size, |m, x| m.max(x.abs()));
        let ray = across(p, wide(o), wide(d)) / spacing(both.into());
        Some(Off { surface: off(p), ray: ray as f32, share: (ray / VERTICES) as f32, naive: off(wide(naive)) })
    });
    table(case, 6.0 + 3f64.sqrt(), found)
}

/// Rays at spheres 1e-6 … 1e-3 of the scene, from up to twice the scene away, all within .9 of the radius.
fn small_spheres_found(count: usize) -> Row {
    const JOB: usize = 4096;
    let job = |job: usize| {
        let mut rng = Random::new(0x77 + job as u64);
        let mut lost = [0u64; 3];
        for _ in 0..JOB.min(count - job * JOB) {
            let (center, radius) = (rng.point(0.9), rng.log_uniform(-18.0, -10.0));
            let inside = rng.direction();
            let target = [0, 1, 2].map(|k| center[k] + 0.6 * radius * inside[k]);
            let o = rng.point(1.9);
            let d = [0, 1, 2].map(|k| target[k] - o[k]);
            // The rounded ray, in f64: does it pass well inside?
            if across(wide(center), wide(o), wide(d)) > 0.9 * f64::from(radius) {
                continue;
            }
            lost[0] += 1;
            let accel = Accel::build(&[], &[], &[(center, radius)], BuildOptions::lists());
            lost[1] += u64::from(trace(&accel, o, d).is_none());
            lost[2] += u64::from(!textbook_sphere(o, d, center, radius));
        }
        lost
    };
    let jobs = (0..count.div_ceil(JOB)).into_par_iter().map(job);
    let [tried, lost, naive] = jobs.reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    Row::never(GROUP, "small far spheres are found", tried, lost, "misses")
        .naive(format!("b² − a(|f|² − r²): {:.1} % missed", 100.0 * naive as f64 / tried.max(1) as f64))
}

/// The discriminant b² − a·c as it is taught.
fn textbook_sphere(o: [f32; 3], d: [f32; 3], center: [f32; 3], radius: f32) -> bool {
    use super::naive::{dot, sub};
    let f = sub(o, center);
    let (a, b, c) = (dot(d, d), dot(f, d), dot(f, f) - radius * radius);
    let discriminant = b * b - a * c;
    discriminant >= 0.0 && (-b + discriminant.sqrt()) / a > 0.0
}
