//! Rays and shapes at the edges: shared edges and corners, ties, flat and coincident boxes, grazing origins.

use super::support::*;
use octolux::accel::{Packet, Preset, Single};
use octolux::geometry::MISS;
use octolux::lane::{f32x8, f32x16};

/// A closed ball of triangles with shared vertices: a sphere of `rings`×`2·rings` quads, poles included, jittered.
fn closed_mesh(rings: usize, center: [f32; 3], radius: f32, rng: &mut Random) -> Shapes {
    let mut shapes = Shapes::default();
    let columns = 2 * rings;
    for i in 0..=rings {
        for j in 0..columns {
            let theta = core::f32::consts::PI * i as f32 / rings as f32;
            let phi = core::f32::consts::TAU * j as f32 / columns as f32;
            let r = if i == 0 || i == rings { radius } else { radius * (1.0 + 0.1 * rng.signed()) };
            let (sin, cos) = if i == 0 {
                (0.0, 1.0)
            } else if i == rings {
                (0.0, -1.0)
            } else {
                theta.sin_cos()
            };
            let n = [sin * phi.cos(), cos, sin * phi.sin()];
            shapes.positions.push([0, 1, 2].map(|k| center[k] + r * n[k]));
        }
    }
    for i in 0..rings {
        for j in 0..columns {
            let at = |i: usize, j: usize| (i * columns + j % columns) as u32;
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
            if i > 0 {
                shapes.triangles.push([a, b, c]);
            }
            if i + 1 < rings {
                shapes.triangles.push([b, d, c]);
            }
        }
    }
    shapes
}

fn nudge(x: f32, ulps: i32) -> f32 {
    if x == 0.0 {
        f32::from_bits(ulps.unsigned_abs()).copysign(ulps as f32)
    } else {
        f32::from_bits((x.to_bits() as i32 + ulps) as u32)
    }
}

/// From inside a closed mesh every ray hits, wherever it is aimed.
#[test]
fn nothing_leaks_through_edges_and_corners() {
    let mut rng = Random::new(21);
    for (center, radius) in [([0.0; 3], 1.0), ([1.0, -0.7, 0.4], 0.5), ([1.9, 1.9, -1.9], 0.01), ([0.3, 0.3, 0.3], 1.2)]
    {
        let mut shapes = closed_mesh(12, center, radius, &mut rng);
        // Something larger around nothing: the scene's own scale stays that of coordinates below 2.
        shapes.positions.iter_mut().flatten().for_each(|x| *x = x.clamp(-1.999, 1.999));
        let accel = shapes.everything(Preset::Medium);
        let mut rays = Vec::new();
        for _ in 0..20_000 {
            let o = [0, 1, 2].map(|k| center[k] + 0.3 * radius * rng.signed());
            let o = o.map(|x| x.clamp(-1.99, 1.99));
            let v = shapes.vertices(rng.below(shapes.triangles.len()));
            let s = if rng.unit() < 0.4 { 0.0 } else { rng.unit() };
            let target = [0, 1, 2].map(|k| v[0][k] + s * (v[1][k] - v[0][k]));
            let target = target.map(|x| nudge(x, rng.below(5) as i32 - 2));
            rays.push(OneRay { o, d: [0, 1, 2].map(|k| target[k] - o[k]), t_max: f32::INFINITY });
        }
        let found = ask_all(&[&accel], &rays);
        let leaks = found.iter().filter(|(hit, any)| hit.1 == MISS || !any).count();
        assert_eq!(leaks, 0, "of {} rays from inside at {center:?}", rays.len());
    }
}

/// Along axes and from coordinates that box faces share.
#[test]
fn nothing_leaks_from_an_axis_aligned_box() {
    let mut rng = Random::new(22);
    let mut shapes = Shapes::default();
    let grid = 8;
    let p = |face: usize, i: usize, j: usize| {
        let (a, b) = (i as f32 / 4.0 - 1.0, j as f32 / 4.0 - 1.0);
        let c = if face.is_multiple_of(2) { -1.0 } else { 1.0 };
        let mut v = [0.0; 3];
        (v[face / 2], v[(face / 2 + 1) % 3], v[(face / 2 + 2) % 3]) = (c, a, b);
        v
    };
    for face in 0..6 {
        for (i, j) in (0..grid).flat_map(|i| (0..grid).map(move |j| (i, j))) {
            shapes.push([p(face, i, j), p(face, i + 1, j), p(face, i, j + 1)]);
            shapes.push([p(face, i + 1, j), p(face, i + 1, j + 1), p(face, i, j + 1)]);
        }
    }
    let accel = shapes.everything(Preset::Medium);
    let mut rays = Vec::new();
    for i in 0..20_000 {
        // On the grid's own planes, so that slabs meet 0·∞, or just beside them.
        let o = [(); 3].map(|_| nudge((rng.below(7) as f32 - 3.0) / 4.0, rng.below(3) as i32 - 1));
        let mut d = [(); 3].map(|_| (rng.below(9) as f32 - 4.0) / 4.0);
        if i % 2 == 0 {
            d = d.map(|x| if x.abs() < 0.6 { x.signum() * 0.0 } else { x });
        }
        if d == [0.0; 3] {
            d[i % 3] = -1.0;
        }
        rays.push(OneRay { o, d, t_max: f32::INFINITY });
    }
    let found = ask_all(&[&accel], &rays);
    assert_eq!(found.iter().filter(|(hit, _)| hit.1 == MISS).count(), 0);
}

/// What makes trees harmless: no hit lies before its own box. Rays along planes, where the distance to a plane is noise.
#[test]
fn no_hit_lies_before_its_own_box() {
    let mut rng = Random::new(26);
    let (mut shapes, mut rays) = (Shapes::default(), Vec::new());
    for i in 0..400 {
        let v = [(); 3].map(|_| rng.point(1.5));
        let v = if i % 2 == 0 {
            v
        } else {
            [v[0], v[1], [0, 1, 2].map(|k| 0.5 * (v[0][k] + v[1][k]) + 1e-6 * rng.signed())]
        };
        shapes.push(v);
        for _ in 0..60 {
            let (a, b) = (2.0 * rng.signed(), 2.0 * rng.signed());
            let at = |u: f32, w: f32| [0, 1, 2].map(|k| v[0][k] + u * (v[1][k] - v[0][k]) + w * (v[2][k] - v[0][k]));
            let (from, to) = (at(a, b), at(rng.unit(), rng.unit()));
            let tilt = 2f32.powf(-24.0 * rng.unit()) * 1e-3;
            let o = from.map(|x| (x + tilt * rng.signed()).clamp(-1.9, 1.9));
            rays.push(OneRay { o, d: [0, 1, 2].map(|k| to[k] - o[k]), t_max: f32::INFINITY });
        }
    }
    let accel = shapes.everything(Preset::Medium);
    let found = ask_all(&[&accel], &rays);
    let mut tight = 0;
    for ((hit, _), ray) in found.iter().zip(&rays).filter(|((hit, _), _)| hit.1 != MISS) {
        let v = shapes.vertices(hit.1 as usize);
        let t_near = (0..3).fold(0.0f32, |t_near, k| {
            let (lo, hi) = v.iter().fold((f32::MAX, f32::MIN), |(lo, hi), p| (lo.min(p[k]), hi.max(p[k])));
            let margin = octolux::geometry::BOX_MARGIN;
            let plane = if ray.d[k].is_sign_negative() { hi + margin } else { lo - margin };
            let t = (plane - ray.o[k]) * (1.0 / ray.d[k]);
            if t > t_near { t } else { t_near }
        });
        assert!(f32::from_bits(hit.0) >= t_near, "{hit:?} {ray:?} enters its box at {t_near}");
        tight += usize::from(f32::from_bits(hit.0) == t_near);
    }
    println!("{tight} hits were held to their box");
    assert!(tight > 0, "no hit came near the bound: the test saw nothing");
}

#[test]
fn equal_distances_go_to_the_lower_primitive() {
    let mut rng = Random::new(23);
    let mut shapes = Shapes::random(300, 0, 0.3, &mut rng);
    let n = shapes.triangles.len();
    // Every triangle again, in another order and in blocks far from the first.
    for i in 0..n {
        let v = shapes.vertices((i * 7) % n);
        shapes.push(v);
    }
    let accels = [Preset::Fast, Preset::Medium, Preset::Best].map(|preset| shapes.everything(preset));
    let rays = super::equivalence::random_rays(4096, &mut rng);
    let found = ask_all(&accels.each_ref(), &rays);
    let hits: Vec<_> = found.iter().filter(|(hit, _)| hit.1 != MISS).collect();
    assert!(hits.len() > 1000);
    assert!(hits.iter().all(|(hit, _)| (hit.1 as usize) < n), "a copy was preferred to its original");
}

/// More coincident primitives than any split can part, in the middle of others.
#[test]
fn coincident_primitives_build_and_trace() {
    let mut rng = Random::new(24);
    let mut shapes = Shapes::random(100, 0, 0.2, &mut rng);
    let v = [[-0.5, -0.5, 1.6], [0.5, -0.5, 1.6], [0.0, 0.7, 1.6]];
    (0..100_000).for_each(|_| shapes.push(v));
    let rays: Vec<_> = (0..256)
        .map(|_| {
            let (o, to) = (rng.point(1.0), [0.1 * rng.signed(), 0.2 * rng.signed(), 1.6]);
            OneRay { o, d: [0, 1, 2].map(|k| to[k] - o[k]), t_max: f32::INFINITY }
        })
        .collect();
    for preset in [Preset::Fast, Preset::Medium] {
        let accel = shapes.build(octolux::accel::BuildOptions::trees(preset));
        println!("{preset:?}: {:?}", accel.report());
        let found = ask::<f32x16, Packet>(&accel, &rays, |_| true);
        assert_eq!(found, ask::<f32x8, Single>(&accel, &rays, |_| true));
        assert!(found.iter().all(|(hit, any)| hit.1 <= 100 && *any));
        assert!(found.iter().any(|(hit, _)| hit.1 == 100));
    }
}

/// Boxes without volume or area, points and lines included, in a line that tempts a builder into a list.
#[test]
fn flat_and_degenerate_shapes_build_and_trace() {
    let mut rng = Random::new(25);
    let mut shapes = Shapes::default();
    for i in 0..2000 {
        let x = 1.5 * 0.99f32.powi(i);
        match i % 4 {
            0 => shapes.push([[x, 0.0, 0.0]; 3]),
            1 => shapes.push([[x, -0.1, 0.0], [x, 0.1, 0.0], [x, 0.0, 0.0]]),
            2 => shapes.push([[x, -0.1, -0.1], [x, 0.1, -0.1], [x, 0.0, 0.1]]),
            _ => shapes.push([[x, -0.1, 0.0], [x * 0.98, 0.1, 0.0], [x, 0.1, 0.0]]),
        }
    }
    let accels = [Preset::Fast, Preset::Medium, Preset::Best].map(|preset| shapes.everything(preset));
    let mut rays = super::equivalence::random_rays(512, &mut rng);
    for ray in rays.iter_mut().skip(1).step_by(2) {
        ray.o = [1.8, 0.05 * rng.signed(), 0.05 * rng.signed()];
        ray.d = [-1.0, 0.0, 0.0];
    }
    let found = ask_all(&accels.each_ref(), &rays);
    assert!(found.iter().filter(|(hit, _)| hit.1 != MISS).count() > 100);
}
