//! Weights between those of a posterior and equal ones.

use crate::stats::{Moments, Rng, assert_mean};
use octolux::estimate::bmc::{Covariance, Mean, Measure, Pilot, Points, Rules, System, gram, polar_points, weights};
use std::f64::consts::TAU;

fn system(k: Covariance, polar: &[[f64; 2]]) -> System {
    let (rules, measure) = (Rules::new(), Measure::COSINE);
    let one = |&[c, t]: &[f64; 2]| {
        let s = (1.0 - c * c).sqrt();
        [s * (TAU * t).cos(), s * (TAU * t).sin(), c]
    };
    let points: Vec<[f64; 3]> = polar.iter().map(one).collect();
    let z = polar.iter().map(|p| measure.embedding(k, p[0].acos(), &rules)).collect();
    System { gram: gram(k, &points), z, total: measure.total(), self_energy: measure.self_energy(k, &rules) }
}

/// V₀ − 2wᵀz + wᵀQw, term by term: what the process has for any weights of the right sum. A point that came twice is one
/// observation.
#[test]
fn the_variance_of_drawn_weights_is_the_processs() {
    let mut polar = polar_points(Points::Owen, Measure::COSINE, 20, 3, 0);
    polar.push(polar[7]);
    for k in [Covariance::SOBOLEV, Covariance::SquaredExponential { length: 0.3 }] {
        let system = system(k, &polar);
        let n = polar.len();
        for intensity in [0.0, 0.1, 0.5, 1.0] {
            let drawn = weights(&system, Mean::Constant, 0.0).shrunk(intensity, system.total);
            let jitter = drawn.conditioning.jitter * system.gram[0];
            let q = |i: usize, j: usize| system.gram[i * n + j];
            let mut expected = system.self_energy;
            for i in 0..n {
                expected -= 2.0 * drawn.w[i] * system.z[i];
                expected += (0..n).map(|j| drawn.w[i] * drawn.w[j] * q(i, j)).sum::<f64>();
                // The jitter of the point that came twice stands once, under the sum of its weights.
                let w = if i == 7 { drawn.w[7] + drawn.w[20] } else { drawn.w[i] };
                expected += if i == 20 { 0.0 } else { jitter * w * w };
            }
            let found = drawn.unit_variance.unwrap();
            // Both are differences of numbers of the size of V₀.
            let rounding = 1e-12 * system.self_energy;
            assert!((found - expected).abs() < rounding + 1e-6 * expected, "{k:?} {intensity}: {found:e} {expected:e}");
            assert!((drawn.w.iter().sum::<f64>() / system.total - 1.0).abs() < 1e-6);
        }
    }
}

/// Pairs of errors drawn from a normal distribution of which the best λ is known: e of equal weights, b = e + d of the
/// others, E[(e + (1 − λ) d)²] least at 1 − λ = −cov(e, d)/E[d²].
#[test]
fn the_pilot_finds_the_lowest_point_of_the_parabola() {
    let mut rng = Rng::new(11);
    // Standard deviation of e, cov(e, d)/var(e), standard deviation of what else is in d, bias of b.
    for (sigma, slope, rest, bias) in
        [(1.0, -1.0, 0.2, 0.0), (0.3, -0.5, 0.3, 0.1), (2.0, -0.1, 1.5, 0.5), (1.0, -0.05, 0.3, 0.0)]
    {
        let square = (slope * sigma) * (slope * sigma) + rest * rest + bias * bias;
        let expected = 1.0 + slope * sigma * sigma / square;
        let mut found = Moments::new();
        for _ in 0..400 {
            let mut pilot = Pilot::default();
            // Integrals of different sizes, and all of them count.
            for _ in 0..200 {
                let truth = rng.range(-50.0, 50.0);
                let pair = |rng: &mut Rng| {
                    let e = sigma * rng.normal();
                    [truth + e, truth + e + slope * e + rest * rng.normal() + bias]
                };
                let pairs: Vec<[f64; 2]> = (0..16).map(|_| pair(&mut rng)).collect();
                pilot.add(truth + 0.25 * sigma * rng.normal(), &pairs);
            }
            found.push(pilot.intensity());
        }
        // A ratio of means of 3,200 terms: its own bias is below 1/3200 of its size.
        assert_mean("λ", &found, expected, 1.0 / 3200.0, 4);
        // An error of .02 would be seen.
        assert!(found.std_error() < 5e-3, "{}", found.std_error());
    }
}

#[test]
fn the_pilot_stays_between_the_two() {
    let mut rng = Rng::new(12);
    let mut intensity = |b: fn(f64) -> f64| {
        let mut pilot = Pilot::default();
        let mut pair = || {
            let e = rng.normal();
            [e, b(e)]
        };
        pilot.add(0.0, &(0..100).map(|_| pair()).collect::<Vec<_>>());
        pilot.intensity()
    };
    // Others that err not at all, a quarter as much to the other side, and twice as much to the same side.
    assert_eq!(intensity(|_| 0.0), 0.0);
    assert!((intensity(|e| -0.25 * e) - 0.2).abs() < 1e-12);
    assert_eq!(intensity(|e| 2.0 * e), 1.0);
    // Nothing to tell them apart, and nothing seen.
    assert_eq!(intensity(|e| e), 0.0);
    assert_eq!(Pilot::default().intensity(), 0.0);
    // Values that are not finite say nothing.
    let mut pilot = Pilot::default();
    pilot.add(1.0, &[]);
    pilot.add(f64::INFINITY, &[[1.0, 2.0]]);
    pilot.add(1.0, &[[1.0, 2.0], [f64::NAN, 1.0]]);
    assert_eq!(pilot, Pilot::default());
}
