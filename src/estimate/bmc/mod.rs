//! Bayesian Monte Carlo: the integrand is believed to be a Gaussian process, and the estimate is the posterior mean of
//! its integral (O'Hagan 1991; Rasmussen & Ghahramani 2003; for illumination Brouillat et al. 2009).
//!
//! I = ∫ L p with p known: Î = Σ w_i L(ω_i), and the weights depend on the points alone. [`point_sets`] makes them once.

mod covariance;
mod evidence;
pub mod line;
mod measure;
mod sets;
mod shrinkage;
mod weights;

pub use covariance::Covariance;
pub use evidence::{Evidence, grid, rank};
pub use measure::{Measure, Rules, bessel_i0e};
pub use sets::{PointSet, Points, SetRecipe, fibonacci, point_sets, polar_points};
pub use shrinkage::Pilot;
pub use weights::{Conditioning, MAX_ABSOLUTE_RATIO, Mean, System, Verdict, Weights, weights};

/// k of all pairs, row by row.
pub fn gram(covariance: Covariance, points: &[[f64; 3]]) -> Vec<f64> {
    let row = |a: &[f64; 3]| points.iter().map(|&b| covariance.between(*a, b)).collect::<Vec<_>>();
    points.iter().flat_map(row).collect()
}
