//! Hyper-parameters by marginal likelihood.

use super::covariance::Covariance;
use super::weights::{Mean, centre, scale};
use crate::estimate::cholesky::Cholesky;
use serde::Serialize;

/// A covariance and how well it explains what was seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Evidence {
    pub covariance: Covariance,
    /// ln p(y | covariance), summed over the functions seen, up to a constant common to all covariances.
    pub ln_likelihood: f64,
}

/// A nugget that lets smooth covariances factor: the first jitter of the weights.
const NUGGET: f64 = 1e-8;

/// The evidence of each covariance for functions seen at `points`, best first. Each function has its own σ_f² and its own
/// constant mean: the first is profiled out, the second integrated out (restricted likelihood, Patterson & Thompson 1971).
/// A covariance that does not factor is left out; so are functions that are constant, which any covariance explains.
pub fn rank(covariances: &[Covariance], points: &[[f64; 3]], functions: &[Vec<f64>]) -> Vec<Evidence> {
    let varied: Vec<&Vec<f64>> = functions.iter().filter(|y| y.iter().any(|v| *v != y[0])).collect();
    let mut found: Vec<Evidence> = covariances
        .iter()
        .filter_map(|&covariance| {
            let ln_likelihood = ln_likelihood(covariance, points, &varied)?;
            ln_likelihood.is_finite().then_some(Evidence { covariance, ln_likelihood })
        })
        .collect();
    found.sort_by(|a, b| b.ln_likelihood.total_cmp(&a.ln_likelihood));
    found
}

fn ln_likelihood(covariance: Covariance, points: &[[f64; 3]], functions: &[&Vec<f64>]) -> Option<f64> {
    let n = points.len();
    let gram = super::gram(covariance, points);
    let factor = Cholesky::new(&gram, n, NUGGET * gram.first()?)?;
    let information: f64 = factor.solve(&vec![1.0; n]).iter().sum();
    let shape = factor.ln_determinant() + information.ln();
    let centre = centre(&factor, n);
    let each = |y: &&Vec<f64>| -> Option<f64> {
        Some(-0.5 * ((n - 1) as f64 * scale(&factor, &centre, y, Mean::Constant)?.ln() + shape))
    };
    functions.iter().map(each).sum()
}

/// The grid that a length-scale is looked for on, from a tenth of the sphere's radius to twice it, with the Sobolev
/// covariance beside them.
pub fn grid() -> Vec<Covariance> {
    let lengths = [0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0];
    let smooth = [1.25, 1.5, 1.75].map(|smoothness| Covariance::Sobolev { smoothness });
    lengths.map(|length| Covariance::SquaredExponential { length }).into_iter().chain(smooth).collect()
}
