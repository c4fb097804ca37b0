//! A study: every method at every number of samples, many times over, held against the exact value.

use super::method::{Claim, Method, Single};
use crate::film::shares::LARGEST_TRUSTED_OF_VALUE;
use crate::report::fit::{Estimate, PowerLaw, fit_power_law, median};
use crate::report::sidak::{sidak_bound, sidak_student};
use crate::sampling::sample_key;
use rayon::prelude::*;
use serde::Serialize;
use std::time::Instant;

/// What is estimated, and the truth.
#[derive(Clone, Debug, Serialize)]
pub struct Quantity {
    pub name: String,
    pub formula: String,
    pub exact: f64,
    /// How far `exact` itself may be off: 0 for closed forms.
    pub exact_error: f64,
    /// Where it comes from.
    pub source: String,
}

#[derive(Clone, Debug)]
pub struct Budget {
    pub samples: Vec<usize>,
    pub repeats: usize,
    pub seed: u64,
}

/// All the repeats of one method at one number of samples.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// Evaluations an estimate made.
    pub samples: usize,
    /// Independent estimates.
    pub repeats: usize,
    pub mean: Estimate,
    /// E\[Î\] − I.
    pub bias: Estimate,
    /// How many standard errors of the mean the bias is, beyond what rounding may do; `None` where there is no spread.
    pub z: Option<f64>,
    /// |z| beyond what chance allows among all cells of the study.
    pub biased: bool,
    /// Between estimates.
    pub variance: f64,
    pub predicted_variance: Option<f64>,
    /// Measured over predicted variance: its interval holds 1 where theory is right.
    pub variance_ratio: Option<Estimate>,
    /// √ of the mean of the squared standard errors that the estimates gave of themselves.
    pub own_standard_error: Option<f64>,
    /// How often the truth is within ±1.96 of an estimate's own standard errors of it: .95 where the central limit has set in.
    pub own_coverage: Option<f64>,
    /// False where that interval misses, beyond chance, more than twice as often as it says.
    pub own_interval_trusted: bool,
    /// The largest squared error's share of all: above [`LARGEST_TRUSTED_OF_VALUE`] RMSE and variance are those of a few estimates.
    pub largest_share: f64,
    pub rmse: Estimate,
    pub mae: Estimate,
    /// Of a processor, for one estimate.
    pub seconds: f64,
    pub note: Option<String>,
    /// The first estimate.
    pub first: f64,
}

impl Cell {
    /// Why its numbers may not be trusted, in words.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        if let Some(held) = self.own_coverage.filter(|_| !self.own_interval_trusted) {
            doubts.push(format!("its own 95 % intervals hold the truth in {:.1} %", 100.0 * held));
        }
        if self.predicted_variance == Some(f64::INFINITY) {
            doubts.push("its variance is infinite".to_owned());
        }
        if self.largest_share > LARGEST_TRUSTED_OF_VALUE {
            doubts.push(format!("one estimate makes up {:.0} % of the squared error", 100.0 * self.largest_share));
        }
        doubts
    }
}

#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub method: String,
    pub claim: Claim,
    pub cells: Vec<Cell>,
    /// RMSE ∝ n^slope and ∝ seconds^slope.
    pub slope: Option<PowerLaw>,
    pub slope_in_time: Option<PowerLaw>,
}

#[derive(Clone, Debug, Serialize)]
pub struct Study {
    pub quantity: Quantity,
    pub repeats: usize,
    pub seed: u64,
    pub rows: Vec<Row>,
    /// The |z| that a bias must exceed to be called one, where there are `repeats` of it: Šidák at a family-wise 1 %, by
    /// Student's t.
    pub z_bound: f64,
}

/// Runs all methods. Estimates are made in parallel and summed in order: the numbers (not the seconds) are the same for any
/// number of threads. `stop` is asked between cells.
pub fn run(quantity: Quantity, methods: &[Method], budget: &Budget, stop: &(dyn Fn() -> bool + Sync)) -> Study {
    let rows = methods.iter().map(|method| row(&quantity, method, budget, stop)).collect();
    judge(Study { quantity, repeats: budget.repeats, seed: budget.seed, rows, z_bound: 0.0 })
}

/// Marks biases once it is known how many were tested.
fn judge(mut study: Study) -> Study {
    let tested = |row: &Row| row.cells.iter().filter(|cell| cell.z.is_some()).count();
    let tests = study.rows.iter().map(tested).sum::<usize>() as u64;
    let bound = |repeats: usize| sidak_student(tests, repeats.saturating_sub(1).min(u32::MAX as usize) as u32);
    study.z_bound = bound(study.repeats);
    let normal = sidak_bound(tests);
    for cell in study.rows.iter_mut().flat_map(|row| &mut row.cells) {
        let own = if cell.repeats == study.repeats { study.z_bound } else { bound(cell.repeats) };
        cell.biased = cell.z.is_some_and(|z| z.abs() > own);
        let chance = normal * (LEAST_COVERAGE * (1.0 - LEAST_COVERAGE) / cell.repeats as f64).sqrt();
        cell.own_interval_trusted = cell.own_coverage.is_none_or(|held| held >= LEAST_COVERAGE - chance);
    }
    study
}

fn row(quantity: &Quantity, method: &Method, budget: &Budget, stop: &(dyn Fn() -> bool + Sync)) -> Row {
    let mut cells: Vec<Cell> = Vec::new();
    for &n in &budget.samples {
        // Two numbers of samples may come to the same grid.
        let known = |samples: usize| cells.iter().any(|cell| cell.samples == samples);
        if stop() {
            break;
        }
        let Some(prepared) = (method.prepare)(n).filter(|p| !known(p.samples)) else { continue };
        let repeats = match method.claim {
            Claim::Deterministic => 1,
            _ => budget.repeats.min(prepared.distinct.unwrap_or(usize::MAX)),
        };
        let (singles, seconds) = repeat(&*prepared.run, repeats, budget.seed, n);
        let predicted = method.variance.as_ref().map(|law| law(prepared.samples)).filter(|v| !v.is_nan());
        let mut cell = cell(quantity, prepared.samples, &singles, predicted);
        (cell.seconds, cell.note) = (seconds, prepared.note);
        cells.push(cell);
    }
    if cells.is_empty() && !stop() {
        log::warn!("{}: has no estimate of as many samples as were asked for; it is left out", method.name);
    }
    let fit = |x: fn(&Cell) -> f64| fit_power_law(&cells.iter().map(|c| (x(c), c.rmse)).collect::<Vec<_>>());
    let (slope, slope_in_time) = (fit(|c| c.samples as f64), fit(|c| c.seconds));
    Row { method: method.name.clone(), claim: method.claim, cells, slope, slope_in_time }
}

/// Repeat r has the key (seed, n, r), the same for all methods. Seconds are the median over blocks of repeats.
fn repeat(
    run: &(dyn Fn(u64, usize) -> Single + Send + Sync),
    repeats: usize,
    seed: u64,
    n: usize,
) -> (Vec<Single>, f64) {
    const BLOCK: usize = 8;
    let block = |first: usize| {
        let last = (first + BLOCK).min(repeats);
        let start = Instant::now();
        let singles: Vec<Single> = (first..last).map(|r| run(sample_key(seed, n as u32, r as u32), r)).collect();
        (singles, start.elapsed().as_secs_f64() / (last - first) as f64)
    };
    let starts: Vec<usize> = (0..repeats).step_by(BLOCK).collect();
    let blocks: Vec<_> = starts.into_par_iter().map(block).collect();
    let seconds = median(&blocks.iter().map(|b| b.1).collect::<Vec<_>>());
    (blocks.into_iter().flat_map(|b| b.0).collect(), seconds)
}

fn cell(quantity: &Quantity, samples: usize, singles: &[Single], predicted_variance: Option<f64>) -> Cell {
    let repeats = singles.len();
    let values: Vec<f64> = singles.iter().map(|s| s.value).collect();
    let errors: Vec<f64> = values.iter().map(|v| v - quantity.exact).collect();
    let squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
    let sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
    let (mean, bias) = (Estimate::mean(&values), Estimate::mean(&errors));
    let variance = if repeats < 2 { 0.0 } else { mean.standard_error.powi(2) * repeats as f64 };
    // Spread that is rounding is no spread.
    let spread = mean.standard_error > 1e-14 * quantity.exact.abs() && repeats > 1;
    let rounding = ROUNDING * quantity.exact.abs();
    let z = spread.then(|| allow(bias.value, quantity.exact_error + rounding) / mean.standard_error);
    let own: Option<f64> = singles.iter().map(|s| s.standard_error.map(|e| e * e)).sum();
    Cell {
        samples,
        repeats,
        mean,
        bias,
        z,
        biased: false,
        variance,
        predicted_variance,
        variance_ratio: predicted_variance
            .filter(|&p| p > 0.0 && p.is_finite())
            .and_then(|p| ratio(&values, mean.value, p)),
        own_standard_error: own.map(|sum| (sum / repeats as f64).sqrt()),
        own_coverage: coverage(quantity, singles),
        own_interval_trusted: true,
        largest_share: largest_share(&squares),
        rmse: exactly_known(Estimate::mean(&squares).sqrt(), repeats),
        mae: exactly_known(Estimate::mean(&sizes), repeats),
        seconds: 0.0,
        note: None,
        first: values.first().copied().unwrap_or(f64::NAN),
    }
}

/// Misses twice as often as an interval of 95 % should.
const LEAST_COVERAGE: f64 = 0.9;
/// Samples are single precision: closer to the truth than their rounding, relative to it, none can be, and neither can their mean.
const ROUNDING: f64 = f32::EPSILON as f64;
/// P(|Z| ≤ this) = .95.
const NORMAL_95: f64 = 1.959_963_985;

/// `None` where estimates have no idea of their error.
fn coverage(quantity: &Quantity, singles: &[Single]) -> Option<f64> {
    let held = |s: &Single| {
        let off = (s.value - quantity.exact).abs() - quantity.exact_error;
        // A rounding is no miss.
        Some(off <= NORMAL_95 * s.standard_error? + ROUNDING * quantity.exact.abs())
    };
    let held: Vec<bool> = singles.iter().map(held).collect::<Option<_>>()?;
    Some(held.iter().filter(|&&held| held).count() as f64 / held.len().max(1) as f64)
}

fn largest_share(squares: &[f64]) -> f64 {
    let sum: f64 = squares.iter().sum();
    if squares.len() > 1 && sum > 0.0 { squares.iter().fold(0.0, |a: f64, &b| a.max(b)) / sum } else { 0.0 }
}

/// What a value may owe to the error of the exact one, or to rounding, is no bias of the method.
fn allow(bias: f64, error: f64) -> f64 {
    bias.signum() * (bias.abs() - error).max(0.0)
}

/// A single estimate is a rule's only one: its error has no spread.
fn exactly_known(estimate: Estimate, repeats: usize) -> Estimate {
    if repeats > 1 {
        return estimate;
    }
    Estimate { lo: estimate.value, hi: estimate.value, standard_error: 0.0, ..estimate }
}

/// s²/σ² with the standard error √((μ̂₄ − s⁴)/R)/σ².
fn ratio(values: &[f64], mean: f64, predicted: f64) -> Option<Estimate> {
    let squares: Vec<f64> = values.iter().map(|v| (v - mean) * (v - mean)).collect();
    let estimate = Estimate::mean(&squares);
    let n = values.len() as f64;
    // Of the sample variance, whose mean is the true one.
    let unbiased = n / (n - 1.0) / predicted;
    (values.len() > 1)
        .then(|| Estimate::student(estimate.value * unbiased, estimate.standard_error * unbiased, estimate.dof))
}
