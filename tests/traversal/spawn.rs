//! Leaving a surface: no self-hit, and shadow rays that reach their light.

use super::support::*;
use octolux::accel::{Brute, BuildOptions};
use octolux::geometry::{MISS, Ray, SphereRows, TriangleRows, offset_origin, shadow_ray, sphere_point, triangle_point};
use octolux::lane::{Bits, Mask, Real, Vec3, f32x8, f32x16};

const N: usize = 16;
type R = f32x16;

fn all() -> <R as Real>::Mask {
    Mask::splat(true)
}

/// Random triangles of log-uniform size at log-uniform distances from 0, one a lane.
fn triangles(rng: &mut Random) -> Shapes {
    let mut shapes = Shapes::default();
    for _ in 0..N {
        let place = 2f32.powf(-20.0 * rng.unit());
        let size = 2f32.powf(-16.0 * rng.unit());
        let p = rng.point(place);
        let flat = rng.below(6);
        let v = [(); 3].map(|_| {
            let mut q = [0, 1, 2].map(|k| (p[k] + size * rng.signed()).clamp(-1.999, 1.999));
            // Axis-aligned walls, where offsets have one component only.
            if flat < 3 {
                q[flat] = p[flat];
            }
            q
        });
        shapes.push(v);
    }
    shapes
}

fn weights(rng: &mut Random) -> (R, R) {
    let pairs: Vec<(f32, f32)> = (0..N)
        .map(|_| {
            let (a, b) = (rng.unit(), rng.unit());
            match rng.below(5) {
                0 => (a, 0.0),
                1 => (0.0, 0.0),
                _ if a + b > 1.0 => (1.0 - a, 1.0 - b),
                _ => (a, b),
            }
        })
        .collect();
    (R::from_fn(|i| pairs[i].0), R::from_fn(|i| pairs[i].1))
}

fn directions(rng: &mut Random, ng: Vec3<R>) -> Vec3<R> {
    // Every other lane grazes: mostly in the plane.
    Vec3::from_fn(|i| {
        let (mut w, n) = (rng.point(1.0), ng.lane(i));
        if i % 2 == 0 {
            let along: f32 = (0..3).map(|k| w[k] * n[k]).sum();
            let keep = 2f32.powf(-20.0 * rng.unit());
            w = [0, 1, 2].map(|k| w[k] - (1.0 - keep) * along * n[k]);
        }
        w
    })
}

#[test]
fn a_ray_does_not_hit_the_triangle_it_leaves() {
    let mut rng = Random::new(31);
    let (mut tested, mut unmoved) = (0, 0);
    for _ in 0..20_000 {
        let shapes = triangles(&mut rng);
        let rows = TriangleRows::new(&shapes.positions, &shapes.triangles);
        let id = <R as Real>::Bits::from_fn(|i| i as u32);
        let at = rows.fetch::<R>(id, all());
        let (u, v) = weights(&mut rng);
        let w = directions(&mut rng, at.ng);
        let point = triangle_point(&at, u, v);
        let origin = offset_origin(point.p, point.error, at.ng, w);
        for i in 0..N {
            // Its own triangle only: every lane against a scene of one.
            let one =
                octolux::accel::Accel::build(&shapes.positions, &shapes.triangles[i..=i], &[], BuildOptions::lists());
            let hit = |o: [f32; 3]| {
                let ray = Ray::new(Vec3::splat(o), Vec3::splat(w.lane(i)), f32::INFINITY);
                one.trace::<f32, Brute>(&ray, true).primitive.lane(0) != MISS
            };
            assert!(!hit(origin.lane(i)), "{:?} from {:?} to {:?}", shapes.vertices(i), point.p.lane(i), w.lane(i));
            tested += 1;
            unmoved += usize::from(hit(point.p.lane(i)));
        }
    }
    // Without the offset the same rays do hit: the test sees something.
    assert!(unmoved * 20 > tested, "{unmoved} of {tested}");
}

/// The hit point is within its bound of the plane and of the true interpolation.
#[test]
fn the_point_is_within_its_error() {
    let mut rng = Random::new(32);
    for _ in 0..2000 {
        let shapes = triangles(&mut rng);
        let rows = TriangleRows::new(&shapes.positions, &shapes.triangles);
        let at = rows.fetch::<R>(Bits::from_fn(|i| i as u32), all());
        let (u, v) = weights(&mut rng);
        let point = triangle_point(&at, u, v);
        for i in 0..N {
            let p = shapes.vertices(i).map(|p| p.map(f64::from));
            let (u, v) = (f64::from(u.lane(i)), f64::from(v.lane(i)));
            let (found, error) = (point.p.lane(i), point.error.lane(i));
            for (k, (found, error)) in found.into_iter().zip(error).enumerate() {
                let exact = p[0][k] + u * (p[1][k] - p[0][k]) + v * (p[2][k] - p[0][k]);
                let off = (exact - f64::from(found)).abs();
                assert!(off <= f64::from(error), "off by {off}");
                // Half an ulp each for the edges (weights sum to at most 1), v·e2, the sum of edges and the last sum.
                let edges = [(p[1][k] - p[0][k]).abs(), (p[2][k] - p[0][k]).abs()];
                let most = edges.into_iter().fold(exact.abs().max(p[0][k].abs()), f64::max);
                let ulp = f64::from(f32::from_bits((most as f32).to_bits() + 1) - most as f32);
                assert!(off <= 2.0 * ulp + 1e-45, "off by {} ulp", off / ulp);
            }
        }
    }
}

fn reaches<W: Real>(ray: &Ray<R>, accel: &octolux::accel::Accel, i: usize) -> bool {
    let lane = |v: Vec3<R>| Vec3::<W>::splat(v.lane(i));
    let ray = Ray::new(lane(ray.origin), lane(ray.direction), W::splat(ray.t_max.lane(i)));
    accel.occluded::<W, Brute>(&ray, W::Mask::splat(true)).none()
}

/// Between two triangles with nothing else: neither end blocks. With a third between them: it does.
#[test]
fn shadow_rays_reach_their_light_and_no_further() {
    let mut rng = Random::new(33);
    let (mut tested, mut blocked) = (0, 0);
    for _ in 0..4000 {
        let (from, to) = (triangles(&mut rng), triangles(&mut rng));
        let id = <R as Real>::Bits::from_fn(|i| i as u32);
        let a = TriangleRows::new(&from.positions, &from.triangles).fetch::<R>(id, all());
        let b = TriangleRows::new(&to.positions, &to.triangles).fetch::<R>(id, all());
        let (u, v) = weights(&mut rng);
        let p = triangle_point(&a, u, v);
        let (u, v) = weights(&mut rng);
        let q = triangle_point(&b, u, v);
        let way = q.p - p.p;
        let origin = offset_origin(p.p, p.error, a.ng, way);
        let ray = shadow_ray(origin, &q, b.ng);
        for i in 0..N {
            let distance = way.length().lane(i);
            // Points whose height above the other's surface is below the offsets are not told apart from points on it.
            let offsets = (p.error.lane(i).iter().chain(&q.error.lane(i))).sum::<f32>() + 1e-5 * distance;
            let height = |n: Vec3<R>| way.dot(n).lane(i).abs();
            if height(a.ng) < offsets || height(b.ng) < offsets {
                continue;
            }
            let mut scene = Shapes::default();
            scene.push(from.vertices(i));
            scene.push(to.vertices(i));
            // The two may truly cross each other between the points: only each one alone is in question.
            for k in 0..2 {
                let one =
                    octolux::accel::Accel::build(&scene.positions, &scene.triangles[k..=k], &[], BuildOptions::lists());
                let which = ["its own surface", "its light"][k];
                assert!(reaches::<f32x8>(&ray, &one, i), "{which} blocks: {:?} {:?}", scene.positions, ray);
            }
            tested += 1;
            if distance > 0.01 {
                let middle = [0, 1, 2].map(|k| origin.lane(i)[k] + 0.5 * ray.direction.lane(i)[k]);
                let mut wall = Shapes::default();
                let spread = [[0.1, 0.0], [-0.1, 0.1], [-0.1, -0.1]];
                let d = ray.direction.lane(i);
                let most = (0..3).max_by(|a, b| d[*a].abs().total_cmp(&d[*b].abs())).unwrap_or(0);
                wall.push(spread.map(|s| {
                    let mut v = middle;
                    v[(most + 1) % 3] += s[0];
                    v[(most + 2) % 3] += s[1];
                    v
                }));
                assert!(!reaches::<f32>(&ray, &wall.build(BuildOptions::lists()), i), "passes a wall");
                blocked += 1;
            }
        }
    }
    assert!(tested > 20_000 && blocked > 10_000, "{tested} {blocked}");
}

#[test]
fn a_ray_does_not_hit_the_sphere_it_leaves_and_finds_the_other_wall() {
    let mut rng = Random::new(34);
    for _ in 0..20_000 {
        let spheres: Vec<_> = (0..N)
            .map(|_| {
                let radius = 2f32.powf(-12.0 * rng.unit()) * 0.5;
                (rng.point(1.9 - radius), radius)
            })
            .collect();
        let at = SphereRows::new(&spheres).fetch::<R>(Bits::from_fn(|i| i as u32), all());
        let near = Vec3::from_fn(|i| {
            let d = rng.point(1.0);
            [0, 1, 2].map(|k| spheres[i].0[k] + spheres[i].1 * d[k])
        });
        let (point, n) = sphere_point(&at, near);
        let w = directions(&mut rng, n);
        let origin = offset_origin(point.p, point.error, n, w);
        for (i, sphere) in spheres.iter().enumerate() {
            let one = octolux::accel::Accel::build(&[], &[], &[*sphere], BuildOptions::lists());
            let ray = Ray::new(Vec3::splat(origin.lane(i)), Vec3::splat(w.lane(i)), f32::INFINITY);
            let hit = one.trace::<f32, Brute>(&ray, true);
            let outward = w.dot(n).lane(i) >= 0.0;
            let found = hit.primitive.lane(0) != MISS;
            assert_eq!(found, !outward, "{sphere:?} from {:?} to {:?}, t {}", origin.lane(i), w.lane(i), hit.t);
        }
    }
}
