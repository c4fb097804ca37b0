//! Statistics for tests: chi-square over the sphere, means within Šidák bounds, the oracles' file.
//!
//! From a sibling test module: `use crate::stats;`, then for instance
//!
//! ```ignore
//! // Do the samples follow the pdf? Panics with a table of the worst cells if not.
//! stats::Chi2Sphere::new("lambert").run(|rng| sample(rng.f32(), rng.f32()), |w| pdf(w));
//! // Is a mean what theory says, as one of 40 such tests with a family-wise error of 1 %?
//! stats::assert_mean("furnace", &moments, 0.5, 0.0, 40);
//! // A value of ../shared/spec/oracles.json; None (and a printed reason) where that folder is absent.
//! let Some(case) = stats::oracle("C.furnace_lambert_0.5") else { return };
//! ```
//!
//! Nothing here shares code with `src`.

#![allow(dead_code, unused_imports)] // a tool box: not every helper has a user at every commit

mod bounds;
mod chi2;
mod chi2_sphere;
mod moments;
mod oracles;
pub mod quadrature;
mod ratio;
mod rng;
pub mod special;
mod tests;

pub use bounds::{FAMILY_ALPHA, sidak_alpha, t_bound, z_bound};
pub use chi2::{Chi2Outcome, chi2_test};
pub use chi2_sphere::{Chi2Sphere, SphereOutcome, chi2_sphere};
pub use moments::{Moments, assert_mean, assert_variance, mean_problem};
pub use oracles::{OracleCase, oracle, oracles_in, shared_dir};
pub use ratio::ln_ratio;
pub use rng::Rng;
