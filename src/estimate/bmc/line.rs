//! Bayesian Monte Carlo on the unit interval: the uniform measure and two covariances with closed integrals.

use super::weights::{Mean, System, Verdict, weights};
use crate::estimate::method::{Claim, Method, Prepared, Shared, Single};
use crate::estimate::points::{Points, unit};
use crate::estimate::special::erf;
use crate::kernel::Width;
use std::f64::consts::{FRAC_PI_2, SQRT_2};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Covariance {
    /// exp(−(x − x′)²/2ℓ²).
    SquaredExponential { length: f64 },
    /// 1 − |x − x′|: the first Sobolev space of the interval, whose posterior mean is piecewise linear.
    Sobolev,
}

impl Covariance {
    pub fn between(self, x: f64, y: f64) -> f64 {
        match self {
            Self::SquaredExponential { length } => (-0.5 * ((x - y) / length).powi(2)).exp(),
            Self::Sobolev => 1.0 - (x - y).abs(),
        }
    }

    /// ∫₀¹ k(x, y) dy.
    pub fn embedding(self, x: f64) -> f64 {
        match self {
            Self::SquaredExponential { length: l } => {
                let root = SQRT_2 * l;
                l * FRAC_PI_2.sqrt() * (erf((1.0 - x) / root) + erf(x / root))
            }
            Self::Sobolev => 1.0 - 0.5 * (x * x + (1.0 - x) * (1.0 - x)),
        }
    }

    /// ∫∫ k.
    pub fn self_energy(self) -> f64 {
        match self {
            Self::SquaredExponential { length: l } => {
                let root = SQRT_2 * l;
                2.0 * l * l * (FRAC_PI_2.sqrt() / l * erf(1.0 / root) + f64::exp_m1(-0.5 / (l * l)))
            }
            Self::Sobolev => 2.0 / 3.0,
        }
    }

    pub fn system(self, x: &[f64]) -> System {
        System {
            gram: x.iter().flat_map(|&a| x.iter().map(move |&b| self.between(a, b))).collect(),
            z: x.iter().map(|&x| self.embedding(x)).collect(),
            total: 1.0,
            self_energy: self.self_energy(),
        }
    }
}

/// More points than this cost more than their worth: the weights of n points cost n³.
const MOST_POINTS: usize = 256;
/// Estimates with points and weights of their own.
const SETS: usize = 64;

/// Independent uniform points, an unknown constant mean, weights anew for each estimate.
pub fn bmc(name: &str, covariance: Covariance, integrand: Shared) -> Method {
    Method::new(name, Claim::Biased, move |n| {
        let plan = Points::Independent.plan(n, 1).filter(|_| n <= MOST_POINTS)?;
        let system = {
            let plan = plan.clone();
            move |key: u64| {
                let mut bits = vec![Vec::new()];
                plan.fill(Width::One, key, &mut bits);
                let x: Vec<f64> = bits[0][..plan.len()].iter().map(|&b| unit(b)).collect();
                (weights(&covariance.system(&x), Mean::Constant, 0.0), x)
            }
        };
        let verdict = system(0).0.conditioning;
        let note = (verdict.verdict != Verdict::Posterior).then(|| verdict.to_string());
        let integrand = integrand.clone();
        let run = move |key: u64, _: usize| {
            let (weights, x) = system(key);
            let y: Vec<f64> = x.iter().map(|&x| integrand.at(&[x])).collect();
            Single { value: weights.estimate(&y), standard_error: weights.variance(&y).map(f64::sqrt) }
        };
        Some(Prepared { note, distinct: Some(SETS), ..Prepared::new(plan.len(), run) })
    })
}
