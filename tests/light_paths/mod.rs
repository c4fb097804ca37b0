//! Paths from the lights beside those from the camera: the same expectations, found with less noise.

mod closed_forms;
mod plan;
mod weights;

use crate::renders::{self, Set};
use crate::stats;
use octolux::film::Film;
use octolux::kernel::Width;
use octolux::render::Outcome;
use octolux::sampling::SamplerKind;
use octolux::scene::{Bsdf, ConductorFresnel, LightPaths, Masking, Scene};

/// Means tested in this folder, rounded up: the family of Šidák's bound. Seeds are fixed.
const TESTS: usize = 1000;

fn with(mut scene: Scene, light_paths: LightPaths) -> Scene {
    scene.integrator.light_paths = light_paths;
    scene
}

/// Glass, a mirror, layered balls and a rough metal under a lamp and a bulb, in a room; every kind of vertex before every
/// other.
pub fn shop(lens: bool) -> Scene {
    let mut set = Set::new([0.4, 1.3, 3.4], [0.0, 0.6, 0.0], 55.0, 24).bounces(9);
    if lens {
        set = set.lens(0.08, 3.0);
    }
    let wall = set.material(Bsdf::Diffuse { reflectance: [0.6, 0.5, 0.4] }, [0.0; 3]);
    let lamp = set.material(Bsdf::Diffuse { reflectance: [0.3; 3] }, [9.0, 8.0, 7.0]);
    let bulb = set.material(Bsdf::Diffuse { reflectance: [0.0; 3] }, [3.0, 4.0, 5.0]);
    let glass = |alpha, ior| Bsdf::Dielectric { alpha, masking: Masking::Correlated, ior };
    let metal = |alpha| Bsdf::Conductor {
        alpha,
        masking: Masking::Separable,
        fresnel: ConductorFresnel::Schlick { f0: [0.9, 0.7, 0.5] },
    };
    let coat = |alpha| Bsdf::Coated { reflectance: [0.5, 0.2, 0.1], alpha, masking: Masking::Correlated, ior: 1.5 };
    let phong = Bsdf::Phong { diffuse: [0.3, 0.3, 0.2], specular: [0.4, 0.5, 0.6], exponent: 20.0 };
    set.room([wall; 6], [-2.0, 0.0, -2.0], [2.0, 2.4, 4.0]);
    set.quad(lamp, [[-0.4, 2.3, -0.4], [0.4, 2.3, -0.4], [0.4, 2.3, 0.4], [-0.4, 2.3, 0.4]]);
    set.sphere(bulb, [1.5, 1.7, 0.2], 0.15);
    for (i, bsdf) in
        [glass(0.0, 1.5), glass(0.3, 1.33), metal(0.0), metal(0.4), coat(0.0), coat(0.2), phong].into_iter().enumerate()
    {
        let material = set.material(bsdf, [0.0; 3]);
        let x = -1.4 + 0.45 * i as f64;
        set.sphere(material, [x, 0.35 + 0.15 * (i % 3) as f64, 0.5 * (i % 2) as f64], 0.3);
    }
    let pane = set.material(glass(0.0, 1.8), [0.0; 3]);
    set.block(pane, [-0.9, 1.2, -0.5], [0.1, 1.3, 0.5]);
    set.finish()
}

/// Sums of squares of both films' differences of means in blocks and their variances, as z.
fn assert_agree(name: &str, a: &Film, b: &Film, blocks: u32) {
    let bound = stats::z_bound(TESTS);
    let side = a.width().div_ceil(blocks);
    let sums = |film: &Film, bx: u32, by: u32| {
        let mut sums = [[0.0; 2]; 3];
        for (y, x) in (by * side..((by + 1) * side).min(film.height()))
            .flat_map(|y| (bx * side..((bx + 1) * side).min(film.width())).map(move |x| (y, x)))
        {
            let (mean, variance) = (film.mean(x, y), film.variance_of_mean(x, y).expect("samples"));
            (0..3).for_each(|c| sums[c] = [sums[c][0] + mean[c], sums[c][1] + variance[c]]);
        }
        sums
    };
    for (by, bx) in (0..blocks).flat_map(|y| (0..blocks).map(move |x| (y, x))) {
        let (of_a, of_b) = (sums(a, bx, by), sums(b, bx, by));
        for c in 0..3 {
            let z = (of_a[c][0] - of_b[c][0]) / (of_a[c][1] + of_b[c][1]).sqrt();
            let ratio = of_a[c][0] / of_b[c][0];
            assert!(z.abs() < bound, "{name}: block {bx},{by}, channel {c}: z = {z:.2}, ratio {ratio:.4}");
        }
    }
}

fn film(scene: &Scene, seed: u64, samples: u64) -> Film {
    renders::film(&renders::world(scene, seed), samples)
}

/// Without, and with those that bring all light and those that leave some of it to light samples, block by block.
fn assert_same_expectation(name: &str, scene: Scene, samples: u64) {
    let off = film(&with(scene.clone(), LightPaths::Off), 32, samples * 4);
    for (wish, everywhere) in [(LightPaths::On, true), (LightPaths::Auto, false)] {
        let world = renders::world(&with(scene.clone(), wish), 31);
        // Left alone, the plan may find that none pay.
        assert!(world.light_paths.is_some_and(|paths| paths.everywhere) == everywhere, "{name}");
        if world.light_paths.is_none() {
            continue;
        }
        assert_agree(&format!("{name}, {}", wish.name()), &renders::film(&world, samples), &off, 3);
    }
}

#[test]
fn every_material_and_both_kinds_of_emitters() {
    assert!(renders::world(&shop(false), 0).light_paths.is_some(), "left alone, glass has them");
    assert_same_expectation("shop", shop(false), 1024);
}

#[test]
fn through_a_lens() {
    assert_same_expectation("shop through a lens", shop(true), 1024);
}

/// Sky and lights without extent have no light paths of their own.
#[test]
fn beside_other_lights() {
    assert_same_expectation("stage", crate::equivalence::scenes::stage_lights(true), 2048);
}

/// Cut-outs before an uneven lamp, an emitting ball with an image, metal in patches.
#[test]
fn images() {
    assert_same_expectation("images", flat_images(), 2048);
}

pub fn flat_images() -> Scene {
    let mut scene = crate::equivalence::scenes::images();
    scene.materials.iter_mut().for_each(|material| material.maps.normal = None);
    scene
}

/// Lights chosen by place for camera paths, by power for light paths.
#[test]
fn many_lamps() {
    let mut set = Set::new([0.0, 1.0, 3.0], [0.0, 0.5, 0.0], 50.0, 24).bounces(4);
    let wall = set.grey(0.6, 0.0);
    let glass = set.material(Bsdf::Dielectric { alpha: 0.1, masking: Masking::Correlated, ior: 1.5 }, [0.0; 3]);
    set.room([wall; 6], [-2.0, 0.0, -2.0], [2.0, 2.0, 4.0]);
    set.sphere(glass, [0.0, 0.5, 0.0], 0.5);
    for i in 0..9 {
        let lamp = set.grey(0.2, 2.0 + i as f32);
        let x = -1.8 + 0.45 * f64::from(i);
        set.sphere(lamp, [x, 1.6 - 0.1 * f64::from(i % 4), -1.0 + 0.3 * f64::from(i % 3)], 0.1);
    }
    assert_same_expectation("many lamps", set.finish(), 1024);
}

/// A lamp so large that surfaces' own directions run into it as often as light samples do.
#[test]
fn a_ceiling_that_shines() {
    let mut set = Set::new([0.0, 1.0, 3.0], [0.0, 0.5, 0.0], 50.0, 24).bounces(3);
    let (wall, lamp) = (set.grey(0.6, 0.0), set.grey(0.0, 1.0));
    let glass = set.material(Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior: 1.5 }, [0.0; 3]);
    set.room([wall; 6], [-2.0, 0.0, -2.0], [2.0, 2.0, 4.0]);
    set.quad(lamp, [[-1.9, 1.9, -1.9], [1.9, 1.9, -1.9], [1.9, 1.9, 3.9], [-1.9, 1.9, 3.9]]);
    set.sphere(glass, [0.0, 0.3, 0.0], 0.3);
    assert_same_expectation("a ceiling that shines", set.finish(), 1024);
}

/// The variance that the film states is that of its means over seeds: splats are counted in it.
#[test]
fn variances_hold_over_seeds() {
    let scene = with(shop(false), LightPaths::On);
    let ratio = stated_over_spread(&(0..96).map(|seed| film(&scene, 1000 + seed, 16)).collect::<Vec<_>>());
    // Both estimate one number; a pixel's spread over 96 seeds has a relative error of √(2/95) or, for tails as heavy as
    // these, some times that, over 576 pixels: 5 %.
    assert!((0.85..1.15).contains(&ratio), "{ratio}");
}

/// The variance that films of the shop state over that of their means, relative to brightness.
fn stated_over_spread(films: &[Film]) -> f64 {
    let seeds = films.len() as f64;
    let (mut stated, mut spread) = (0.0, 0.0);
    for (y, x) in (0..24).flat_map(|y| (0..24).map(move |x| (y, x))) {
        let means: Vec<f64> = films.iter().map(|film| film.mean(x, y)[1]).collect();
        let mean = means.iter().sum::<f64>() / seeds;
        let weight = 1.0 / (mean * mean + 0.01);
        spread += weight * means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (seeds - 1.0);
        let variances = films.iter().map(|film| film.variance_of_mean(x, y).expect("samples")[1]);
        stated += weight * variances.sum::<f64>() / seeds;
    }
    println!("variance stated over spread: {:.3}", stated / spread);
    stated / spread
}

/// Tiles have numbers of samples of their own, and all of them what the light paths bring.
#[test]
fn beside_divided_samples() {
    let off = film(&with(shop(false), LightPaths::Off), 33, 8192);
    for wish in [LightPaths::On, LightPaths::Auto] {
        let world = renders::world(&with(shop(false), wish), 34);
        let outcome = renders::adaptive(&world, 2048, Width::native(), None);
        let report = outcome.adaptive.expect("a pilot");
        assert!(report.least < report.most, "nothing is divided: {report:?}");
        assert!(report.bias.abs() < 2.0 * report.bias_half_width, "{report:?}");
        assert_agree(&format!("divided samples, {}", wish.name()), &outcome.film, &off, 3);
    }
}

/// The error at which to stop is that of the image, in which light paths are.
#[test]
fn the_error_of_divided_samples_knows_of_light_paths() {
    let world = renders::world(&with(shop(false), LightPaths::On), 35);
    let error = |outcome: &Outcome| outcome.film.relative_error().expect("samples");
    let first = renders::adaptive_to(&world, 1e3);
    let wanted = 0.995 * error(&first);
    let second = renders::adaptive_to(&world, wanted);
    let reached = error(&second);
    assert!(reached <= wanted, "{reached} where {wanted} was wanted");
    assert!(second.film.mean_samples() > first.film.mean_samples());
}

/// As above, of films whose samples are divided.
#[test]
fn variances_hold_where_samples_are_divided() {
    let films = (0..64).map(|seed| {
        let world = renders::world(&with(shop(false), LightPaths::On), 2000 + seed);
        renders::adaptive(&world, 64, Width::native(), None).film
    });
    let ratio = stated_over_spread(&films.collect::<Vec<_>>());
    assert!((0.85..1.15).contains(&ratio), "{ratio}");
}

/// And it is less where there is glass.
#[test]
fn they_pay_under_glass() {
    for sampler in [SamplerKind::Independent, SamplerKind::Sobol] {
        let error = |light_paths| {
            let mut scene = with(closed_forms::pane(0.1), light_paths);
            scene.camera.vfov = 110.0;
            let world = renders::sampled(&scene, 5, Default::default(), sampler);
            renders::film(&world, 256).relative_error().expect("samples")
        };
        let (on, off) = (error(LightPaths::On), error(LightPaths::Off));
        assert!(on < 0.5 * off, "{sampler:?}: {on} with, {off} without");
    }
}
