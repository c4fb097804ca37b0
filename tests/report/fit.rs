//! Student's t, power laws and budgets against closed forms.

use crate::stats::special::student_two_sided;
use octolux::report::fit::{Estimate, PowerLaw, budget_for, fit_power_law, mean_and_error, median};
use octolux::student::{student_central, student_quantile};

/// y with a standard error too small to matter.
fn sharp(y: f64) -> Estimate {
    Estimate::student(y, 1e-9 * y, 100)
}

#[test]
fn student_has_its_closed_forms_and_the_independent_ones() {
    // One degree of freedom is Cauchy, two have t/√(2 + t²).
    for t in [0.0f64, 0.1, 1.0, 3.0, 40.0] {
        let cauchy = 2.0 / std::f64::consts::PI * t.atan();
        assert!((student_central(1, t) - cauchy).abs() < 1e-15, "{t}");
        assert!((student_central(2, t) - t / (2.0 + t * t).sqrt()).abs() < 1e-15, "{t}");
        for dof in [3, 4, 7, 8, 29, 100, 999] {
            let tail = student_two_sided(f64::from(dof), t);
            assert!((1.0 - student_central(dof, t) - tail).abs() < 1e-12, "{dof} {t}");
        }
    }
}

#[test]
fn student_quantiles_are_those_of_the_tables() {
    // Abramowitz & Stegun, table 26.10, and the normal limit.
    for (dof, expected) in [(1, 12.7062047), (2, 4.3026527), (7, 2.3646243), (30, 2.0422725), (1_000_000, 1.9599664)] {
        assert!((student_quantile(dof, 0.95) - expected).abs() < 2e-6 * expected, "{dof}");
    }
    assert_eq!(student_quantile(0, 0.95), f64::INFINITY);
}

#[test]
fn a_mean_has_its_standard_error() {
    let (mean, error) = mean_and_error(&[1.0, 2.0, 3.0, 4.0]);
    assert_eq!(mean, 2.5);
    assert!((error - (5.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
    let one = Estimate::mean(&[3.0]);
    assert_eq!((one.value, one.lo, one.hi), (3.0, f64::NEG_INFINITY, f64::INFINITY));
    assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0])), (2.0, 2.5));
    assert!(median(&[]).is_nan());
}

#[test]
fn an_infinite_end_survives_json() {
    for estimate in [Estimate::mean(&[3.0]), Estimate::mean(&[3.0, 4.0])] {
        let text = serde_json::to_string(&estimate).unwrap();
        assert_eq!(serde_json::from_str::<Estimate>(&text).unwrap(), estimate, "{text}");
    }
}

#[test]
fn an_exact_power_law_is_found() {
    let points: Vec<_> = [1.0, 4.0, 16.0, 64.0].map(|x: f64| (x, sharp(0.3 * x.powf(-1.25)))).to_vec();
    let law = fit_power_law(&points).unwrap();
    assert!((law.exponent.value + 1.25).abs() < 1e-12);
    assert!((law.constant - 0.3).abs() < 1e-12);
    assert!(law.exponent.hi - law.exponent.lo < 1e-7);
    assert!(law.lack_of_fit.unwrap() < 1e-6);
    assert!(fit_power_law(&points[..1]).is_none());
    assert!(fit_power_law(&[(1.0, sharp(1.0)), (1.0, sharp(2.0))]).is_none());
    // Errors at or below the reference's noise are no points of a logarithmic line.
    let with_negative = [points.as_slice(), &[(256.0, sharp(1.0).minus(2.0))]].concat();
    assert_eq!(fit_power_law(&with_negative).unwrap().exponent.value, law.exponent.value);
}

#[test]
fn the_exponents_error_follows_from_the_points() {
    // Two points a factor e apart, each with relative error r: the variance is 2 r².
    let r = 0.02;
    let points = [(1.0, Estimate::student(5.0, 5.0 * r, 7)), (std::f64::consts::E, Estimate::student(2.0, 2.0 * r, 7))];
    let law = fit_power_law(&points).unwrap();
    assert!((law.exponent.standard_error - (2.0f64).sqrt() * r).abs() < 1e-12);
    // Satterthwaite of two equal parts with 7 each.
    assert_eq!(law.exponent.dof, 14);
    assert_eq!(law.lack_of_fit, None);
}

#[test]
fn a_bent_curve_is_told_from_a_straight_one() {
    let bent: Vec<_> = [1.0f64, 4.0, 16.0, 64.0].map(|x| (x, Estimate::student(1.0 / x + 0.1, 0.01 / x, 7))).to_vec();
    assert!(fit_power_law(&bent).unwrap().lack_of_fit.unwrap() > 10.0);
}

#[test]
fn the_budget_to_an_error_is_interpolated_and_says_when_not() {
    let points: Vec<_> = [1.0, 4.0, 16.0].map(|x: f64| (x, sharp(1.0 / x))).to_vec();
    let minus_one = Some(sharp(-1.0));
    let reached = budget_for(&points, 0.125, minus_one).unwrap();
    assert!((reached.budget - 8.0).abs() < 1e-12 && !reached.extrapolated);
    let reached = budget_for(&points, 0.01, minus_one).unwrap();
    assert!((reached.budget - 100.0).abs() < 1e-9 && reached.extrapolated);
    let reached = budget_for(&points, 2.0, minus_one).unwrap();
    assert!((reached.budget - 0.5).abs() < 1e-12 && reached.extrapolated);
    let at_the_end = budget_for(&points, 1.0 / 16.0, minus_one).unwrap();
    assert!((at_the_end.budget - 16.0).abs() < 1e-12 && !at_the_end.extrapolated);
    assert_eq!(budget_for(&points, 0.01, None), None);
    assert_eq!(budget_for(&points, 0.01, Some(sharp(0.2))), None);
    assert_eq!(budget_for(&[], 0.01, minus_one), None);
    // A curve that rises again: only from the last fall on is the error reached.
    let wavy = [(1.0, 1.0), (2.0, 0.1), (4.0, 1.0), (8.0, 0.1)].map(|(x, y)| (x, sharp(y)));
    assert!((4.0..8.0).contains(&budget_for(&wavy, 0.5, None).unwrap().budget));
}

/// Seconds that hardly differ (a loaded machine) make lines of any slope; what a report says of them must be read back.
#[test]
fn what_is_out_of_range_is_not_said() {
    let points: Vec<_> = [1.0, 4.0].map(|x: f64| (x, sharp(x.powf(-1e-4)))).to_vec();
    let slope = fit_power_law(&points).map(|law| law.exponent);
    assert_eq!(budget_for(&points, 1e-2, slope), None, "e to the 46,000");
    let reached = |exponent: f64, target: f64| {
        let points: Vec<_> = [1.0, 4.0].map(|x: f64| (x, sharp(x.powf(exponent)))).to_vec();
        budget_for(&points, target, fit_power_law(&points).map(|law| law.exponent))
    };
    assert_eq!(reached(-0.05, 1e-2), None, "10 to the 40: years nobody has");
    assert!(reached(-0.5, 1e-3).is_some_and(|reached| (reached.budget - 1e6).abs() < 1.0));
    for x in [0.05, 5.0] {
        let steep = [(x, sharp(1.0)), (x * (1.0 + 1e-5), sharp(0.5))];
        assert_eq!(fit_power_law(&steep), None, "a constant of {x} to the 69,000");
    }
    let wide = [(0.05, sharp(1.0)), (0.06, sharp(0.5))];
    for law in [fit_power_law(&points), fit_power_law(&wide)] {
        let text = serde_json::to_string(&law).unwrap();
        assert!(serde_json::from_str::<Option<PowerLaw>>(&text).unwrap().is_some(), "{text}");
    }
}

#[test]
fn products_add_relative_errors_in_quadrature() {
    let (a, b) = (Estimate::student(2.0, 0.06, 7), Estimate::student(5.0, 0.2, 5));
    let product = a.times(b);
    assert!((product.relative_error() - 0.05).abs() < 1e-15 && product.value == 10.0 && product.dof == 5);
    let blurred = a.uncertain_by(b);
    assert!((blurred.relative_error() - 0.05).abs() < 1e-15 && blurred.value == 2.0);
}

/// Errors 1/x, each known to 3 % from eight seeds, met at 1, 4, 16, 64: the intervals of the budgets hold the true ones in
/// 95 % of 4,000 cases, between the points and beyond them.
#[test]
fn intervals_of_budgets_cover() {
    let mut rng = crate::stats::Rng::new(11);
    let mut covered = [0.0; 3];
    const CASES: usize = 4000;
    for _ in 0..CASES {
        let point = |x: f64, rng: &mut crate::stats::Rng| {
            let seeds: Vec<f64> = (0..8).map(|_| (1.0 + 0.03 * 8f64.sqrt() * rng.normal()) / x).collect();
            (x, Estimate::mean(&seeds))
        };
        let points: Vec<_> = [1.0, 4.0, 16.0, 64.0].map(|x| point(x, &mut rng)).to_vec();
        let slope = fit_power_law(&points).map(|law| law.exponent);
        for (covered, budget) in covered.iter_mut().zip([2.0, 40.0, 640.0]) {
            let reached = budget_for(&points, 1.0 / budget, slope).unwrap();
            assert_eq!(reached.extrapolated, budget > 64.0);
            *covered += f64::from(u8::from((reached.lo..=reached.hi).contains(&budget))) / CASES as f64;
        }
    }
    println!("covered: {covered:?}");
    // The lesser of two degrees of freedom and a sum instead of a root widen intervals and never narrow them. Shares of
    // 4,000 are known to .0034.
    assert!(covered.iter().all(|c| (0.94..0.998).contains(c)));
}
