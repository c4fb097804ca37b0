//! Bayesian Monte Carlo: the integrals of the covariance, the weights, the gate.

use crate::stats::Rng;
use crate::stats::quadrature::{Adaptive, Rect, gauss_legendre, integrate};
use octolux::estimate::bmc::{
    Covariance, MAX_ABSOLUTE_RATIO, Mean, Measure, Points, Rules, SetRecipe, System, Verdict, bessel_i0e, gram,
    point_sets, polar_points, weights,
};
use octolux::estimate::cholesky::Cholesky;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const SE: Covariance = Covariance::SquaredExponential { length: 0.5 };

fn direction([cos, turn]: [f64; 2]) -> [f64; 3] {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    [sin * (TAU * turn).cos(), sin * (TAU * turn).sin(), cos]
}

fn system(k: Covariance, measure: Measure, polar: &[[f64; 2]]) -> System {
    let rules = Rules::new();
    let points: Vec<_> = polar.iter().map(|&p| direction(p)).collect();
    let z = polar.iter().map(|p| measure.embedding(k, p[0].acos(), &rules)).collect();
    System { gram: gram(k, &points), z, total: measure.total(), self_energy: measure.self_energy(k, &rules) }
}

/// The least cosθ where a measure is.
fn lowest(measure: Measure) -> f64 {
    if matches!(measure, Measure::PowerCosine { .. }) { 0.0 } else { -1.0 }
}

/// I₀ by its series.
fn i0(b: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for j in 1..500 {
        term *= (0.5 * b / f64::from(j)).powi(2);
        sum += term;
    }
    sum
}

#[test]
fn the_bessel_function_is_right() {
    for b in [0.0, 1e-3, 0.5, 3.0, 20.0, 80.0] {
        let expected = i0(b) * (-b).exp();
        assert!((bessel_i0e(b) - expected).abs() < 1e-14, "{b}: {} for {expected}", bessel_i0e(b));
    }
    // e^−b I₀(b) = (1 + 1/8b + 9/128b² + …)/√(2πb).
    let b = 1e4;
    let expected = (1.0 + 0.125 / b + 9.0 / (128.0 * b * b)) / (TAU * b).sqrt();
    assert!((bessel_i0e(b) / expected - 1.0).abs() < 1e-11);
}

/// z(c) = 2π ∫₀¹ u^m I₀(b) exp(λ(cu − 1)) du, b = λ sinθ √(1−u²), from estimators.md.
#[test]
fn the_embedding_of_a_squared_exponential_is_the_bessel_integral() {
    let (rule, rules) = (gauss_legendre(96), Rules::new());
    for length in [0.15, 0.3, 0.5, 1.0, 3.0] {
        let lambda = 1.0 / (length * length);
        let k = Covariance::SquaredExponential { length };
        for exponent in [0.0, 1.0, 2.5, 20.0] {
            let measure = Measure::PowerCosine { exponent };
            for theta in [0.0f64, 1e-6, 0.4, 1.0, 1.5, FRAC_PI_2] {
                let (s, c) = theta.sin_cos();
                // u = t²: for powers that are not whole.
                let f = |t: f64| {
                    let u = t * t;
                    let b = lambda * s * (1.0 - u * u).sqrt();
                    2.0 * t * u.powf(exponent) * bessel_i0e(b) * (lambda * (c * u - 1.0) + b).exp()
                };
                let expected = TAU * integrate(&rule, 0.0, 1.0, 6, f);
                let z = measure.embedding(k, theta, &rules);
                let error = (z / expected - 1.0).abs();
                assert!(error < 1e-8, "ℓ {length}, m {exponent}, θ {theta}: {z} for {expected}, {error:e}");
            }
        }
    }
}

/// Against adaptive quadrature over (cosθ, φ), which knows nothing of polar coordinates about the point.
#[test]
fn the_embedding_of_a_sobolev_covariance_is_its_integral() {
    let rules = Rules::new();
    for smoothness in [1.2, 1.5, 1.8] {
        let k = Covariance::Sobolev { smoothness };
        for (measure, name) in [
            (Measure::UNIFORM, "uniform"),
            (Measure::COSINE, "cosine"),
            (Measure::PowerCosine { exponent: 7.0 }, "cos^7"),
            (Measure::Lobe { sharpness: 6.0, amplitude: 0.7 }, "lobe"),
            (Measure::Microfacet { kappa: 5.0 }, "microfacet"),
        ] {
            let low = lowest(measure);
            for cos in [1.0, 0.93, 0.4, 0.02] {
                let here = direction([cos, 0.0]);
                let f = |u: f64, phi: f64| measure.density(u) * k.between(here, direction([u, phi / TAU]));
                let area = Rect { x: [low, 1.0], y: [0.0, PI] };
                let (half, error) = Adaptive::new(2e-8, f).integrate(area, 3);
                let z = measure.embedding(k, cos.acos(), &rules);
                let allowed = 2.0 * error + 1e-8;
                assert!((z - 2.0 * half).abs() < allowed, "s {smoothness}, {name}, {cos}: {z} for {}", 2.0 * half);
            }
        }
    }
}

#[test]
fn the_product_of_two_lobes_is_a_closed_form() {
    let rules = Rules::new();
    let rule = gauss_legendre(64);
    for (sharpness, length) in [(6.0, 0.5), (400.0, 0.2), (0.5, 3.0)] {
        let lambda = 1.0 / (length * length);
        let measure = Measure::Lobe { sharpness, amplitude: 1.3 };
        let k = Covariance::SquaredExponential { length };
        for theta in [0.0f64, 0.3, 1.7, PI] {
            let (s, c) = theta.sin_cos();
            let f = |u: f64| {
                let b = lambda * s * (1.0 - u * u).max(0.0).sqrt();
                measure.density(u) * bessel_i0e(b) * (lambda * (c * u - 1.0) + b).exp()
            };
            let expected = TAU * integrate(&rule, -1.0, 1.0, 40, f);
            let z = measure.embedding(k, theta, &rules);
            // Far from the lobe z is below what the quadrature's rounding leaves of the peak.
            assert!(
                (z - expected).abs() < 1e-10 * expected + 1e-15,
                "{sharpness} {length} {theta}: {z} for {expected}"
            );
        }
    }
}

/// V₀ = ∫ p z: here by another rule; and totals against their integrals.
#[test]
fn totals_and_self_energies_are_integrals() {
    let (rules, rule) = (Rules::new(), gauss_legendre(64));
    let measures = [
        Measure::UNIFORM,
        Measure::COSINE,
        Measure::PowerCosine { exponent: 30.0 },
        Measure::Lobe { sharpness: 50.0, amplitude: 2.0 },
        Measure::Microfacet { kappa: 50.0 },
    ];
    for measure in measures {
        let low = lowest(measure);
        let total = TAU * integrate(&rule, low, 1.0, 4, |u| measure.density(u));
        assert!((measure.total() / total - 1.0).abs() < 1e-12, "{measure:?}");
        for k in [SE, Covariance::SOBOLEV] {
            let energy = measure.self_energy(k, &rules);
            let f = |u: f64| measure.density(u) * measure.embedding(k, u.acos(), &rules);
            let expected = TAU * integrate(&rule, low, 1.0, 4, f);
            assert!((energy / expected - 1.0).abs() < 1e-7, "{measure:?} {k:?}: {energy} for {expected}");
        }
    }
}

/// A section of the kernel is a function the posterior knows: with y_i = k(ω_i, ω_j), Σ w_i y_i = z_j.
#[test]
fn kernel_sections_are_integrated_exactly() {
    let polar = polar_points(Points::Owen, Measure::COSINE, 32, 1, 0);
    for (k, tolerance) in [(Covariance::SOBOLEV, 1e-6), (Covariance::SquaredExponential { length: 0.2 }, 1e-6)] {
        let system = system(k, Measure::COSINE, &polar);
        for mean in [Mean::Zero, Mean::Constant] {
            let w = weights(&system, mean, 0.0);
            // With an unknown mean differences of sections are known, not sections: section 0 is taken off.
            let off = if mean == Mean::Zero { 0.0 } else { 1.0 };
            assert!(w.conditioning.verdict != Verdict::EqualWeights, "{k:?} {mean:?} {:?}", w.conditioning);
            for j in 0..32 {
                let y: Vec<f64> = (0..32).map(|i| system.gram[i * 32 + j] - off * system.gram[i * 32]).collect();
                // The jitter J leaves w_j·J.
                let allowed = tolerance + w.conditioning.jitter * w.w[j].abs() * 2.0;
                assert!((w.estimate(&y) - system.z[j] + off * system.z[0]).abs() < allowed, "{k:?} {mean:?} {j}");
            }
        }
    }
}

#[test]
fn with_a_constant_mean_the_weights_sum_to_the_measure_and_a_furnace_is_exact() {
    for points in [Points::Random, Points::Owen, Points::Fibonacci] {
        for measure in [Measure::UNIFORM, Measure::COSINE, Measure::PowerCosine { exponent: 12.0 }] {
            for n in [1, 2, 16, 64, 200] {
                let recipe = SetRecipe {
                    points,
                    n,
                    sets: 2,
                    measure,
                    covariance: Some(Covariance::SOBOLEV),
                    mean: Mean::Constant,
                    seed: 3,
                };
                for set in point_sets(&recipe) {
                    let posterior = set.posterior.as_ref().unwrap();
                    let furnace = posterior.estimate(&vec![7.0; n]);
                    assert!((furnace / (7.0 * measure.total()) - 1.0).abs() < 1e-10, "{points:?} {measure:?} {n}");
                    // As f32 weights each is off by half an ulp at most.
                    let sum: f64 = set.weights.iter().map(|&w| f64::from(w)).sum();
                    assert!((sum / measure.total() - 1.0).abs() < 2.0f64.powi(-24) * MAX_ABSOLUTE_RATIO);
                }
            }
        }
    }
}

/// The sets the renderer uses never need the fallback.
#[test]
fn good_points_with_a_sobolev_covariance_are_well_conditioned() {
    for (points, n) in [(Points::Fibonacci, 16), (Points::Fibonacci, 64), (Points::Owen, 32), (Points::Fibonacci, 256)]
    {
        for measure in [Measure::UNIFORM, Measure::COSINE] {
            let covariance = Some(Covariance::SOBOLEV);
            let recipe = SetRecipe { points, n, sets: 8, measure, covariance, mean: Mean::Constant, seed: 0 };
            for set in point_sets(&recipe) {
                let conditioning = set.conditioning().unwrap();
                assert!(!set.fell_back() && conditioning.jitter < 1e-7, "{points:?} {n}: {conditioning:?}");
            }
        }
    }
}

/// A length-scale of half the sphere and more: pivots sink below the jitter, and weights would fight. Each case must say
/// so; where the points are random and the length-scale short of rescue, the plain mean is given instead.
#[test]
fn the_stiff_case_is_reported() {
    for points in [Points::Random, Points::Owen, Points::Fibonacci] {
        let polar = polar_points(points, Measure::COSINE, 64, 5, 0);
        for length in [0.7, 1.0, 2.0, 4.0, 20.0] {
            let k = Covariance::SquaredExponential { length };
            let w = weights(&system(k, Measure::COSINE, &polar), Mean::Constant, 0.0);
            assert!(w.conditioning.verdict != Verdict::Posterior, "{points:?}, length {length}: {:?}", w.conditioning);
            assert!(w.w.iter().map(|w| w.abs()).sum::<f64>() <= MAX_ABSOLUTE_RATIO * PI * (1.0 + 1e-6));
        }
    }
    let polar = polar_points(Points::Random, Measure::COSINE, 64, 5, 0);
    let k = Covariance::SquaredExponential { length: 0.3 };
    let w = weights(&system(k, Measure::COSINE, &polar), Mean::Constant, 0.0);
    assert_eq!((w.conditioning.verdict, w.conditioning.jitter), (Verdict::EqualWeights, 1e-2));
    assert!(w.w.iter().all(|&w| w == PI / 64.0) && w.unit_variance.is_none() && w.variance(&[0.0; 64]).is_none());
    assert!(w.conditioning.absolute_ratio > MAX_ABSOLUTE_RATIO);
    // Without a gate the same system gives weights that cancel.
    let system = system(Covariance::SquaredExponential { length: 2.0 }, Measure::COSINE, &polar);
    let raw = Cholesky::new(&system.gram, 64, 1e-12).expect("f64 factors it").solve(&system.z);
    let ratio = raw.iter().map(|w| w.abs()).sum::<f64>() / raw.iter().sum::<f64>();
    assert!(ratio > 10.0, "{ratio}");
}

/// The same factorisation in f32, as it was first tried.
fn f32_cholesky_succeeds(q: &[f64], n: usize, jitter: f64) -> bool {
    let mut l = vec![0f32; n * n];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = (q[i * n + j] + if i == j { jitter } else { 0.0 }) as f32;
            for k in 0..j {
                sum -= l[i * n + k] * l[j * n + k];
            }
            if i == j {
                if sum.is_nan() || sum <= 0.0 {
                    return false;
                }
                l[i * n + i] = sum.sqrt();
            } else {
                l[i * n + j] = sum / l[j * n + j];
            }
        }
    }
    true
}

#[test]
fn f64_factors_what_f32_cannot() {
    let polar = polar_points(Points::Random, Measure::COSINE, 256, 1, 0);
    let points: Vec<_> = polar.iter().map(|&p| direction(p)).collect();
    let q = gram(Covariance::SquaredExponential { length: 1.0 }, &points);
    assert!(!f32_cholesky_succeeds(&q, 256, 1e-7));
    let factor = Cholesky::new(&q, 256, 1e-7).expect("positive definite in f64");
    let mut rng = Rng::new(1);
    let x: Vec<f64> = (0..256).map(|_| rng.range(-1.0, 1.0)).collect();
    let b: Vec<f64> =
        (0..256).map(|i| (0..256).map(|j| (q[i * 256 + j] + if i == j { 1e-7 } else { 0.0 }) * x[j]).sum()).collect();
    let solved = factor.solve(&b);
    // A condition number of 256/1e-7 times the rounding of 2⁻⁵³ is 3e-7.
    let error = solved.iter().zip(&x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(error < 1e-5, "{error:e}");
    assert!(Cholesky::new(&[1.0, 2.0, 2.0, 1.0], 2, 0.0).is_none(), "an indefinite matrix");
    assert!(Cholesky::new(&[f64::NAN], 1, 0.0).is_none());
}

/// O'Hagan 1987: the same sample twice is no more than once.
#[test]
fn a_repeated_sample_changes_nothing() {
    let mut polar = polar_points(Points::Random, Measure::COSINE, 12, 2, 0);
    let once = weights(&system(Covariance::SOBOLEV, Measure::COSINE, &polar), Mean::Constant, 0.0);
    polar.push(polar[4]);
    polar.push(polar[4]);
    let twice = weights(&system(Covariance::SOBOLEV, Measure::COSINE, &polar), Mean::Constant, 0.0);
    let y: Vec<f64> = polar.iter().map(|p| (3.0 * p[0]).sin() + p[1]).collect();
    let (a, b) = (once.estimate(&y[..12]), twice.estimate(&y));
    assert!((a - b).abs() < 1e-14 * a.abs() * 10.0, "{a} {b}");
    assert_eq!(once.scale(&y[..12]), twice.scale(&y));
    assert_eq!(once.unit_variance, twice.unit_variance);
}

#[test]
fn parameters_outside_their_domain_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Covariance::SquaredExponential { length: bad }.check().is_err());
        assert!(Covariance::Sobolev { smoothness: bad }.check().is_err());
    }
    assert!(Covariance::SOBOLEV.check().is_ok() && SE.check().is_ok());
}
