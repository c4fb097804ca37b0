//! Exact values, exact variances, exact errors of rules; problems that are none are refused.

use super::{cell, study};
use crate::stats::oracle;
use octolux::estimate::expression::Expression;
use octolux::estimate::problems::{Problem, UnitProblem, Wanted, continuous, cube, discrete, interval, pi};
use octolux::kernel::Width;
use std::f64::consts::PI;

const W: Width = Width::Eight;

fn die() -> UnitProblem {
    let table: Vec<[f64; 2]> = (1..=6).map(|i| [f64::from(i), 1.0 / 6.0]).collect();
    discrete("die", &table, W).unwrap()
}

#[track_caller]
fn close(value: f64, expected: f64, relative: f64) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{value} for {expected}");
}

#[test]
fn exact_values_and_variances_are_the_oracles() {
    assert_eq!(pi(W).quantity.exact, PI);
    close(pi(W).variance, 2.696_766_213, 1e-9);
    for (id, value) in [
        ("H.die_mean", die().quantity.exact),
        ("H.die_var", die().variance),
        ("H.exp1d_mean", interval("exp", [0.0, 1.0], None, W).unwrap().quantity.exact),
        ("H.exp1d_var", interval("exp", [0.0, 1.0], None, W).unwrap().variance),
        ("H.prod6_var", cube("sine", 6, W).unwrap().variance),
        ("H.poly6_var", cube("linear", 6, W).unwrap().variance),
        ("H.firefly_var_p1e-2", discrete("firefly", &[[0.0, 0.99], [100.0, 0.01]], W).unwrap().variance),
    ] {
        let Some(case) = oracle(id) else { return };
        close(value, case.value, 1e-11);
    }
    // A function nobody integrated before: by quadrature, with its error.
    let written = interval("exp(x)", [0.0, 1.0], None, W).unwrap().quantity;
    close(written.exact, 1f64.exp() - 1.0, 1e-14);
    assert!(written.exact_error < 1e-14);
    let jump = interval("floor(3*x)", [0.0, 1.0], None, W).unwrap().quantity;
    assert!((jump.exact - 1.0).abs() <= jump.exact_error && jump.exact_error < 1e-10, "{jump:?}");
}

/// f·cosθ over the hemisphere with the densities of the oracles: theirs are per unit of π.
#[test]
fn hemispherical_variances_are_the_oracles() {
    use octolux::estimate::problems::{Density, hemisphere};
    let cosine = |exponent| hemisphere("cosine", exponent, 0, W).unwrap();
    let square = PI * PI;
    for (id, exponent, density) in [
        ("H.unif_hemi_var", 1.0, Density::Uniform),
        ("H.cosn_n0", 1.0, Density::Phong(0.0)),
        ("H.cosn_n0.5", 1.0, Density::Phong(0.5)),
        ("H.cosn_n2.9", 1.0, Density::Phong(2.9)),
        ("H.env_cos^1", 2.0, Density::Cosine),
        ("H.env_cos^4", 5.0, Density::Cosine),
    ] {
        let Some(case) = oracle(id) else { return };
        close(cosine(exponent).variance(density) / square, case.value, 1e-11);
    }
    assert_eq!(cosine(1.0).variance(Density::Cosine), 0.0);
    assert_eq!(cosine(1.0).variance(Density::Phong(3.0)), f64::INFINITY);
    assert_eq!(cosine(0.0).variance(Density::Cosine), f64::INFINITY);
}

#[test]
fn rules_err_as_theory_says() {
    let exp = interval("exp", [0.0, 1.0], None, W).unwrap();
    let s = study(&exp, &["trapezoid"], &[2, 17, 4097], 1, 0);
    for (id, nodes) in [("H.trap_exp_m1", 2), ("H.trap_exp_m16", 17), ("H.trap_exp_m4096", 4097)] {
        let Some(case) = oracle(id) else { return };
        assert!((cell(&s, "trapezoid", nodes).bias.value - case.value).abs() < 1e-14, "{id}");
    }
    let sine = cube("sine", 6, W).unwrap();
    let s = study(&sine, &["trapezoid"], &[729, 15625], 1, 0);
    for (id, nodes) in [("H.prod6_trap_m2", 729), ("H.prod6_trap_m4", 15625)] {
        let Some(case) = oracle(id) else { return };
        // The oracle gives I − T.
        close(-cell(&s, "trapezoid", nodes).bias.value, case.value, 1e-12);
    }
    let linear = cube("linear", 6, W).unwrap();
    let s = study(&linear, &["trapezoid", "gauss"], &[64], 1, 0);
    assert!(s.rows.iter().all(|row| row.cells[0].rmse.value < 1e-14), "exact for a multilinear function");
    // Gauss with n nodes is exact to degree 2n − 1, Simpson to 3.
    let s = study(&interval("x^5", [0.0, 2.0], None, W).unwrap(), &["gauss"], &[3], 1, 0);
    assert!(s.rows[0].cells[0].rmse.value < 1e-13);
    let s = study(&interval("x^3", [0.0, 2.0], None, W).unwrap(), &["simpson"], &[3], 1, 0);
    assert!(s.rows[0].cells[0].rmse.value < 1e-14);
}

#[test]
fn a_users_density_is_checked_and_sampled() {
    let refused = |p: &str, range| continuous(p, range, Wanted::Expectation(Expression::parse("x").unwrap()), W).err();
    let why = refused("3*x", [0.0, 1.0]).expect("integrates to 3/2");
    assert!(why.contains("1.5"), "{why}");
    assert!(refused("2-4*x", [0.0, 1.0]).expect("negative").contains("negative"));
    assert!(refused("ln(x-2)", [0.0, 1.0]).is_some(), "no value");
    assert!(refused("2*y", [0.0, 1.0]).is_none_or(|why| why.contains('y')));
    assert!(refused("2*x", [1.0, 0.0]).is_some());
    // X = √U: E[X] = 2/3, E[X²] = 1/2, Pr(X < 1/2) = 1/4.
    let of = |f: &str| continuous("2*x", [0.0, 1.0], Wanted::Expectation(Expression::parse(f).unwrap()), W).unwrap();
    close(of("x").quantity.exact, 2.0 / 3.0, 1e-13);
    close(of("x").variance, 1.0 / 18.0, 1e-12);
    let event = continuous("2*x", [0.0, 1.0], Wanted::Probability([0.0, 0.5]), W).unwrap();
    close(event.quantity.exact, 0.25, 1e-13);
    close(event.variance, 3.0 / 16.0, 1e-12);
    // By inversion: x at u is √u.
    for u in [1e-9, 0.25, 0.5, 0.81, 1.0 - 1e-12] {
        close(of("x").integrand.at(&[u]), u.sqrt(), 1e-12);
    }
    // An importance density on an interval: the best one leaves no variance.
    let best = interval("square", [0.0, 1.0], Some("3*x^2"), W).unwrap();
    assert!(best.importance.unwrap().1.abs() < 1e-14);
}

/// ∫ xᵃ over [0, 1] is 1/(1 + a), of squares 1/(1 + 2a) where that is: halving a panel at 0 leaves 2^−(1 + a) of an error, so that two
/// values near each other are no proof of being near the truth.
#[test]
fn singular_ends_are_known_as_well_as_is_said() {
    for a in [-0.1, -0.25, -0.4, -0.45, -0.49, -0.5, -0.7, -0.9, -0.95] {
        let problem = interval(&format!("x^({a})"), [0.0, 1.0], None, W).unwrap();
        let (exact, error) = (problem.quantity.exact, problem.quantity.exact_error);
        let truth = 1.0 / (1.0 + a);
        assert!((exact - truth).abs() <= error && error < 1e-6 * truth, "x^{a}: {exact} ± {error} for {truth}");
        let variance = 1.0 / (1.0 + 2.0 * a) - truth * truth;
        match problem.variance {
            v if a <= -0.5 => assert_eq!(v, f64::INFINITY, "x^{a}"),
            v => assert!((v / variance - 1.0).abs() < 1e-3, "x^{a}: {v} for {variance}"),
        }
    }
    // Not at an end: numbers next to .3 are too far from each other to corner it as well.
    let inside = interval("abs(x-0.3)^(-0.5)", [0.0, 1.0], None, W).unwrap();
    let truth = 2.0 * (0.3f64.sqrt() + 0.7f64.sqrt());
    let (exact, error) = (inside.quantity.exact, inside.quantity.exact_error);
    assert!((exact - truth).abs() <= error && error < 1e-5, "{exact} ± {error} for {truth}");
    for divergent in ["1/x", "x^(-1.5)", "1/abs(x-0.3)"] {
        assert!(interval(divergent, [0.0, 1.0], None, W).is_err(), "{divergent}");
    }
}

#[test]
fn tables_and_expressions_that_are_none_are_refused() {
    for bad in [&[][..], &[[1.0, 0.5]], &[[1.0, 0.5], [2.0, 0.6]], &[[1.0, -0.5], [2.0, 1.5]], &[[f64::NAN, 1.0]]] {
        assert!(discrete("bad", bad, W).is_err(), "{bad:?}");
    }
    assert!(discrete("bad", &[[1.0, 0.5], [2.0, 0.6]], W).err().unwrap().contains("1.1"));
    for bad in ["", "x+", "f(x)", "x*y", "((x)", "x,x", "é"] {
        assert!(Expression::parse(bad).is_err(), "{bad:?}");
    }
    assert_eq!(Expression::parse("2").unwrap().at(7.0), 2.0);
    assert!(interval("1/x", [-1.0, 1.0], None, W).is_err());
    assert!(cube("sine", 0, W).is_err() && cube("sine", 21, W).is_err() && cube("tan", 2, W).is_err());
    let problem = pi(W);
    let why = problem.method("magic").err().expect("no such method");
    assert!(why.contains("halton"), "{why}");
}
