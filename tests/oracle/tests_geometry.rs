//! The oracle's rays: camera, triangles, spheres, environment.

use super::scenes::LAMBERT;
use super::vec3::{Frame, V3};
use super::*;
use crate::stats::{Moments, Rng, assert_mean, oracle};
use octolux::scene::{Environment, EnvironmentImage};
use std::f64::consts::{PI, TAU};

#[test]
fn camera_looks_as_the_format_says() {
    // Looking along −z with y up: right = forward × up = +x.
    let scene = SceneBuilder::new().camera([1.0, 2.0, 3.0], [1.0, 2.0, -7.0], 90.0).film(4, 2).build();
    let (o, d) = camera_ray(&scene, 0.0, 0.0);
    assert_eq!(o, [1.0, 2.0, 3.0]);
    let expected = V3::new(-2.0, 1.0, -1.0).unit(); // left, up; tan 45° = 1 up and down, twice that sideways
    assert!((V3(d) - expected).length() < 1e-15, "{d:?}");
    assert!((V3(camera_ray(&scene, 2.0, 1.0).1) - V3::new(0.0, 0.0, -1.0)).length() < 1e-15);
    assert!((V3(camera_ray(&scene, 4.0, 2.0).1) - V3::new(2.0, -1.0, -1.0).unit()).length() < 1e-15);
}

#[test]
fn silhouette_of_a_sphere_has_its_area() {
    let Some(case) = oracle("L.sphere_silhouette_phi30") else { return };
    let center = [3.0 * 30f32.to_radians().sin(), 0.0, -3.0 * 30f32.to_radians().cos()];
    let scene = SceneBuilder::new().film(16, 16).camera([0.0; 3], [0.0, 0.0, -1.0], 106.26021).bounces(0);
    let image = render(
        &scene.sphere(center, 1.0, LAMBERT(0.0), 1.0).build(),
        Region { x0: 0, y0: 0, x1: 16, y1: 16 },
        2_000,
        1,
    );
    let side = 2.0 * (106.26021f64.to_radians() / 2.0).tan();
    // f32 positions: 1e-7 of the area.
    image.assert_mean("silhouette", [case.value / (side * side); 3], 1e-7, 3);
    // Right of the middle, not left.
    assert!(image.pixel(11, 8)[0].mean > 0.9 && image.pixel(4, 8)[0].mean == 0.0);
}

#[test]
fn far_spheres_are_hit_where_they_are() {
    for (id, distance) in [("K.far_sphere_1e3", 1e3), ("K.far_sphere_1e5", 1e5), ("K.far_sphere_1e7", 1e7)] {
        let Some(case) = oracle(id) else { return };
        let scene = SceneBuilder::new().sphere([0.5, 0.0, distance], 1.0, LAMBERT(0.5), 0.0).build();
        let hit = closest_hit(&scene, [0.0; 3], [0.0, 0.0, 1.0]).expect("a hit");
        assert!((hit.t - case.value).abs() <= 4.0 * f64::EPSILON * case.value, "{id}: {} for {}", hit.t, case.value);
        assert_eq!(hit.prim, 0);
    }
}

#[test]
fn barycentrics_and_order_are_the_scenes() {
    let p = [[0.0, 0.0, -2.0], [1.0, 0.0, -2.0], [0.0, 1.0, -2.0]];
    let far = p.map(|[x, y, z]| [x, y, z - 1.0]);
    let scene = SceneBuilder::new().triangle(far, LAMBERT(0.5), 0.0).triangle(p, LAMBERT(0.5), 0.0);
    let scene = scene.triangle(p, LAMBERT(0.5), 0.0).sphere([0.2, 0.3, 5.0], 1.0, LAMBERT(0.5), 0.0).build();
    // A direction that is not a unit vector: t counts its lengths.
    let hit = closest_hit(&scene, [0.25, 0.5, 0.0], [0.0, 0.0, -0.5]).expect("a hit");
    assert_eq!((hit.t, hit.prim, hit.u, hit.v), (4.0, 1, 0.25, 0.5), "the first of two equal ones");
    // 0.2 and 0.3 are rounded to f32 in the scene: the nearest point is off by the square of that.
    let up = |z: f64| closest_hit(&scene, [0.2, 0.3, z], [0.0, 0.0, 1.0]).expect("a hit");
    assert!((up(0.0).t - 4.0).abs() < 1e-14 && (up(5.0).t - 1.0).abs() < 1e-14, "from outside and from inside");
    assert_eq!((up(0.0).prim, up(5.0).prim), (3, 3), "spheres come after triangles");
    assert_eq!(closest_hit(&scene, [2.0, 0.3, 0.0], [0.0, 0.0, 1.0]), None);
    assert_eq!(closest_hit(&scene, [0.25, 0.5, -4.0], [0.0, 0.0, 1.0]).map(|h| h.prim), Some(0), "both sides");
}

#[test]
fn closed_meshes_are_watertight() {
    let scene = SceneBuilder::new().cuboid([-1.0; 3], [1.0; 3], false, |_| (LAMBERT(0.5), 0.0)).build();
    let geometry = Geometry::new(&scene);
    let mut rng = Rng::new(2);
    for i in 0..20_000 {
        let origin = [rng.range(-0.9, 0.9), rng.range(-0.9, 0.9), rng.range(-0.9, 0.9)];
        // Every second ray at an edge or a face's diagonal, as exactly as rounding allows.
        let s = rng.range(-1.0, 1.0);
        let target = [[1.0, 1.0, s], [s, s, 1.0], [-1.0, s, -1.0], [s, -s, -1.0]][i / 2 % 4];
        let dir = if i % 2 == 0 { rng.sphere() } else { (V3(target) - V3(origin)).0 };
        assert!(geometry.trace(origin, dir, 0.0).is_some(), "{origin:?} → {dir:?}");
    }
}

#[test]
fn environment_texels_are_where_the_format_says() {
    let (width, height) = (8, 4);
    let texels: Vec<[f32; 3]> = (0..32).map(|i| [i as f32, (i * i) as f32, 1.0]).collect();
    let scene = SceneBuilder::new()
        .environment(Environment::Image(EnvironmentImage { width, height, texels, rotation: 0.0 }))
        .build();
    let towards = |u: f64, v: f64| {
        let (s, c) = (PI * v).sin_cos();
        environment_radiance(&scene, [s * (TAU * u).sin(), c, -s * (TAU * u).cos()])
    };
    let centre = |i: usize, j: usize| towards((i as f64 + 0.5) / 8.0, (j as f64 + 0.5) / 4.0);
    for (i, j) in [(0, 0), (7, 0), (3, 1), (7, 3), (4, 2)] {
        let texel = (j * 8 + i) as f64;
        assert!(
            (centre(i, j)[0] - texel).abs() < 1e-12 && (centre(i, j)[1] - texel * texel).abs() < 1e-10,
            "({i}, {j})"
        );
    }
    assert!((towards(0.0, 0.375)[0] - (8.0 + 15.0) / 2.0).abs() < 1e-12, "wraps in u");
    assert!(
        (towards(0.0625, 0.01)[0] - 0.0).abs() < 1e-12 && (towards(0.0625, 0.99)[0] - 24.0).abs() < 1e-12,
        "clamped in v"
    );
    assert!((towards(0.0625, 0.25)[0] - 4.0).abs() < 1e-12, "half way between rows 0 and 1");
    // u = 0 looks to −z, u = ¼ to +x, row 0 to +y.
    assert!((environment_radiance(&scene, [1.0, 0.0, 0.0])[0] - towards(0.25, 0.5)[0]).abs() < 1e-12);
}

#[test]
fn frames_are_orthonormal() {
    let mut rng = Rng::new(9);
    for _ in 0..1_000 {
        let (n, w) = (V3(rng.sphere()), V3(rng.sphere()));
        let frame = Frame::about(n);
        assert!((frame.to_world(frame.to_local(w)) - w).length() < 1e-15 * 10.0);
        assert!((frame.to_local(n) - V3::Z).length() < 1e-15 * 10.0);
        let (x, y) = (frame.to_world(V3::new(1.0, 0.0, 0.0)), frame.to_world(V3::new(0.0, 1.0, 0.0)));
        assert!((x.cross(y) - n).length() < 1e-15 * 10.0, "right-handed");
    }
}

#[test]
fn points_on_primitives_are_uniform() {
    let p = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 3.0]];
    let scene =
        SceneBuilder::new().triangle(p, LAMBERT(0.5), 0.0).sphere([5.0, 0.0, 0.0], 2.0, LAMBERT(0.5), 0.0).build();
    let geometry = Geometry::new(&scene);
    assert_eq!((geometry.area(0), geometry.area(1)), (3.0, 16.0 * PI));
    let mut rng = Rng::new(4);
    let mut moments = [Moments::new(); 4];
    for _ in 0..20_000 {
        let u = [rng.f64(), rng.f64()];
        let (p, n) = geometry.point_on(0, u);
        assert!(
            p.x() >= 0.0 && p.z() >= 0.0 && p.x() / 2.0 + p.z() / 3.0 < 1.0 + 1e-12 && n == V3::new(0.0, -1.0, 0.0)
        );
        moments[0].push(p.x());
        moments[1].push(p.x() * p.x());
        let (q, n) = geometry.point_on(1, u);
        assert!(((q - V3::new(5.0, 0.0, 0.0)) - n * 2.0).length() < 1e-12);
        moments[2].push(n.x() * n.x());
        moments[3].push(n.z());
    }
    // ∫x = w/3, ∫x² = w²/6 over a triangle of width w = 2.
    for (m, want) in moments.iter().zip([2.0 / 3.0, 4.0 / 6.0, 1.0 / 3.0, 0.0]) {
        assert_mean("point", m, want, 0.0, 4);
    }
}
