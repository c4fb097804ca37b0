//! How the `gather` integrator estimates the light at a first hit.

use crate::estimate::bmc::{Covariance, Points};

/// n directions an estimate: where they come from and what they weigh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gather {
    /// Directions an estimate, in 1 … `MOST_DIRECTIONS`.
    pub samples: u32,
    /// Which estimator.
    pub method: GatherMethod,
    /// Where its directions come from.
    pub points: Points,
    /// Density of directions.
    pub pdf: GatherPdf,
    /// Of the Gaussian process, where the method has one.
    pub covariance: GatherCovariance,
    /// Point sets made beforehand, one of them drawn at each hit; in 1 … `MOST_SETS`. Not read for per-hit weights.
    pub sets: u32,
    /// Turns the set about the normal by a random angle at each hit.
    pub rotate: bool,
    /// Whether hits share point sets.
    pub weights: GatherWeights,
    /// Whether weights of a Gaussian process are drawn towards equal ones.
    pub shrinkage: GatherShrinkage,
    /// How lights are found.
    pub lights: GatherLights,
}

/// Weights take O(n³) to make.
pub const MOST_DIRECTIONS: u32 = 1024;
pub const MOST_SETS: u32 = 256;

impl Default for Gather {
    fn default() -> Self {
        Gather {
            samples: 40,
            method: GatherMethod::BmcIs,
            points: Points::Fibonacci,
            pdf: GatherPdf::Cosine,
            covariance: GatherCovariance::Given(Covariance::SOBOLEV),
            sets: 16,
            rotate: true,
            weights: GatherWeights::Shared,
            shrinkage: GatherShrinkage::Pilot,
            lights: GatherLights::Seen,
        }
    }
}

/// The estimators of the course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatherMethod {
    /// Directions uniform over the hemisphere, equal weights.
    Mc,
    /// Directions by importance, equal weights.
    McIs,
    /// p = 1: the Gaussian process models the whole integrand.
    Bmc,
    /// Directions by importance; p is a known factor and the Gaussian process models the rest.
    BmcIs,
}

impl GatherMethod {
    /// As scene files have it.
    pub fn name(self) -> &'static str {
        match self {
            GatherMethod::Mc => "mc",
            GatherMethod::McIs => "mc-is",
            GatherMethod::Bmc => "bmc",
            GatherMethod::BmcIs => "bmc-is",
        }
    }

    /// Are the weights those of a Gaussian process?
    pub fn is_bayesian(self) -> bool {
        matches!(self, GatherMethod::Bmc | GatherMethod::BmcIs)
    }

    /// Do directions come by importance?
    pub fn is_importance(self) -> bool {
        matches!(self, GatherMethod::McIs | GatherMethod::BmcIs)
    }
}

/// What directions are distributed as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatherPdf {
    /// Uniform over the hemisphere about the normal.
    Uniform,
    /// ∝ cosθ.
    Cosine,
    /// ∝ cosθ for Lambert; the lobes of Phong, rough metals and rough coats have n directions of their own, distributed as
    /// the lobe.
    Lobe,
}

/// Where the covariance comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GatherCovariance {
    /// As the scene says.
    Given(Covariance),
    /// The one of [`grid`](crate::estimate::bmc::grid) that best explains a fixed pilot of the scene.
    Fitted,
}

/// Which hits have the same points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatherWeights {
    /// Points and weights are made anew at each hit.
    PerHit,
    /// Point sets and weights are made once for the picture.
    Shared,
}

/// How far weights of a Gaussian process are drawn towards equal ones, which are better for what it does not explain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatherShrinkage {
    /// As far as errs least on a fixed [pilot](crate::estimate::bmc::Pilot) of the scene.
    Pilot,
    /// Not at all: the posterior mean.
    None,
}

/// How lights are found from the first hit. Lights without extent are always sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatherLights {
    /// By the directions that meet them.
    Seen,
    /// By as many light samples as there are directions, which then carry the light of surfaces alone.
    Sampled,
}
