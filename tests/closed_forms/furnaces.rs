//! Convex objects in a uniform environment of radiance 1: what they show is their albedo.

use super::{TESTS, rounding};
use crate::renders::{self, Set, assert_image_mean};
use crate::stats;
use octolux::bsdf::ALPHA_MIN;
use octolux::film::Film;
use octolux::scene::{self, Bsdf, ConductorFresnel, Environment, EnvironmentImage, FilmSize, Masking};
use std::path::Path;

const SEED: u64 = 12;

/// A sphere that fills the film, in a uniform environment.
fn close_up(bsdf: Bsdf, bounces: u32) -> Set {
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 20.0, 16).bounces(bounces).uniform_light();
    let material = set.material(bsdf, [0.0; 3]);
    set.sphere(material, [0.0; 3], 1.0);
    set
}

/// The unit sphere of `refs/furnace_*`, whose image holds sphere and environment.
fn furnace(bsdf: Bsdf, bounces: u32, samples: u64) -> Film {
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 40.0, 64).bounces(bounces).uniform_light();
    let material = set.material(bsdf, [0.0; 3]);
    set.sphere(material, [0.0; 3], 1.0);
    renders::film(&renders::world(&set.finish(), SEED), samples)
}

fn metal(alpha: f32, masking: Masking, reflectance: [f32; 3]) -> Bsdf {
    Bsdf::Conductor { alpha, masking, fresnel: ConductorFresnel::Constant { reflectance } }
}

#[test]
fn lambert_shows_its_reflectance() {
    for id in ["C.furnace_lambert_0", "C.furnace_lambert_0.18", "C.furnace_lambert_0.5", "C.furnace_lambert_0.8"] {
        let Some(case) = stats::oracle(id) else { return };
        let bsdf = Bsdf::Diffuse { reflectance: [case.value as f32; 3] };
        let film = renders::film(&renders::world(&close_up(bsdf, 7).finish(), SEED), 4096);
        assert_image_mean(id, &film, [case.value; 3], rounding(case.value, 1), TESTS);
    }
}

/// A mirror and a black body have nothing to be noisy about.
#[test]
fn mirrors_and_black_bodies_are_exact() {
    let colours = [[1.0, 0.5, 0.25], [0.0, 0.1, 0.9]];
    let cases = colours.map(|c| (metal(0.0, Masking::Correlated, c), c));
    let black = (Bsdf::Diffuse { reflectance: [0.0; 3] }, [0.0; 3]);
    for (bsdf, expected) in cases.into_iter().chain([black]) {
        let film = renders::film(&renders::world(&close_up(bsdf, 7).finish(), SEED), 4);
        for (x, y) in [(0, 0), (7, 9), (15, 15)] {
            assert_eq!(film.mean(x, y), expected.map(f64::from));
            assert_eq!(film.variance_of_mean(x, y), Some([0.0; 3]));
        }
    }
}

/// Where α passes the bound below which the lobe is a mirror the image does not jump: a direction turns by πα on average, as the
/// facets' slopes have the mean πα/2, and the sky's radiance changes by no more than its gradient times that. The same numbers
/// place both renders' camera rays.
#[test]
fn the_image_does_not_jump_where_a_lobe_becomes_a_mirror() {
    const ROWS: usize = 4;
    const SAMPLES: u64 = 4096;
    let radiance = [1.0f32, 0.2, 0.9, 0.1];
    let texels = (0..ROWS).flat_map(|row| [[radiance[row]; 3]; 2]).collect();
    let sky = Environment::Image(EnvironmentImage { width: 2, height: ROWS, texels, rotation: 0.0 });
    let gradient = 0.8 * ROWS as f64 / std::f64::consts::PI;
    let image = |alpha: f32| {
        let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 20.0, 16).bounces(1).environment(sky.clone());
        let material = set.material(metal(alpha, Masking::Correlated, [1.0; 3]), [0.0; 3]);
        set.sphere(material, [0.0; 3], 1.0);
        renders::film(&renders::world(&set.finish(), SEED), SAMPLES)
    };
    let difference = |a: &Film, b: &Film| {
        let pixels = (0..16).flat_map(|y| (0..16).map(move |x| (x, y)));
        pixels.map(|(x, y)| (a.mean(x, y)[0] - b.mean(x, y)[0]).abs()).sum::<f64>() / 256.0
    };
    let mirror = image(ALPHA_MIN.next_down());
    let contrast = difference(&mirror, &image(0.5));
    assert!(contrast > 0.03, "there is something to see: {contrast}");
    for alpha in [ALPHA_MIN, 1e-3] {
        let turn = std::f64::consts::PI * f64::from(alpha);
        let jump = difference(&mirror, &image(alpha));
        assert!(jump <= gradient * turn + rounding(1.0, 1), "α {alpha}: {jump:e}, {:e} allowed", gradient * turn);
        assert!(jump > 0.0, "α {alpha} is a mirror");
    }
}

/// Image means by quadrature (`refs/README.md`), to the five digits given there.
#[test]
fn rough_metal_loses_what_it_scatters_twice() {
    let cases = [(0.2, 0.96557, 0.96634), (0.5, 0.87740, 0.88187), (1.0, 0.75446, 0.76779)];
    for (alpha, separable, correlated) in cases {
        for (masking, expected) in [(Masking::Separable, separable), (Masking::Correlated, correlated)] {
            let film = furnace(metal(alpha, masking, [1.0; 3]), 7, 2048);
            assert_image_mean(&format!("GGX α {alpha} {masking:?}"), &film, [expected; 3], 0.5e-5, TESTS);
        }
    }
}

/// The scene as it is shipped is one of these.
#[test]
fn furnace_as_shipped() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/furnace/scene.toml");
    let mut scene = scene::load(&path).expect("the scene loads");
    scene.film = FilmSize { width: 64, height: 64 };
    let film = renders::film(&renders::world(&scene, SEED), 1024);
    assert_image_mean("scenes/furnace", &film, [0.88187; 3], 0.5e-5, TESTS);
}

#[test]
fn rough_glass_loses_what_it_scatters_twice() {
    for (masking, expected) in [(Masking::Separable, 0.81919), (Masking::Correlated, 0.82480)] {
        let film = furnace(Bsdf::Dielectric { alpha: 0.5, masking, ior: 1.5 }, 63, 2048);
        assert_image_mean(&format!("rough glass {masking:?}"), &film, [expected; 3], 0.5e-5, TESTS);
    }
}

/// Nothing is lost in smooth glass, however long the path.
#[test]
fn smooth_glass_is_invisible() {
    for ior in [1.1, 1.5, 2.4, 0.75] {
        let film = furnace(Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior }, 400, 256);
        assert_image_mean(&format!("glass, index {ior}"), &film, [1.0; 3], rounding(1.0, 10), TESTS);
    }
}
