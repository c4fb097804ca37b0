//! Vertex normals that do not fit the geometry: no light leaks, none is made, and towards the geometry's horizon it fades.

use super::TESTS;
use crate::equivalence::scenes::ball;
use crate::oracle::tilted_lambert;
use crate::renders::{self, Set, assert_image_mean, image_mean};
use crate::stats::z_bound;
use octolux::film::Film;
use octolux::scene::{Bsdf, ConductorFresnel, DeltaLight, IntegratorKind, Masking, Scene};

const SIDE: u32 = 48;

fn materials() -> [(&'static str, Bsdf); 6] {
    let white = ConductorFresnel::Constant { reflectance: [1.0; 3] };
    let coat = |alpha| Bsdf::Coated { reflectance: [1.0; 3], alpha, masking: Masking::Correlated, ior: 1.5 };
    [
        ("diffuse", Bsdf::Diffuse { reflectance: [1.0; 3] }),
        ("phong", Bsdf::Phong { diffuse: [0.4; 3], specular: [0.6; 3], exponent: 20.0 }),
        ("coat", coat(0.2)),
        ("smooth coat", coat(0.0)),
        ("metal", Bsdf::Conductor { alpha: 0.3, masking: Masking::Correlated, fresnel: white }),
        ("mirror", Bsdf::Conductor { alpha: 0.0, masking: Masking::Correlated, fresnel: white }),
    ]
}

fn lights(set: Set, at: [f32; 3]) -> Set {
    set.light(DeltaLight::Point { position: at, intensity: [50.0; 3] }).light(DeltaLight::Spot {
        position: at,
        direction: [0.0, 0.0, 1.0],
        intensity: [90.0; 3],
        angle: 80.0,
    })
}

fn film(set: Set, samples: u64) -> Film {
    renders::film(&renders::world(&set.finish(), 51), samples)
}

#[track_caller]
fn assert_black(name: &str, film: &Film) {
    for (x, y) in (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y))) {
        assert_eq!(film.mean(x, y), [0.0; 3], "{name} leaks in pixel ({x}, {y})");
    }
}

/// Lamps of every kind sealed in a ball: outside, every pixel is exactly 0; by light samples and by chance alike (a lamp
/// that fills the ball is found by chance at once).
#[test]
fn nothing_leaves_a_sealed_ball() {
    for (seed, (name, bsdf)) in materials().into_iter().enumerate() {
        for radius in [0.1, 0.9] {
            let mut set = Set::new([0.4, 0.9, 3.0], [0.0; 3], 45.0, SIDE).bounces(6);
            let wall = set.material(bsdf, [0.0; 3]);
            let lamp = set.grey(0.5, 100.0);
            set.sphere(lamp, [0.0; 3], radius);
            ball(&mut set, &[wall], 5, seed as u64);
            assert_black(&format!("{name}, lamp of {radius}"), &film(lights(set, [0.0, 0.0, -0.95]), 16));
        }
    }
}

/// A sky, suns and lamps outside; inside, every pixel is exactly 0.
#[test]
fn nothing_enters_a_sealed_ball() {
    for (seed, (name, bsdf)) in materials().into_iter().enumerate() {
        let mut set = Set::new([0.1, -0.2, 0.3], [0.0, 0.0, -1.0], 100.0, SIDE).bounces(6).uniform_light();
        let wall = set.material(bsdf, [0.0; 3]);
        let lamp = set.grey(0.5, 100.0);
        set.sphere(lamp, [1.7, 0.0, 0.0], 0.6);
        ball(&mut set, &[wall], 5, 100 + seed as u64);
        let sun = DeltaLight::Directional { direction: [0.6, -0.8, 0.0], irradiance: [30.0; 3] };
        assert_black(name, &film(lights(set, [0.0, 0.0, -1.2]).light(sun), 16));
    }
}

/// The tests above would see a leak: with the lamp let out by one missing triangle, they do.
#[test]
fn a_hole_is_seen() {
    let mut set = Set::new([0.4, 0.9, 3.0], [0.0; 3], 45.0, SIDE).bounces(6);
    let wall = set.material(materials()[0].1, [0.0; 3]);
    let lamp = set.grey(0.5, 100.0);
    set.sphere(lamp, [0.0; 3], 0.1);
    ball(&mut set, &[wall], 5, 0);
    let mut scene = set.finish();
    scene.mesh.triangles.remove(0);
    scene.mesh.material.remove(0);
    scene.mesh.normal_indices.remove(0);
    let film = renders::film(&renders::world(&scene, 51), 16);
    assert!((0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))).any(|(x, y)| film.mean(x, y)[0] > 0.0));
}

/// A ball that reflects all, in a white sky, and the inside of one that emits what it does not reflect: at most 1, whatever
/// the normals.
#[test]
fn no_light_is_made() {
    for (seed, (name, bsdf)) in materials().into_iter().enumerate() {
        let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 12.0, SIDE).bounces(20).uniform_light();
        let wall = set.material(bsdf, [0.0; 3]);
        ball(&mut set, &[wall], 4, 200 + seed as u64);
        let outside = film(set, 256);
        for e in image_mean(&outside) {
            let limit = 1.0 + z_bound(TESTS) * e.std_error + 1e-5;
            assert!(e.mean > 0.02 && e.mean <= limit, "{name}: {e:?}");
        }
    }
    let mut set = Set::new([0.1, 0.2, 0.3], [0.0, 0.0, -1.0], 90.0, SIDE).bounces(60);
    let wall = set.grey(0.5, 0.0);
    ball(&mut set, &[wall], 4, 300);
    let mut scene = set.finish();
    // Emission is from the front; the ball is turned inside out.
    scene.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    scene.mesh.normal_indices.iter_mut().for_each(|t| t.swap(1, 2));
    scene.materials[0].emission = [0.5; 3];
    for e in image_mean(&renders::film(&renders::world(&scene, 52), 256)) {
        assert!(e.mean > 0.5 && e.mean <= 1.0 + z_bound(TESTS) * e.std_error + 1e-5, "inside: {e:?}");
    }
}

/// A flat patch whose normals lean: the integral under a sky by quadrature, and under a sun the factor itself.
#[test]
fn light_fades_towards_the_horizon_of_the_geometry() {
    let patch = |degrees: f64, bounces: u32| {
        let (s, c) = degrees.to_radians().sin_cos();
        let mut set = Set::new([0.0, 1.0, 0.0], [0.0; 3], 5.0, 8).bounces(bounces);
        let half = set.grey(0.5, 0.0);
        set.smooth_triangle(half, [[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [0.0, 0.0, -9.0]], [[s, c, 0.0]; 3]);
        set
    };
    for degrees in [0.0f64, 10.0, 30.0, 60.0] {
        let expected = 0.5 * tilted_lambert(degrees.to_radians());
        let film = film(patch(degrees, 2).uniform_light(), 4096);
        assert_image_mean(&format!("leaning by {degrees}"), &film, [expected; 3], 1e-6, TESTS);
        for sun in [-80f64, -20.0, 0.0, 35.0, 70.0, 88.0, 91.0] {
            let (s, c) = sun.to_radians().sin_cos();
            let direction = [-s as f32, -c as f32, 0.0];
            let set = patch(degrees, 1).light(DeltaLight::Directional { direction, irradiance: [2.0; 3] });
            let leaning = (sun - degrees).to_radians().cos();
            let g = (c / (leaning * degrees.to_radians().cos())).min(1.0);
            let lit = c > 0.0 && leaning > 0.0;
            let expected = if lit { leaning / std::f64::consts::PI * (g + g * g - g * g * g) } else { 0.0 };
            let film = renders::film(&renders::world(&set.finish(), 53), 2);
            assert_image_mean(&format!("leaning by {degrees}, sun at {sun}"), &film, [expected; 3], 2e-6, TESTS);
        }
    }
}

/// A coarse smooth ball: its vertices are their own normals, times `sign`.
fn coarse(mut set: Set, sign: f32) -> Scene {
    let white = set.grey(0.8, 0.0);
    ball(&mut set, &[white], 3, 0);
    let mut scene = set.finish();
    scene.mesh.normals = scene.mesh.positions.iter().map(|p| p.map(|x| x * sign)).collect();
    scene
}

/// Where the facets of a coarse ball face the viewer and its normals no longer do, the rim is not black.
#[test]
fn rims_are_not_black() {
    let set = || Set::new([0.0, 0.0, 4.0], [0.66, 0.66, 0.0], 6.0, SIDE).bounces(2).uniform_light();
    let film = renders::film(&renders::world(&coarse(set(), 1.0), 54), 256);
    let pixels = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let darkest = pixels().map(|(x, y)| film.mean(x, y)[0]).fold(1.0, f64::min);
    let dim = pixels().filter(|&(x, y)| film.mean(x, y)[0] < 0.9).count();
    assert!(darkest > 0.25 && dim > 100, "{darkest}, {dim} pixels of the ball");
    // Normals that all point inwards are meant to point outwards.
    let inwards = renders::film(&renders::world(&coarse(set(), -1.0), 54), 256);
    assert!(pixels().all(|(x, y)| film.mean(x, y) == inwards.mean(x, y)));
}

/// The views have no light to fade: they show what they did.
#[test]
fn views_do_not_know_of_it() {
    let mut set = Set::new([0.4, 0.9, 3.0], [0.0; 3], 45.0, 16).integrator(IntegratorKind::Hit);
    let wall = set.grey(0.5, 0.0);
    ball(&mut set, &[wall], 5, 0);
    let film = film(set, 4);
    assert_eq!(film.mean(8, 8), [1.0; 3]);
}
