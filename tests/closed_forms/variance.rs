//! The variance of direct light on a Lambert receiver, by quadrature: light sampling and BSDF sampling, one sample of
//! each, weighted by the power heuristic (Veach 1997, §9.2). A right mean with a wrong variance is a bug too.

use super::TESTS;
use crate::renders::{self, Set};
use crate::stats::quadrature::{gauss_legendre, integrate};
use crate::stats::{Moments, assert_mean};
use octolux::kernel::World;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

const SIDE: u32 = 48;
const SAMPLES: u64 = 1024;

/// Light of radiance 1 from all directions within `cos_min` of the normal of a receiver of reflectance 1, sampled with
/// density `light_pdf` there: mean and variance of a sample.
fn moments(cos_min: f64, light_pdf: f64) -> (f64, f64) {
    let rule = gauss_legendre(20);
    let over = |f: &dyn Fn(f64) -> f64| integrate(&rule, cos_min, 1.0, 40, |c| TAU * f(c));
    let bsdf_pdf = |c: f64| c * FRAC_1_PI;
    let weight = |a: f64, b: f64| a * a / (a * a + b * b);
    let by_light = |c: f64| weight(light_pdf, bsdf_pdf(c)) * bsdf_pdf(c) / light_pdf;
    let by_bsdf = |c: f64| weight(bsdf_pdf(c), light_pdf);
    let mean_light = over(&|c| by_light(c) * light_pdf);
    let mean_bsdf = over(&|c| by_bsdf(c) * bsdf_pdf(c));
    let squares = over(&|c| by_light(c).powi(2) * light_pdf + by_bsdf(c).powi(2) * bsdf_pdf(c));
    (mean_light + mean_bsdf, squares - mean_light.powi(2) - mean_bsdf.powi(2))
}

/// The same by light samples alone.
fn moments_by_lights(cos_min: f64, light_pdf: f64) -> (f64, f64) {
    let rule = gauss_legendre(20);
    let over = |f: &dyn Fn(f64) -> f64| integrate(&rule, cos_min, 1.0, 40, |c| TAU * f(c));
    let mean = over(&|c| c * FRAC_1_PI);
    (mean, over(&|c| (c * FRAC_1_PI).powi(2) / light_pdf) - mean.powi(2))
}

/// A receiver of reflectance 1 that fills the film, seen from the side.
fn receiver() -> Set {
    let mut set = Set::new([-2.0, 0.0, 0.1], [0.0; 3], 1e-4, SIDE).bounces(1);
    let ground = set.grey(1.0, 0.0);
    set.triangle(ground, [[-0.01, -0.01, 0.0], [0.02, -0.01, 0.0], [-0.01, 0.02, 0.0]]);
    set
}

fn check(name: &str, set: Set, expected: (f64, f64)) {
    check_world(name, &renders::world(&set.finish(), 17), expected);
}

fn check_world(name: &str, world: &World, (mean, variance): (f64, f64)) {
    let film = renders::film(world, SAMPLES);
    let pixels = || (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    let means: Moments = pixels().map(|(x, y)| film.mean(x, y)[1]).collect();
    assert_mean(name, &means, mean, 1e-5 * mean, TESTS);
    let sample_variance = |(x, y)| film.variance_of_mean(x, y).expect("many samples")[1] * SAMPLES as f64;
    let variances: Moments = pixels().map(sample_variance).collect();
    println!("{name}: variance {:.6} for {variance:.6} ± {:.6}", variances.mean, variances.std_error());
    assert_mean(&format!("variance, {name}"), &variances, variance, 1e-5 * variance, TESTS);
}

/// A uniform environment is sampled uniformly over the sphere: half its samples fall below the horizon.
#[test]
fn uniform_environment() {
    let expected = moments(0.0, 0.25 * FRAC_1_PI);
    assert!((expected.0 - 1.0).abs() < 1e-12);
    check("uniform environment", receiver().uniform_light(), expected);
}

/// Spheres overhead are sampled uniformly in the cone they fill: beside the receiver's own samples, and where they are near
/// enough to need these; else, as the plan has it at the last vertex of a path, alone.
#[test]
fn spheres_overhead() {
    for ratio in [0.5f64, 0.9, 0.1] {
        let cos_min = (1.0 - ratio * ratio).sqrt();
        let expected = moments(cos_min, 1.0 / (TAU * (1.0 - cos_min)));
        assert!((expected.0 - ratio * ratio).abs() < 1e-12);
        let mut set = receiver();
        let lamp = set.grey(0.0, 1.0);
        set.sphere(lamp, [0.0, 0.0, 1.0], ratio);
        let mut world = renders::world(&set.finish(), 17);
        let alone = ratio < 0.5f64.sqrt();
        let planned = if alone { moments_by_lights(cos_min, 1.0 / (TAU * (1.0 - cos_min))) } else { expected };
        check_world(&format!("sphere of {ratio} overhead, alone: {alone}"), &world, planned);
        assert!(world.reach.take().is_some());
        check_world(&format!("sphere of {ratio} overhead"), &world, expected);
    }
}

/// The quadrature itself, on the cases of MIS that have a closed form: uniform hemisphere and cosine.
#[test]
fn quadrature_agrees_with_the_oracles() {
    let Some(case) = crate::stats::oracle("H.mis_multi_power2") else { return };
    let (mean, variance) = moments(0.0, 0.5 / PI);
    assert!((mean - 1.0).abs() < 1e-12 && (variance - case.value).abs() < 1e-10, "{mean} {variance}");
}
