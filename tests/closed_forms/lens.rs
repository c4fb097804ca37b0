//! The thin lens: what is in focus is sharp, what is not is spread over a disk of known size.

use super::TESTS;
use crate::renders::{self, Set, assert_image_mean};
use octolux::kernel::Camera;
use octolux::scene::{self, FilmSize};
use std::f64::consts::FRAC_1_PI;

fn camera(lens_radius: f32, focus_distance: f32) -> scene::Camera {
    scene::Camera {
        position: [0.3, -0.2, 1.5],
        look_at: [0.1, 0.4, -1.0],
        up: [0.0, 1.0, 0.0],
        vfov: 50.0,
        lens_radius,
        focus_distance,
    }
}

/// Where rays of one film position are at a distance along the axis, for points of the lens about a circle.
fn spread(lens_radius: f32, focus: f32, distance: f64) -> Vec<[f64; 3]> {
    let film = FilmSize { width: 40, height: 30 };
    let scene = camera(lens_radius, focus);
    let camera = Camera::new(&scene, film, 1.0);
    let axis: [f64; 3] = std::array::from_fn(|k| f64::from(scene.look_at[k]) - f64::from(scene.position[k]));
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let reach = |k: u32| {
        let ray = camera.lens_ray::<f32>(31.0, 7.5, [1.0 - f32::EPSILON / 2.0, k as f32 / 64.0]);
        let (o, d) = (ray.origin.lane(0).map(f64::from), ray.direction.lane(0).map(f64::from));
        let along = |v: [f64; 3]| (0..3).map(|i| v[i] * axis[i]).sum::<f64>() / length;
        let from_camera: [f64; 3] = std::array::from_fn(|i| o[i] - f64::from(scene.position[i]));
        assert!(along(from_camera).abs() < 1e-6, "the lens is perpendicular to the axis");
        let t = (distance - along(from_camera)) / along(d);
        std::array::from_fn(|i| o[i] + t * d[i])
    };
    (0..64).map(reach).collect()
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The diameter at distance z is 2 R |z − f|/f, nothing in the plane of focus.
#[test]
fn rays_of_a_film_position_meet_in_the_plane_of_focus() {
    for (radius, focus) in [(0.1f32, 2.0f32), (0.4, 0.7), (1e-3, 30.0)] {
        for factor in [0.0, 0.5, 1.0, 1.25, 3.0] {
            let z = f64::from(focus) * factor;
            let points = spread(radius, focus, z);
            let center = mean(&points);
            let expected = f64::from(radius) * (factor - 1.0).abs();
            // Directions are off by 2⁻²³ at a distance of z/cos, origins by 2⁻²³ of their size.
            let allowed = 4e-7 * (2.0 + 2.0 * z) + 1e-6 * expected;
            for p in &points {
                let r = distance(*p, center);
                assert!((r - expected).abs() < allowed, "radius {radius}, focus {focus}, z {z}: {r} for {expected}");
            }
        }
    }
}

/// The part of a disk of radius 1 on one side of a line at signed distance `d` from its centre.
fn disk_beyond(d: f64) -> f64 {
    let d = d.clamp(-1.0, 1.0);
    0.5 - FRAC_1_PI * (d * (1.0 - d * d).sqrt() + d.asin())
}

/// The edge of a bright half-plane, seen along the axis from beside it by `offset`.
fn edge(lens_radius: f32, focus_distance: f32, z: f64, offset: f64) -> Set {
    let mut set = Set::new([0.0, 0.0, z], [0.0, 0.0, 0.0], 1e-5, 4).bounces(0).lens(lens_radius, focus_distance);
    let lamp = set.grey(0.0, 1.0);
    set.quad(lamp, [[offset, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [offset, 9.0, 0.0]]);
    set
}

/// Out of focus, each pixel sees the mean over a disk, its circle of confusion in that plane.
#[test]
fn edges_blur_by_the_circle_of_confusion() {
    for (radius, focus, z) in [(0.2, 1.0, 2.0), (0.2, 4.0, 2.0), (0.05, 1.5, 3.0)] {
        let confusion = f64::from(radius) * (z - f64::from(focus)).abs() / f64::from(focus);
        for d in [-0.9, -0.5, 0.0, 0.3, 0.7, 0.95] {
            let film = renders::film(&renders::world(&edge(radius, focus, z, d * confusion).finish(), 43), 16_384);
            // A pixel is 1e-5 degrees wide, 3e-7 of the scene: at most 1e-5 of the disk.
            let name = format!("lens {radius}, focus {focus}, edge at {d}");
            assert_image_mean(&name, &film, [disk_beyond(d); 3], 2e-5, TESTS);
        }
        for beyond in [-1.02, 1.02] {
            let film = renders::film(&renders::world(&edge(radius, focus, z, beyond * confusion).finish(), 43), 4096);
            let expected = if beyond < 0.0 { 1.0 } else { 0.0 };
            assert_image_mean("outside the circle", &film, [expected; 3], 0.0, TESTS);
        }
    }
}

/// In the plane of focus a lens of any size sees what a pinhole sees.
#[test]
fn what_is_in_focus_is_sharp() {
    for offset in [-2e-5, 2e-5] {
        let film = renders::film(&renders::world(&edge(0.3, 2.0, 2.0, offset).finish(), 44), 1024);
        assert_image_mean("in focus", &film, [if offset < 0.0 { 1.0 } else { 0.0 }; 3], 0.0, TESTS);
    }
    // And the lens lets every direction through alike: a uniform sky stays one.
    let set = Set::new([0.0; 3], [0.0, 0.0, -1.0], 60.0, 8).lens(0.5, 3.0).uniform_light();
    let film = renders::film(&renders::world(&set.finish(), 45), 64);
    assert_image_mean("sky", &film, [1.0; 3], 0.0, TESTS);
}

/// The lens is a stage: without one the camera's rays start at a point.
#[test]
fn a_pinhole_is_a_lens_of_no_size() {
    let film = FilmSize { width: 16, height: 12 };
    let camera = Camera::new(&camera(0.0, 2.0), film, 1.0);
    for (x, y, turn) in [(0.5, 0.5, 0.1), (7.3, 11.0, 0.9), (16.0, 0.0, 0.4)] {
        let (pinhole, lens) = (camera.ray::<f32>(x, y), camera.lens_ray::<f32>(x, y, [0.7, turn]));
        assert_eq!(pinhole.origin.lane(0), lens.origin.lane(0));
        let [a, b] = [pinhole, lens].map(|ray| ray.direction.lane(0).map(f64::from));
        assert!(distance(a, b) < 4e-7);
    }
}
