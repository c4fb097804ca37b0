//! Do sampled directions follow the pdf that `eval` claims?

use super::{at, direction, glass, to_lane, white_metal};
use crate::sampling::draw::one_by_one;
use crate::stats::{Chi2Sphere, SphereOutcome};
use octolux::bsdf::{Diffuse, Model};
use octolux::lane::{Real, Vec3, f32x8};

/// χ² tests in this folder, rounded up.
const TESTS: usize = 96;

pub fn chi2<M8: Model<f32x8>, M1: Model<f32>>(
    name: String,
    lanes: &M8,
    scalar: &M1,
    mu: f64,
    cells: impl Fn(Chi2Sphere) -> Chi2Sphere,
) {
    if let Some(failure) = outcome(name, lanes, scalar, mu, cells).failure {
        panic!("{failure}");
    }
}

/// One test: eight lanes sample, width 1 evaluates.
fn outcome<M8: Model<f32x8>, M1: Model<f32>>(
    name: String,
    lanes: &M8,
    scalar: &M1,
    mu: f64,
    cells: impl Fn(Chi2Sphere) -> Chi2Sphere,
) -> SphereOutcome {
    let wo = at(mu, 0.7);
    let mut next = one_by_one(41, |rng| {
        let s = lanes.sample(wo, rng.next_unit(), [rng.next_unit(), rng.next_unit()]);
        std::array::from_fn(|i| direction(&s, i))
    });
    let wo = at::<f32>(mu, 0.7);
    let test = Chi2Sphere::new(name).samples(200_000).tests(TESTS);
    cells(test).outcome(|_| next(), |wi| scalar.eval(wo, to_lane(wi)).pdf.into())
}

#[test]
fn diffuse() {
    for mu in [1.0, 0.1, -0.6] {
        let (lanes, scalar) =
            (Diffuse { reflectance: Vec3::all(f32x8::one()) }, Diffuse { reflectance: Vec3::all(1.0) });
        chi2(format!("diffuse, cosine {mu}"), &lanes, &scalar, mu, |test| test);
    }
}

#[test]
fn conductor() {
    for alpha in [0.15, 0.5, 1.0] {
        for mu in [1.0, 0.6, 0.1, 0.01] {
            let (lanes, scalar) = (white_metal(alpha, false), white_metal(alpha, false));
            chi2(format!("conductor {alpha}, cosine {mu}"), &lanes, &scalar, mu, |test| test.cells(16, 32));
        }
    }
    let (lanes, scalar) = (white_metal(0.5, false), white_metal(0.5, false));
    chi2("conductor from below".into(), &lanes, &scalar, -0.6, |test| test.cells(32, 64));
}

#[test]
fn narrow_conductor() {
    for (alpha, power) in [(0.1, 2.0), (0.02, 3.0), (0.002, 5.0), (1e-3, 6.0), (1.01e-4, 8.0)] {
        for mu in [1.0, 0.6, 0.1] {
            let (lanes, scalar) = (white_metal(alpha, false), white_metal(alpha, false));
            let wo = at::<f32>(mu, 0.7).lane(0).map(f64::from);
            let axis = [-wo[0], -wo[1], wo[2]];
            chi2(format!("conductor {alpha}, cosine {mu}"), &lanes, &scalar, mu, |test| {
                test.cells(32, 32).around(axis, power)
            });
        }
    }
}

#[test]
fn dielectric() {
    for alpha in [0.2, 1.0] {
        for mu in [1.0, 0.1, -0.8, -0.1] {
            let (lanes, scalar) = (glass(alpha, false, 1.5), glass(alpha, false, 1.5));
            chi2(format!("dielectric {alpha}, cosine {mu}"), &lanes, &scalar, mu, |test| test.cells(16, 32));
        }
    }
}

#[test]
fn dielectric_of_a_low_index() {
    // Inside is the thinner side: total reflection comes from outside.
    for mu in [0.6, -0.6] {
        let (lanes, scalar) = (glass(0.3, true, 0.7), glass(0.3, true, 0.7));
        chi2(format!("dielectric of index 0.7, cosine {mu}"), &lanes, &scalar, mu, |test| test.cells(16, 32));
    }
}

#[test]
fn a_wrong_density_is_caught() {
    // The same lobe 5 % wider must fail: the test can.
    let (lanes, scalar) = (white_metal(0.5, false), white_metal(0.525, false));
    let outcome = outcome("deliberately wrong".into(), &lanes, &scalar, 0.6, |test| test.cells(16, 32));
    assert!(outcome.pdf_total < 1.0 && outcome.failure.is_some(), "{outcome:?}");
}
