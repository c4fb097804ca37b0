//! Point sets with their weights, made once and used at every point of a picture.
//!
//! A covariance sees only ω_i·ω_j and a measure only the angle to its axis: weights outlive any rotation about the axis
//! (Marques et al. 2013, "A Spherical Gaussian Framework for Bayesian Monte Carlo Rendering of Glossy Surfaces").

use super::{Conditioning, Covariance, Mean, Measure, Rules, System, Verdict, Weights, gram, weights};
use crate::sampling::sample_key;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

/// Where directions come from; all are distributed as the measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Points {
    Random,
    /// Owen-scrambled Sobol'.
    Owen,
    /// The spherical Fibonacci lattice, shifted.
    Fibonacci,
}

/// What sets to make.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SetRecipe {
    pub points: Points,
    /// Directions in a set.
    pub n: usize,
    /// How many sets: each has a shift or scramble of its own.
    pub sets: usize,
    pub measure: Measure,
    /// `None`: equal weights, the plain mean.
    pub covariance: Option<Covariance>,
    pub mean: Mean,
    pub seed: u64,
}

/// Directions about +z and their weights: ∫ L p ≈ Σ w_i L(ω_i).
#[derive(Clone, Debug)]
pub struct PointSet {
    /// x, y, z of the directions, unit vectors.
    pub directions: [Vec<f32>; 3],
    pub weights: Vec<f32>,
    /// The posterior behind the weights; `None` for equal weights by request.
    pub posterior: Option<Weights>,
}

impl PointSet {
    /// With weights [drawn](Weights::shrunk) towards equal ones, whose sum is `total`.
    pub fn shrunk(mut self, intensity: f64, total: f64) -> Self {
        self.posterior = self.posterior.map(|posterior| posterior.shrunk(intensity, total));
        if let Some(posterior) = &self.posterior {
            self.weights = posterior.w.iter().map(|&w| w as f32).collect();
        }
        self
    }

    /// What is to be said of the weights; `None` for equal weights by request.
    pub fn conditioning(&self) -> Option<Conditioning> {
        self.posterior.as_ref().map(|p| p.conditioning)
    }

    /// Were posterior weights asked for, and refused?
    pub fn fell_back(&self) -> bool {
        self.conditioning().is_some_and(|c| c.verdict == Verdict::EqualWeights)
    }
}

/// The sets of a recipe, in parallel; the same for any number of threads.
pub fn point_sets(recipe: &SetRecipe) -> Vec<PointSet> {
    let rules = Rules::new();
    let energy = recipe.covariance.map_or(0.0, |k| recipe.measure.self_energy(k, &rules));
    (0..recipe.sets).into_par_iter().map(|set| point_set(recipe, set as u32, energy, &rules)).collect()
}

fn point_set(recipe: &SetRecipe, set: u32, self_energy: f64, rules: &Rules) -> PointSet {
    let polar = polar_points(recipe.points, recipe.measure, recipe.n, recipe.seed, set);
    let unit: Vec<[f64; 3]> = polar.iter().map(|&p| direction(p)).collect();
    let posterior = recipe.covariance.map(|k| {
        let z = polar.iter().map(|&[cos, _]| recipe.measure.embedding(k, cos.acos(), rules)).collect();
        weights(&System { gram: gram(k, &unit), z, total: recipe.measure.total(), self_energy }, recipe.mean, 0.0)
    });
    let equal = recipe.measure.total() / recipe.n as f64;
    let weights = match &posterior {
        Some(posterior) => posterior.w.iter().map(|&w| w as f32).collect(),
        None => vec![equal as f32; recipe.n],
    };
    PointSet {
        directions: std::array::from_fn(|axis| unit.iter().map(|w| w[axis] as f32).collect()),
        weights,
        posterior,
    }
}

/// (cosθ, φ/2π) of `n` directions distributed as the measure.
pub fn polar_points(points: Points, measure: Measure, n: usize, seed: u64, set: u32) -> Vec<[f64; 2]> {
    let square: Vec<[f64; 2]> = match points {
        Points::Random => (0..n).map(|i| unit_pair(sample_key(seed, set, i as u32))).collect(),
        Points::Owen => (0..n as u32).map(|i| crate::sampling::sobol::owen_pair(i, sample_key(seed, set, 0))).collect(),
        Points::Fibonacci => fibonacci(n, unit_pair(sample_key(seed, set, 0))),
    };
    square.into_iter().map(|[u, v]| [measure.inverse_cdf(u), v]).collect()
}

/// The lattice ((i + ξ₀)/n, i/Φ + ξ₁ mod 1), Φ the golden ratio: each point by itself is uniform over (ξ₀, ξ₁) and i, so
/// that equal weights are unbiased (Marques et al. 2013, "Spherical Fibonacci Point Sets for Illumination Integrals").
pub fn fibonacci(n: usize, shift: [f64; 2]) -> Vec<[f64; 2]> {
    const INVERSE_GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..n).map(|i| [(i as f64 + shift[0]) / n as f64, (i as f64 * INVERSE_GOLDEN + shift[1]).fract()]).collect()
}

/// Two numbers in (0, 1) of a key: the centres of 2³² cells.
fn unit_pair(key: u64) -> [f64; 2] {
    [key as u32, (key >> 32) as u32].map(|bits| (f64::from(bits) + 0.5) * f64::powi(2.0, -32))
}

fn direction([cos, turn]: [f64; 2]) -> [f64; 3] {
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    let (s, c) = (TAU * turn).sin_cos();
    [sin * c, sin * s, cos]
}
