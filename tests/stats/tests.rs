//! The statistics themselves: quantiles against the oracles, calibration, power, and that failures do fail.

use super::special::{chi2_tail, normal_density, normal_two_sided, poisson_tail, quantile, student_two_sided};
use super::*;
use std::f64::consts::PI;

#[test]
fn chi_square_quantiles_match_the_oracles() {
    for case in oracles_in("chi-square") {
        let (level, dof) =
            case.id.strip_prefix("I.chi2_q").and_then(|s| s.split_once("_df")).expect("an id like q99_df1");
        let p = if level == "99" { 1e-2 } else { 1e-4 };
        let got = quantile(p, |x| chi2_tail(dof.parse().expect("dof"), x));
        assert!((got - case.value).abs() <= case.abs_tol, "{}: {got} for {}", case.id, case.value);
    }
}

#[test]
fn sidak_and_normal_bounds_match_the_oracles() {
    for case in oracles_in("multiple comparisons") {
        let (kind, m) = case.id.split_once("_m").expect("an id like I.z_m10");
        let m = m.parse().expect("a number of tests");
        let got = if kind == "I.z" { z_bound(m) } else { sidak_alpha(m) };
        // 1e-10 relative: z_bound is a root of a tail probability.
        assert!((got / case.value - 1.0).abs() <= 1e-10, "{}: {got} for {}", case.id, case.value);
    }
}

#[test]
fn student_quantiles_match_the_oracles() {
    for case in oracles_in("Student t") {
        let dof: f64 = case.id.strip_prefix("I.t995_nu").and_then(|s| s.parse().ok()).expect("an id like I.t995_nu9");
        let got = quantile(0.01, |t| student_two_sided(dof, t));
        assert!((got - case.value).abs() <= case.abs_tol, "{}: {got} for {}", case.id, case.value);
        assert_eq!(t_bound(1, dof), got, "one test at 1 % is the plain quantile");
    }
}

#[test]
fn special_functions_have_their_closed_forms() {
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-13;
    for x in [0.01, 0.5, 2.0, 30.0, 300.0] {
        assert!(close(chi2_tail(2.0, x), (-0.5 * x).exp()), "two degrees of freedom: an exponential");
        assert!(close(student_two_sided(1.0, x), 1.0 - 2.0 / PI * x.atan()) || x > 2.0, "one: Cauchy");
    }
    assert!(close(special::ln_gamma(0.5), 0.5 * PI.ln()));
    assert!(close(special::ln_gamma(171.0), (1..171).map(|k| f64::from(k).ln()).sum()));
    assert!(close(poisson_tail(2.0, 3), 1.0 - 5.0 * (-2f64).exp()));
    assert!(close(normal_two_sided(1.959963984540054), 0.05));
    // Both branches of t_bound meet.
    assert!((t_bound(100, 1.0001e5) - t_bound(100, 0.9999e5)).abs() < 1e-7);
}

#[test]
fn quadrature_is_exact_where_it_should_be() {
    let rule = quadrature::gauss_legendre(8);
    for degree in 0..16 {
        let got = quadrature::integrate(&rule, 0.0, 1.0, 1, |x| x.powi(degree));
        assert!((got - 1.0 / f64::from(degree + 1)).abs() < 1e-14, "degree {degree}: {got}");
    }
    // A narrow peak, and a disc's area: a jump along a curve.
    let square = quadrature::Rect { x: [-1.0, 1.0], y: [-1.0, 1.0] };
    let (mass, _) =
        quadrature::Adaptive::new(1e-9, |x: f64, y: f64| (-500.0 * (x * x + y * y)).exp()).integrate(square, 4);
    assert!((mass * 500.0 / PI - 1.0).abs() < 1e-7, "{mass}");
    let (area, error) =
        quadrature::Adaptive::new(1e-6, |x: f64, y: f64| f64::from(x * x + y * y < 1.0)).integrate(square, 1);
    assert!((area - PI).abs() < error && error < 1e-3, "{area} ± {error}");
}

#[test]
fn moments_are_those_of_the_samples() {
    let samples = [1e6 + 1.0, 1e6 + 2.0, 1e6 + 4.0, 1e6 + 9.0];
    let m: Moments = samples.into_iter().collect();
    assert_eq!((m.n, m.mean), (4, 1e6 + 4.0));
    assert!((m.variance() - 38.0 / 3.0).abs() < 1e-9);
    // μ₂ = 38/4, μ₄ = (81 + 16 + 0 + 625)/4
    let expected = ((722.0 / 4.0 - f64::powi(38.0 / 4.0, 2)) / 4.0f64).sqrt();
    assert!((m.variance_std_error() - expected).abs() < 1e-6);
}

#[test]
fn means_fail_when_they_should() {
    let mut rng = Rng::new(3);
    let m: Moments = (0..10_000).map(|_| rng.f64()).collect();
    assert_mean("uniform", &m, 0.5, 0.0, 100);
    assert_variance("uniform", &m, 1.0 / 12.0, 0.0, 100);
    let se = m.std_error();
    let bound = t_bound(100, 9999.0);
    let problem = |expected| mean_problem("uniform", &m, expected, 0.0, 100).is_some();
    assert!(!problem(m.mean + 0.999 * bound * se) && problem(m.mean + 1.001 * bound * se));
    assert!(mean_problem("nan", &[f64::NAN, 1.0].into_iter().collect(), 1.0, 1.0, 1).is_some());
    assert!(mean_problem("constant", &[1.0, 1.0].into_iter().collect(), 1.0 + 1e-9, 0.0, 1).is_some());
}

#[test]
fn p_values_of_right_expectations_are_uniform() {
    // 2,000 tables of 40 cells, a third of them small enough to be pooled; p-values in ten bins, themselves tested.
    let weights: Vec<f64> = (0..40).map(|i| if i % 3 == 0 { 0.02 } else { 1.0 }).collect();
    let total: f64 = weights.iter().sum();
    let expected: Vec<f64> = weights.iter().map(|w| w / total * 2_000.0).collect();
    let mut rng = Rng::new(11);
    let mut bins = [0u64; 10];
    for _ in 0..2_000 {
        let mut observed = vec![0u64; 40];
        for _ in 0..2_000 {
            let mut x = rng.f64() * total;
            let cell = weights.iter().position(|w| (x -= w, x < 0.0).1).unwrap_or(39);
            observed[cell] += 1;
        }
        bins[((chi2_test(&observed, &expected).p_value * 10.0) as usize).min(9)] += 1;
    }
    // The rare pool's Poisson tail is discrete and the correction conservative, so p-values may be too large, not small:
    // the lowest bin must not hold more than a binomial(2000, 0.1) would (mean 200, σ 13.4, bound 2.576σ one test).
    assert!((bins[0] as f64) < 200.0 + z_bound(1) * 13.42, "{bins:?}");
    assert!(bins[0] > 40, "and the test still uses its level: {bins:?}");
}

#[test]
fn forbidden_cells_and_nan_expectations_fail() {
    let flat = [1000.0, 1000.0, 1000.0];
    assert!(chi2_test(&[1010, 1000, 990], &flat).p_value > 0.5);
    assert!(chi2_test(&[1010, 1000, 990, 0], &[1000.0, 1000.0, 1000.0, 0.0]).p_value > 0.5);
    assert_eq!(chi2_test(&[1010, 1000, 990, 1], &[1000.0, 1000.0, 1000.0, 0.0]).p_value, 0.0);
    assert_eq!(chi2_test(&[1010, 1000, 990], &[1000.0, f64::NAN, 1000.0]).p_value, 0.0);
    assert!(chi2_test(&[1010, 1000, 990, 30], &[1000.0, 1000.0, 1000.0, 3.0]).p_value < 1e-6, "the rest, too full");
}

/// Density ∝ cosᵏθ over the upper hemisphere, and its sampler.
fn power_pdf(k: f64, w: [f64; 3]) -> f64 {
    if w[2] > 0.0 { (k + 1.0) / (2.0 * PI) * w[2].powf(k) } else { 0.0 }
}

fn power_sample(k: f64, rng: &mut Rng) -> Option<[f64; 3]> {
    let z = (1.0 - rng.f64()).powf(1.0 / (k + 1.0));
    let (s, c) = rng.range(0.0, 2.0 * PI).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Some([r * c, r * s, z])
}

#[test]
fn right_samplers_pass() {
    chi2_sphere("cosine", |rng| power_sample(1.0, rng), |w| power_pdf(1.0, w));
    chi2_sphere("sphere", |rng| Some(rng.sphere()), |_| 0.25 / PI);
    // A tilted narrow lobe, seen by cells around its axis; and half of all samples rejected, the pdf being half.
    let (s, c) = 1f64.sin_cos();
    let tilt = move |w: [f64; 3]| [c * w[0] + s * w[2], w[1], c * w[2] - s * w[0]];
    let back = move |w: [f64; 3]| [c * w[0] - s * w[2], w[1], c * w[2] + s * w[0]];
    Chi2Sphere::new("tilted").around([s, 0.0, c], 4.0).run(
        |rng| if rng.f64() < 0.5 { None } else { power_sample(1e4, rng).map(tilt) },
        |w| 0.5 * power_pdf(1e4, back(w)),
    );
}

/// Power at 200,000 samples and 511 degrees of freedom, where the bound for one test is 589 (2.4 σ above the mean): a
/// noncentrality of 200 is caught nearly always. cosᵏ claimed for cos¹ is off by the relative (k−1)(ln z + 1/2) to first
/// order, with variance (k−1)²/4 under cos¹: k = 1.05 has noncentrality N·0.05²/4 = 125 in the upper half's 256 cells
/// (3.6 times the σ of 22.6 above the mean), a pdf 2 % too small N·0.02² = 80 there and an impossible rejected cell.
#[test]
fn wrong_pdfs_are_caught() {
    let outcome = |seed, k: f64, scale: f64| {
        let test = Chi2Sphere::new("wrong").seed(seed);
        test.outcome(|rng| power_sample(1.0, rng), |w| scale * power_pdf(k, w))
    };
    let caught = |k, scale| (0..10).filter(|&seed| outcome(seed, k, scale).failure.is_some()).count();
    assert_eq!(caught(1.0, 1.0), 0);
    assert_eq!(caught(1.05, 1.0), 10, "an exponent 5 % too large");
    assert_eq!(caught(1.0, 0.98), 10, "a pdf 2 % too small: mass is missing that nobody rejects");
    assert_eq!(caught(1.0, 1.001), 10, "a pdf 0.1 % too large integrates to more than 1");
    let failure = outcome(1, 1.1, 1.0).failure.expect("10 % must be caught");
    assert!(failure.contains("p = ") && failure.contains("rejected") || failure.contains("cosθ"), "{failure}");
}

#[test]
fn samples_that_are_not_directions_fail() {
    let nan = Chi2Sphere::new("nan").outcome(|_| Some([f64::NAN, 0.0, 1.0]), |_| 0.25 / PI);
    assert!(nan.failure.is_some());
    let long = Chi2Sphere::new("long").outcome(|_| Some([0.0, 0.0, 1.1]), |_| 0.25 / PI);
    assert!(long.failure.is_some());
    let infinite = Chi2Sphere::new("pdf").samples(1000).outcome(|rng| Some(rng.sphere()), |_| f64::NAN);
    assert!(infinite.failure.is_some());
}

/// The bound's meaning: a bias of (z + 1.2816)·σ/√N is seen with 90 % power, as numerics.md has it.
#[test]
fn detectable_bias_is_as_stated() {
    for case in oracles_in("multiple comparisons") {
        let Some(stated) = case.record["detectable_bias_90pct_power_in_sigma_over_sqrtN"].as_f64() else { continue };
        let one_sided_10_percent = quantile(0.2, normal_two_sided);
        assert!((case.value + one_sided_10_percent - stated).abs() < 1e-9, "{}", case.id);
    }
    assert!((normal_density(0.0) - 0.398_942_280_401_432_7).abs() < 1e-15);
}
