//! What is shown instead of studied.

use octolux::estimate::demos::{Demonstration, gp_line, ohagan, variance_rules};
use octolux::estimate::expression::Expression;
use octolux::estimate::problems::interval;
use octolux::kernel::Width;

fn shown(name: &str) -> (Expression, octolux::estimate::study::Quantity) {
    let quantity = interval(name, [0.0, 1.0], None, Width::One).unwrap().quantity;
    (Expression::parse(name).unwrap(), quantity)
}

fn column(demonstration: &Demonstration, part: usize, column: usize) -> Vec<String> {
    demonstration.sections[part].table.rows.iter().map(|row| row[column].text.clone()).collect()
}

#[test]
fn a_repeated_sample_is_no_news_to_the_posterior() {
    let (f, quantity) = shown("exp(x)");
    for seed in 0..5 {
        let d = ohagan(&f, &quantity, 6, seed).unwrap();
        let (monte_carlo, bayes, q) = (column(&d, 1, 1), column(&d, 1, 3), column(&d, 1, 5));
        assert!(monte_carlo[0] != monte_carlo[1] && bayes[0] == bayes[1], "{d}");
        assert!(q[0] != "singular" && q[1] == "singular", "{d}");
        // One set of samples, two densities: two estimates.
        let estimates = column(&d, 0, 1);
        assert!(estimates[0] != estimates[1]);
    }
}

/// 13 rules by 200,000 rolls: each within five standard errors, and a wrong factor would be off by hundreds.
#[test]
fn variances_follow_their_rules() {
    let d = variance_rules(200_000, 3);
    let (exact, measured, half) = (column(&d, 0, 1), column(&d, 0, 2), column(&d, 0, 3));
    assert_eq!(exact.len(), 13);
    for ((e, m), h) in exact.iter().zip(&measured).zip(&half) {
        let [e, m, h] = [e, m, h].map(|t| t.parse::<f64>().unwrap());
        assert!((m - e).abs() <= 5.0 / 1.96 * h + 1e-6, "{e} {m} {h}");
    }
}

#[test]
fn the_posterior_closes_in_on_the_integral() {
    let (f, quantity) = shown("sin(2*PI*x)+x");
    let d = gp_line(&f, &quantity, &[3, 12, 24], 0).unwrap();
    let integrals = d.sections.last().unwrap();
    let number = |row: usize, column: usize| integrals.table.rows[row][column].text.parse::<f64>();
    // Smooth covariance: three points, twelve, twenty-four.
    assert!(number(1, 4).unwrap().abs() < number(0, 4).unwrap().abs());
    assert!(number(2, 4).unwrap().abs() < 1e-3);
    assert_eq!(d.sections[0].plots.len(), 4);
    assert!(gp_line(&Expression::parse("1/(x-x)").unwrap(), &quantity, &[3], 0).is_err());
}
