//! Weights of a Gaussian-process posterior, and whether they may be trusted.

use crate::estimate::cholesky::{Cholesky, dot};
use serde::Serialize;
use std::fmt;

/// What is believed of the mean of the function before it is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mean {
    /// 0 (O'Hagan 1991): the estimate shrinks towards 0 where points are few.
    Zero,
    /// Constant and unknown, with a flat prior: Σw = P, and a constant function is integrated exactly.
    Constant,
}

/// The integrals behind a set of n points, from one covariance and one measure.
#[derive(Clone, Debug)]
pub struct System {
    /// k(ω_i, ω_j), row by row.
    pub gram: Vec<f64>,
    /// z_i = ∫ k(ω_i, ·) p.
    pub z: Vec<f64>,
    /// P = ∫ p.
    pub total: f64,
    /// V₀ = ∬ k p p.
    pub self_energy: f64,
}

/// The first jitter tried, as a fraction of the mean of Q's diagonal, and the last: each is ten times the one before.
const JITTERS: [f64; 7] = [1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
/// How far Σ|w|/Σw may lie above 1: beyond it the weights fight one another and amplify what the kernel does not explain.
pub const MAX_ABSOLUTE_RATIO: f64 = 1.1;
/// A pivot is what remains unknown of a value once those before it are known: below this fraction of the prior variance
/// (a third of a percent of its standard deviation) the jitter has a say in it.
const SMALLEST_PIVOT: f64 = 1e-5;
/// How far Σw may be from P, relatively: rounding of the solve.
const SUM_TOLERANCE: f64 = 1e-6;

/// What became of the linear system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Conditioning {
    /// Added to the diagonal, as a fraction of its mean.
    pub jitter: f64,
    /// Σ|w|/Σw of the last weights computed.
    pub absolute_ratio: f64,
    /// Σw/P − 1 of the last weights computed.
    pub sum_error: f64,
    /// The smallest pivot of the last factorisation, as a fraction of Q's diagonal; 0 if there was none.
    pub smallest_pivot: f64,
    pub verdict: Verdict,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The weights are the posterior's.
    Posterior,
    /// Ill-conditioned: pivots sank to the jitter, or it had to be raised. The weights passed the gate, but their posterior
    /// variance is that of the jitter as much as of the covariance.
    Damped,
    /// Ill-conditioned at every jitter: each weight is P/n, the plain mean.
    EqualWeights,
}

impl fmt::Display for Conditioning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.verdict {
            Verdict::Posterior => write!(f, "well conditioned")?,
            Verdict::Damped => write!(f, "ill-conditioned, damped")?,
            Verdict::EqualWeights => write!(f, "ill-conditioned, equal weights instead")?,
        }
        write!(
            f,
            " (jitter {:e}, Σ|w|/Σw {:.4}, smallest pivot {:.1e})",
            self.jitter, self.absolute_ratio, self.smallest_pivot
        )
    }
}

/// Weights for the values at the points: Î = Σ w_i y_i.
#[derive(Clone, Debug)]
pub struct Weights {
    pub w: Vec<f64>,
    pub conditioning: Conditioning,
    /// Posterior variance of the integral where k has σ_f² = 1; `None` for equal weights, which have no posterior.
    pub unit_variance: Option<f64>,
    mean: Mean,
    /// Of the distinct points; `None` for equal weights.
    factor: Option<Cholesky>,
    /// Q⁻¹1/(1ᵀQ⁻¹1): the weights of the distinct points in the mean of the process.
    centre: Vec<f64>,
    /// For each point, which distinct one it repeats.
    distinct: Vec<usize>,
}

/// w = Q⁻¹z, or with an unknown constant mean w + (P − 1ᵀw)/(1ᵀQ⁻¹1) · Q⁻¹1. `noise` is σ_n²/σ_f².
///
/// Repeated points are one observation, so that Q is not singular because a sample came twice. The jitter rises until Q
/// factors and the gate is passed: Σ|w|/Σw ≤ 1.1 and, for a constant mean, Σw = P. If it never is, weights are equal.
/// With no points there are no weights.
pub fn weights(system: &System, mean: Mean, noise: f64) -> Weights {
    let distinct = distinct_points(system);
    let reduced = reduce(system, &distinct);
    let n = reduced.z.len();
    let diagonal = (0..n).map(|i| reduced.gram[i * n + i]).sum::<f64>() / n.max(1) as f64;
    let mut seen = Conditioning {
        jitter: 0.0,
        absolute_ratio: f64::INFINITY,
        sum_error: f64::NAN,
        smallest_pivot: 0.0,
        verdict: Verdict::EqualWeights,
    };
    for jitter in JITTERS {
        seen.jitter = jitter;
        let Some(factor) = Cholesky::new(&reduced.gram, n, jitter * diagonal + noise) else { continue };
        let (w, unit_variance) = posterior(&reduced, mean, &factor);
        let (sum, absolute) = (w.iter().sum::<f64>(), w.iter().map(|w| w.abs()).sum::<f64>());
        seen.absolute_ratio = absolute / sum;
        seen.sum_error = sum / system.total - 1.0;
        seen.smallest_pivot = factor.smallest_pivot() / diagonal;
        let sums_to_total = mean == Mean::Zero || seen.sum_error.abs() <= SUM_TOLERANCE;
        // False for a NaN, and for a negative sum.
        if seen.absolute_ratio >= 0.0 && seen.absolute_ratio <= MAX_ABSOLUTE_RATIO && sums_to_total {
            let damped = jitter > JITTERS[0] || seen.smallest_pivot < SMALLEST_PIVOT;
            seen.verdict = if damped { Verdict::Damped } else { Verdict::Posterior };
            let w = spread(&w, &distinct);
            return Weights {
                w,
                conditioning: seen,
                unit_variance: Some(unit_variance),
                mean,
                centre: centre(&factor, n),
                factor: Some(factor),
                distinct,
            };
        }
    }
    let w = vec![system.total / distinct.len().max(1) as f64; distinct.len()];
    Weights { w, conditioning: seen, unit_variance: None, mean, factor: None, centre: Vec::new(), distinct }
}

/// The weights and the posterior variance at σ_f² = 1 (Rasmussen & Ghahramani 2003; the constant mean as in Rasmussen &
/// Williams 2006, § 2.7, in the limit of a flat prior).
fn posterior(system: &System, mean: Mean, factor: &Cholesky) -> (Vec<f64>, f64) {
    let mut w = factor.solve(&system.z);
    let mut variance = system.self_energy - dot(&w, &system.z);
    if mean == Mean::Constant {
        let ones = factor.solve(&vec![1.0; w.len()]);
        let information: f64 = ones.iter().sum();
        let missing = system.total - w.iter().sum::<f64>();
        w.iter_mut().zip(&ones).for_each(|(w, one)| *w += missing / information * one);
        variance += missing * missing / information;
    }
    // Rounding alone makes it negative.
    (w, variance.max(0.0))
}

impl Weights {
    /// Î = Σ w_i y_i, in index order.
    pub fn estimate(&self, y: &[f64]) -> f64 {
        self.w.iter().zip(y).map(|(w, y)| w * y).sum()
    }

    /// (1 − λ) w + λ P/n: drawn towards the plain mean, see [`Pilot`](super::Pilot). The variance that the process has for
    /// it is V + λ² δᵀQδ, δ = P/n − w, since V is least at w among weights of the same sum; only for a constant mean.
    pub fn shrunk(mut self, intensity: f64, total: f64) -> Self {
        let Some(factor) = self.factor.as_ref().filter(|_| intensity != 0.0) else { return self };
        let equal = total / self.w.len() as f64;
        let mut away = vec![0.0; self.centre.len()];
        self.distinct.iter().zip(&self.w).for_each(|(&i, w)| away[i] += equal - w);
        self.unit_variance = self.unit_variance.map(|v| v + intensity.powi(2) * factor.energy(&away));
        self.w.iter_mut().for_each(|w| *w += intensity * (equal - *w));
        self
    }

    /// σ̂_f² = rᵀQ⁻¹r/(n − 1), r = y − μ̂ (rᵀQ⁻¹r/n for a known mean). `None` for equal weights or a single point.
    pub fn scale(&self, y: &[f64]) -> Option<f64> {
        let factor = self.factor.as_ref()?;
        let mut seen = vec![0.0; self.distinct.iter().max()? + 1];
        self.distinct.iter().zip(y).for_each(|(&i, &y)| seen[i] = y);
        scale(factor, &self.centre, &seen, self.mean)
    }

    /// Variance of the integral given the values: [`Weights::unit_variance`] · [`Weights::scale`].
    pub fn variance(&self, y: &[f64]) -> Option<f64> {
        Some(self.unit_variance? * self.scale(y)?)
    }
}

/// Q⁻¹1/(1ᵀQ⁻¹1).
pub(super) fn centre(factor: &Cholesky, n: usize) -> Vec<f64> {
    let mut ones = factor.solve(&vec![1.0; n]);
    let sum: f64 = ones.iter().sum();
    ones.iter_mut().for_each(|one| *one /= sum);
    ones
}

pub(super) fn scale(factor: &Cholesky, centre: &[f64], y: &[f64], mean: Mean) -> Option<f64> {
    match mean {
        Mean::Zero => (!y.is_empty()).then(|| factor.quadratic(y) / y.len() as f64),
        Mean::Constant => {
            let middle = dot(centre, y);
            let residual: Vec<f64> = y.iter().map(|y| y - middle).collect();
            (y.len() > 1).then(|| factor.quadratic(&residual) / (y.len() - 1) as f64)
        }
    }
}

/// For each point the number of the distinct point it equals: those whose covariance with it is that of a point with
/// itself, both ways, to the last bit.
fn distinct_points(system: &System) -> Vec<usize> {
    let n = system.z.len();
    let mut first: Vec<usize> = Vec::with_capacity(n);
    let number = |i: usize| {
        let same = |&j: &usize| {
            let k = system.gram[i * n + j];
            k == system.gram[i * n + i] && k == system.gram[j * n + j] && system.z[i] == system.z[j]
        };
        first.iter().position(same).unwrap_or_else(|| {
            first.push(i);
            first.len() - 1
        })
    };
    (0..n).map(number).collect()
}

fn reduce(system: &System, distinct: &[usize]) -> System {
    let n = distinct.len();
    let mut kept: Vec<usize> = Vec::with_capacity(n);
    for (i, &number) in distinct.iter().enumerate() {
        if number == kept.len() {
            kept.push(i);
        }
    }
    if kept.len() == n {
        return system.clone();
    }
    System {
        gram: kept.iter().flat_map(|&i| kept.iter().map(move |&j| system.gram[i * n + j])).collect(),
        z: kept.iter().map(|&i| system.z[i]).collect(),
        ..*system
    }
}

/// A distinct point's weight shared among its repetitions.
fn spread(w: &[f64], distinct: &[usize]) -> Vec<f64> {
    let mut times = vec![0.0; w.len()];
    distinct.iter().for_each(|&i| times[i] += 1.0);
    distinct.iter().map(|&i| w[i] / times[i]).collect()
}
