//! Russian roulette: unbiased, and with the variance it should have.
//!
//! In a closed room of mirrors with reflectance ρ that all emit 1 nothing is random but roulette. The usual one: vertices 0 … 4 add
//! ρᵏ. It begins after the fifth scattering: with probability p = ρ⁵ the path goes on, with β back at 1, and from
//! there each vertex adds 1 and is followed by another with probability ρ (ρ < .95). So
//! X = Σ_{k<5} ρᵏ + B·G with B ~ Bernoulli(p) and G geometric: mean 1/(1 − ρ), second moment (1 + ρ)/(1 − ρ)².

use super::{TESTS, rounding};
use crate::renders::{self, Set, assert_image_mean};
use crate::stats::{Moments, assert_mean};
use octolux::film::Film;
use octolux::scene::{Bsdf, ConductorFresnel, Masking, Roulette};

const SIDE: u32 = 32;

fn mirrors(roulette: Roulette, reflectance: f32, bounces: u32, samples: u64) -> Film {
    let mut set = Set::new([0.3, 0.2, 0.9], [-0.4, -0.1, -1.0], 80.0, SIDE).bounces(bounces);
    let fresnel = ConductorFresnel::Constant { reflectance: [reflectance; 3] };
    let wall = set.material(Bsdf::Conductor { alpha: 0.0, masking: Masking::Correlated, fresnel }, [1.0; 3]);
    set.room([wall; 6], [-1.0, -0.8, -1.5], [1.2, 0.9, 1.1]);
    set.scene_mut().integrator.roulette = roulette;
    renders::film(&renders::world(&set.finish(), 13), samples)
}

#[test]
fn mean_and_variance_of_the_usual_roulette() {
    const SAMPLES: u64 = 1024;
    for reflectance in [0.8f32, 0.5, 0.9] {
        let film = mirrors(Roulette::USUAL, reflectance, 300, SAMPLES);
        let rho = f64::from(reflectance);
        let mean = 1.0 / (1.0 - rho);
        assert_image_mean(&format!("mirrors, ρ = {rho}"), &film, [mean; 3], rounding(mean, 10), TESTS);
        let survival = rho.powi(5);
        let expected = survival * (1.0 + rho) * mean * mean - (survival * mean).powi(2);
        let variances: Moments = (0..SIDE * SIDE)
            .map(|i| film.variance_of_mean(i % SIDE, i / SIDE).expect("many samples")[0] * SAMPLES as f64)
            .collect();
        assert_mean(&format!("variance of mirrors, ρ = {rho}"), &variances, expected, 1e-4 * expected, TESTS);
    }
}

/// Which β a path has at a vertex is known; with q its survival to there, E X = Σ q β and E X² = Σ Σ q(later) β β.
fn mean_and_variance(roulette: Roulette, rho: f64, bounces: u32) -> (f64, f64) {
    let (mut beta, mut alive) = (1.0, 1.0);
    let (mut mean, mut second, mut so_far) = (0.0, 0.0, 0.0);
    for event in 0..=bounces {
        // The sum so far was made by everyone who is still alive.
        second += alive * (beta * beta + 2.0 * beta * so_far);
        mean += alive * beta;
        so_far += beta;
        beta *= rho;
        if event + 1 >= roulette.after {
            let carried = beta / f64::from(roulette.below);
            let survival = if carried > 1.0 { 1.0 } else { carried.min(0.95) };
            alive *= survival;
            beta /= survival;
        }
    }
    (mean, second - mean * mean)
}

fn check(roulette: Roulette, reflectance: f32, bounces: u32) {
    const SAMPLES: u64 = 256;
    let film = mirrors(roulette, reflectance, bounces, SAMPLES);
    let rho = f64::from(reflectance);
    let (mean, expected) = mean_and_variance(roulette, rho, bounces);
    let exact = (1.0 - rho.powi(bounces as i32 + 1)) / (1.0 - rho);
    assert!((mean / exact - 1.0).abs() < 1e-9, "the process above is unbiased: {mean}, {exact}");
    let name = format!("mirrors, ρ = {rho}, roulette {roulette}");
    assert_image_mean(&name, &film, [exact; 3], rounding(exact, 10), TESTS);
    let variances: Moments = (0..SIDE * SIDE)
        .map(|i| film.variance_of_mean(i % SIDE, i / SIDE).expect("many samples")[0] * SAMPLES as f64)
        .collect();
    assert_mean(&format!("variance of {name}"), &variances, expected, 1e-4 * expected, TESTS);
}

/// Above ρ = .95 survival is capped at .95 and β then exceeds 1, which ends no path: β falls by ρ a vertex until it is below
/// 1 again. With the cap alone β grew by ρ/.95 a vertex and the variance with it, without bound.
#[test]
fn roulette_of_nearly_white_mirrors_stays_bounded() {
    for roulette in [Roulette::USUAL, Roulette::default()] {
        for reflectance in [0.97, 0.99] {
            check(roulette, reflectance, 600);
        }
    }
}

#[test]
fn roulette_as_a_scene_may_have_it() {
    for (after, below) in [(2, 0.25), (1, 1.0), (1, 0.25), (3, 0.0625), (9, 0.5)] {
        for reflectance in [0.5, 0.8] {
            check(Roulette { after, below }, reflectance, 300);
        }
    }
}

/// Before roulette there is nothing random at all.
#[test]
fn no_roulette_before_its_time() {
    for (roulette, last) in [(Roulette::USUAL, 4), (Roulette::default(), 1), (Roulette { after: 1, below: 0.0 }, 40)] {
        for bounces in 0..=last {
            let film = mirrors(roulette, 0.5, bounces, 4);
            let expected: f64 = (0..=bounces).map(|k| f64::from(0.5f32.powi(k as i32))).sum();
            assert!((film.mean(5, 6)[0] / expected - 1.0).abs() < 1e-6, "{roulette}: {bounces} bounces");
            assert_eq!(film.variance_of_mean(5, 6), Some([0.0; 3]), "{roulette}: {bounces} bounces");
        }
    }
}
