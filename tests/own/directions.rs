//! The public χ² test: accepts what is right as often as it says, and rejects what is wrong.

use super::materials::Velvet;
use crate::stats::special::chi2_tail;
use octolux::bsdf::{Eval, Sample};
use octolux::check::DirectionTest;
use octolux::lane::{Mask, Real, Vec3};
use octolux::own::Bsdf;
use octolux::sampling::warp;
use std::f32::consts::{FRAC_1_PI, TAU};

fn cosine([_, u, v]: [f32; 3]) -> Option<[f32; 3]> {
    let w = warp::cosine_hemisphere([u, v]);
    Some([w.x, w.y, w.z])
}

fn cosine_pdf(w: [f32; 3]) -> f32 {
    w[2].max(0.0) * FRAC_1_PI
}

/// 400 right samplers at a significance of 5 %: 20 rejected, ±4 standard deviations of 4.4.
#[test]
fn false_alarms_are_as_rare_as_said() {
    let test = |seed| DirectionTest { samples: 20_000, seed, significance: 0.05, ..DirectionTest::default() };
    let rejected = (0..400).filter(|&seed| !test(seed).run(cosine, cosine_pdf).accepts()).count();
    assert!((3..=37).contains(&rejected), "{rejected} of 400 right samplers rejected");
}

/// Its tail of χ² against the tests' own.
#[test]
fn p_values_are_tails_of_chi_squared() {
    for seed in 0..20 {
        for cells in [[2, 2], [4, 8], [16, 32]] {
            let report =
                DirectionTest { samples: 5000, seed, cells, ..DirectionTest::default() }.run(cosine, cosine_pdf);
            let ours = report.chi_squared;
            let theirs = chi2_tail(f64::from(ours.dof), ours.statistic);
            assert!((ours.p_value - theirs).abs() < 1e-9 + 1e-9 * theirs, "{report}: {theirs}");
        }
    }
}

/// A pdf off by 10 % at most in a smooth tilt of equal mass (noncentrality 200,000 · .1²/4 = 500 beside a standard deviation
/// of 23), a mass of 1 %, a sign: each is noticed by the default test.
#[test]
fn wrong_pdfs_are_rejected() {
    let test = DirectionTest::default();
    type Pdf<'a> = &'a dyn Fn([f32; 3]) -> f32;
    let wrong: [(&str, Pdf); 5] = [
        ("uniform", &|w| if w[2] > 0.0 { 1.0 / TAU } else { 0.0 }),
        ("tilted by 10 %", &|w| cosine_pdf(w) * (1.0 + 0.1 * w[0])),
        ("1 % too small", &|w| 0.99 * cosine_pdf(w)),
        ("too large", &|w| 1.01 * cosine_pdf(w)),
        ("upside down", &|w| cosine_pdf([w[0], w[1], -w[2]])),
    ];
    for (name, pdf) in wrong {
        let report = test.run(cosine, pdf);
        assert!(!report.accepts(), "{name}: {report}");
    }
    assert!(!test.run(|u| cosine(u).map(|w| w.map(|x| 1.01 * x)), cosine_pdf).accepts(), "not unit");
    assert!(!test.run(cosine, |_| f32::NAN).accepts(), "NaN");
}

/// Rejected draws count as the mass that is missing.
#[test]
fn rejections_are_mass() {
    let half = |u: [f32; 3]| cosine(u).filter(|_| u[0] < 0.5);
    let test = DirectionTest::default();
    assert!(test.run(half, |w| 0.5 * cosine_pdf(w)).accepts());
    assert!(!test.run(half, |w| 0.49 * cosine_pdf(w)).accepts());
}

/// A BSDF wrong in one way.
struct Spoilt {
    pdf: f32,
    weight: f32,
    delta: bool,
}

impl Bsdf for Spoilt {
    fn eval<R: Real>(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let right = Velvet { sheen: 1.0 }.eval(wo, wi);
        Eval { pdf: right.pdf * R::splat(self.pdf), ..right }
    }
    fn sample<R: Real>(&self, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R> {
        let right = Velvet { sheen: 1.0 }.sample(wo, u_lobe, u);
        Sample { weight: right.weight * R::splat(self.weight), delta: R::Mask::splat(self.delta), ..right }
    }
}

#[test]
fn bsdfs_are_held_to_their_pdf_and_value() {
    for wo in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -0.8, -0.6]] {
        let test = DirectionTest { samples: 50_000, ..DirectionTest::default() };
        let spoilt = |pdf, weight, delta| test.bsdf(&Spoilt { pdf, weight, delta }, wo);
        let right = spoilt(1.0, 1.0, false);
        assert!(right.accepts(), "{right}");
        for wrong in [spoilt(0.9, 1.0, false), spoilt(1.0, 1.1, false), spoilt(1.0, 1.0, true)] {
            assert!(!wrong.accepts(), "{wrong}");
        }
    }
}
