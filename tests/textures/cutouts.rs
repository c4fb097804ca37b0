//! Surfaces that rays may pass: what gets through, for path and shadow rays, with a tree and without.

use super::*;
use crate::renders::{self, assert_image_mean, film, forced, world};
use octolux::plan::{Force, GeometryMode};
use octolux::scene::{Bsdf, Scene};

const SEED: u64 = 31;

/// Renders with and without a tree, which must not show, and returns the film.
fn render(scene: &Scene, samples: u64) -> octolux::film::Film {
    let mode = |mode| Force { general: false, geometry: Some(mode) };
    let brute = film(&forced(scene, SEED, mode(GeometryMode::Brute)), samples);
    let tree = film(&forced(scene, SEED, mode(GeometryMode::Tree)), samples);
    for (x, y) in (0..brute.height()).flat_map(|y| (0..brute.width()).map(move |x| (x, y))) {
        assert_eq!(brute.mean(x, y), tree.mean(x, y), "pixel {x}, {y} with and without a tree");
    }
    brute
}

/// A wall across the view.
fn wall(z: f64) -> [Point; 4] {
    [[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]]
}

/// Black walls in a row, each of opacity d: (1 − d)ⁿ of the environment is seen through them.
#[test]
fn walls_in_a_row() {
    for (opacity, count) in [(0.5f32, 1), (0.5, 4), (0.125, 12), (1.0, 2), (0.0, 3)] {
        let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 40.0, 16).bounces(2).uniform_light();
        let black = set.grey(0.0, 0.0);
        edit(&mut set, black).opacity = opacity;
        for i in 0..count {
            // Tilted, so that the diagonal of one is not behind that of another; facing either way.
            let mut corners = wall(-f64::from(i));
            corners[0][2] -= 0.3 * f64::from(i);
            if i % 2 == 1 {
                corners.reverse();
            }
            set.quad(black, corners);
        }
        let expected = (1.0 - f64::from(opacity)).powi(count);
        let film = render(&complete(set), 1024);
        assert_image_mean(&format!("{count} walls of opacity {opacity}"), &film, [expected; 3], 1e-9, TESTS);
    }
}

/// More walls than a packet has lanes, all of them invisible: nothing is lost on the way.
#[test]
fn a_hundred_invisible_walls() {
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0, 0.0, -500.0], 4.0, 8).bounces(1).uniform_light();
    let glass = set.grey(0.5, 0.0);
    edit(&mut set, glass).opacity = 0.0;
    let white = set.grey(0.5, 0.0);
    for i in 0..100 {
        set.quad(glass, wall(-0.01 * f64::from(i)));
    }
    set.quad(white, wall(-20.0));
    let film = render(&complete(set), 256);
    assert_image_mean("behind a hundred", &film, [0.5; 3], 1e-5, TESTS);
}

/// A ray crosses a sphere twice, and each crossing is decided on its own.
#[test]
fn a_sphere_is_passed_twice() {
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 10.0, 16).bounces(2).uniform_light();
    let black = set.grey(0.0, 0.0);
    edit(&mut set, black).opacity = 0.25;
    set.sphere(black, [0.0; 3], 1.0);
    let film = render(&complete(set), 2048);
    assert_image_mean("through a sphere", &film, [0.5625; 3], 1e-9, TESTS);
}

/// What is seen through an invisible sphere is where it is without: the far side of a sphere is passed where the ray meets it.
#[test]
fn an_invisible_sphere_moves_nothing() {
    let scene = |opacity: Option<f32>| {
        let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 30.0, 16).bounces(1).uniform_light();
        let (white, black) = (set.grey(1.0, 0.0), set.grey(0.0, 0.0));
        for i in 0..16 {
            let (left, right) = (-2.0 + 0.25 * f64::from(i), -1.75 + 0.25 * f64::from(i));
            let stripe = if i % 2 == 0 { white } else { black };
            set.quad(stripe, [[left, -2.0, -1.0], [right, -2.0, -1.0], [right, 2.0, -1.0], [left, 2.0, -1.0]]);
        }
        if let Some(opacity) = opacity {
            let ghost = set.grey(0.5, 0.0);
            edit(&mut set, ghost).opacity = opacity;
            set.sphere(ghost, [0.2, 0.1, 0.3], 0.9);
        }
        complete(set)
    };
    let (with, without) = (render(&scene(Some(0.0)), 256), render(&scene(None), 256));
    for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
        // A ray may meet the rim between two stripes on either side.
        let (a, b) = (with.mean(x, y)[0], without.mean(x, y)[0]);
        assert!((a - b).abs() <= 0.01, "pixel {x}, {y}: {a} for {b}");
    }
}

/// Half the image is a hole: rays pass where it is 0 and nowhere else, and in between in proportion.
#[test]
fn an_image_says_where() {
    let side = 2.0 * (0.5f64 / 3.0).atan().to_degrees();
    let mut set = Set::new([0.5, 0.5, 3.0], [0.5, 0.5, 0.0], side, 16).bounces(1).uniform_light();
    let black = set.grey(0.0, 0.0);
    edit(&mut set, black).maps.opacity = Some(grey_image(8, 1, |x, _| if x < 4 { 0.0 } else { 1.0 }));
    mapped_quad(&mut set, black, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let film = render(&complete(set), 256);
    for y in 0..16 {
        // The image is blurred over half a texel, a pixel, on both sides of its seams.
        assert!((2..7).all(|x| film.mean(x, y) == [1.0; 3]) && (9..14).all(|x| film.mean(x, y) == [0.0; 3]), "row {y}");
    }
    assert_image_mean("half a hole", &film, [0.5; 3], 1e-9, TESTS);
}

/// A white receiver under a lamp behind walls of opacity d: shadow rays take the product, paths that find the lamp by
/// the BSDF decide wall by wall, and both count (1 − d)ⁿ of the lamp.
#[test]
fn light_through_walls() {
    let Some(case) = crate::stats::oracle("A.sq_par_h1") else { return };
    for (opacity, count) in [(0.5f32, 1), (0.25, 3), (0.0, 2), (1.0, 1)] {
        let mut set = Set::new([-2.0, 0.0, 0.1], [0.0; 3], 1e-4, 8).bounces(1);
        let (ground, lamp, black) = (set.grey(1.0, 0.0), set.grey(0.0, 1.0), set.grey(0.0, 0.0));
        edit(&mut set, black).opacity = opacity;
        set.triangle(ground, [[-0.01, -0.01, 0.0], [0.02, -0.01, 0.0], [-0.01, 0.02, 0.0]]);
        set.quad(lamp, [[-0.5, 0.5, 1.0], [0.5, 0.5, 1.0], [0.5, -0.5, 1.0], [-0.5, -0.5, 1.0]]);
        for i in 0..count {
            set.quad(black, wall(0.3 + 0.2 * f64::from(i)));
        }
        let expected = case.value / std::f64::consts::PI * (1.0 - f64::from(opacity)).powi(count);
        let film = render(&complete(set), 8192);
        assert_image_mean(&format!("lamp behind {count} of {opacity}"), &film, [expected; 3], expected * 1e-5, TESTS);
    }
}

/// Shadow rays to infinity.
#[test]
fn sky_through_a_wall() {
    let mut set = Set::new([0.0, 0.0, 1.0], [0.0; 3], 20.0, 8).bounces(1).uniform_light();
    let (white, black) = (set.grey(1.0, 0.0), set.grey(0.0, 0.0));
    edit(&mut set, black).opacity = 0.75;
    set.quad(white, [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    // A tent without gaps above the camera: nothing reaches the ground but through it, once.
    set.block(black, [-2.0, -2.0, -1.0], [2.0, 2.0, 3.0]);
    let film = render(&complete(set), 4096);
    assert_image_mean("sky through a tent", &film, [0.25; 3], 1e-6, TESTS);
}

/// What is there with probability d scatters and emits d of what it would.
#[test]
fn a_lamp_that_is_half_there() {
    let Some(case) = crate::stats::oracle("A.sq_par_h0.5") else { return };
    let mut set = Set::new([-2.0, 0.0, 0.1], [0.0; 3], 1e-4, 8).bounces(1);
    let (ground, lamp) = (set.grey(1.0, 0.0), set.grey(0.0, 1.0));
    edit(&mut set, lamp).opacity = 0.375;
    set.triangle(ground, [[-0.01, -0.01, 0.0], [0.02, -0.01, 0.0], [-0.01, 0.02, 0.0]]);
    set.quad(lamp, [[-0.5, 0.5, 0.5], [0.5, 0.5, 0.5], [0.5, -0.5, 0.5], [-0.5, -0.5, 0.5]]);
    let expected = 0.375 * case.value / std::f64::consts::PI;
    let film = render(&complete(set), 8192);
    assert_image_mean("a lamp of opacity .375", &film, [expected; 3], expected * 2e-5, TESTS);
}

/// In a furnace a white surface shows radiance 1, however much of it is there; passing is not a bounce.
#[test]
fn furnace() {
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 40.0, 16).bounces(1).uniform_light();
    let white = set.material(Bsdf::Diffuse { reflectance: [1.0; 3] }, [0.0; 3]);
    edit(&mut set, white).opacity = 0.5;
    set.quad(white, wall(0.0));
    let film = render(&complete(set), 512);
    assert_image_mean("half a wall in a furnace", &film, [1.0; 3], 1e-5, TESTS);
}

/// The view of what is hit sees holes, too.
#[test]
fn views_see_holes() {
    let kind = octolux::scene::IntegratorKind::Hit;
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 40.0, 16).integrator(kind);
    let grey = set.grey(0.5, 0.0);
    edit(&mut set, grey).opacity = 0.5;
    set.quad(grey, wall(0.0));
    let film = renders::film(&world(&complete(set), SEED), 1024);
    assert_image_mean("hits of half a wall", &film, [0.5; 3], 1e-9, TESTS);
}
