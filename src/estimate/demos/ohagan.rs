//! O'Hagan's objections to Monte Carlo (1987, "Monte Carlo is Fundamentally Unsound"): its estimate depends on what the
//! samples were meant to be, not only on what was seen, and on how often a value was seen.

use super::{Demonstration, Part};
use crate::estimate::bmc::line::Covariance;
use crate::estimate::bmc::{Mean, weights};
use crate::estimate::cholesky::Cholesky;
use crate::estimate::expression::Expression;
use crate::estimate::points::unit;
use crate::estimate::study::Quantity;
use crate::report::page::Table;
use crate::sampling::sample_key;

const COVARIANCE: Covariance = Covariance::SquaredExponential { length: 0.5 };

/// `n` samples of `f` on the unit interval, judged by both schools.
///
/// # Errors
/// f has no value at a sample.
pub fn ohagan(f: &Expression, truth: &Quantity, n: usize, seed: u64) -> Result<Demonstration, String> {
    let x: Vec<f64> = (0..n).map(|i| unit(sample_key(seed, 0, i as u32) as u32)).collect();
    let y: Vec<f64> = x.iter().map(|&x| f.at(x)).collect();
    if let Some(bad) = x.iter().zip(&y).find(|(_, y)| !y.is_finite()) {
        return Err(format!("{:?} has no value at x = {}; choose another f", f.text(), bad.0));
    }
    let again = |values: &[f64]| values.iter().copied().chain(values.last().copied()).collect::<Vec<_>>();
    let (x2, y2) = (again(&x), again(&y));
    let lead = format!("∫ {} dx over [0, 1] = {:.8}, from {n} values of the integrand", f.text(), truth.exact);
    Ok(Demonstration {
        title: "ohagan".into(),
        lead,
        sections: vec![two_densities(&x, &y, truth), repeated([&x, &x2], [&y, &y2], truth)],
    })
}

/// Two densities that the same samples may be said to come from.
type Density = (&'static str, fn(f64) -> f64);
const DENSITIES: [Density; 2] = [("1", |_| 1.0), ("(1 + x)·2/3", |x| (1.0 + x) / 1.5)];

fn two_densities(x: &[f64], y: &[f64], truth: &Quantity) -> Part {
    let mut table = Table::new(["estimate", "value", "error"]);
    for (name, p) in DENSITIES {
        let mean = x.iter().zip(y).map(|(&x, y)| y / p(x)).sum::<f64>() / x.len() as f64;
        table =
            table.row([format!("Monte Carlo, samples said to be of density {name}"), number(mean), error(mean, truth)]);
    }
    let bayes = bayes(x, y);
    table = table.row(["Bayesian Monte Carlo, whatever their density".into(), number(bayes), error(bayes, truth)]);
    let prose = "The samples and the values are the same in all rows: only what they were meant to be differs, which tells nothing of \
                 the integrand.";
    Part { title: "One set of samples, two densities".into(), prose: prose.into(), table, plots: Vec::new() }
}

fn repeated(x: [&[f64]; 2], y: [&[f64]; 2], truth: &Quantity) -> Part {
    let mut table = Table::new(["samples", "Monte Carlo", "error", "Bayesian", "error", "Q"]);
    for (name, x, y) in [("once each", x[0], y[0]), ("the last one twice", x[1], y[1])] {
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        let bayes = bayes(x, y);
        // In floating point a zero pivot comes out as a few ulps, of either sign.
        let pivot = Cholesky::new(&COVARIANCE.system(x).gram, x.len(), 0.0).map_or(0.0, |q| q.smallest_pivot());
        let q = if pivot < 1e-14 { "singular".into() } else { format!("smallest pivot {pivot:.1e}") };
        table = table.row([name.into(), number(mean), error(mean, truth), number(bayes), error(bayes, truth), q]);
    }
    let prose = "A value seen again is no news. Monte Carlo counts it twice; the posterior does not change, although its covariance \
                 matrix is now singular: equal rows are one observation.";
    Part { title: "A sample repeated".into(), prose: prose.into(), table, plots: Vec::new() }
}

fn bayes(x: &[f64], y: &[f64]) -> f64 {
    weights(&COVARIANCE.system(x), Mean::Constant, 0.0).estimate(y)
}

fn number(value: f64) -> String {
    format!("{value:.10}")
}

fn error(value: f64, truth: &Quantity) -> String {
    format!("{:+.2e}", value - truth.exact)
}
