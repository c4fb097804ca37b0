//! Adaptive sampling: more samples for tiles where they lower the relative error most.
//!
//! A pilot of a few replicates, each of a seed of its own, tells each tile's error and what its samples cost; its samples
//! are then thrown away. So the number of a pixel's samples is chosen without a look at them, and the estimate is as
//! unbiased as with equal numbers (two-stage sampling; that a pilot which is kept would bias the mean: Kirk & Arvo 1991,
//! "Unbiased sampling techniques for image synthesis"). Replicates see what even points err by, which s²/n does not.
//!
//! The sum of vᵢ/nᵢ is least for a given sum of cᵢ nᵢ where nᵢ goes with √(vᵢ/cᵢ) (Neyman 1934). What the pilot says is
//! believed as far as its two halves agree on it, the reliability of a test in halves (Spearman 1910, Brown 1910); the rest
//! of the samples is spread evenly, a fifth at least, as a pilot may have missed what is rare.

use super::budget::{Budget, MAX_SAMPLES};
use super::pass::Pass;
use super::pilot::{Pilot, REPLICATES};
use super::splats::SplatSums;
use crate::film::{Film, Rect};
use crate::kernel::Counters;
use crate::process::seconds_since_process_start;
use crate::report::fit::{CONFIDENCE, student_quantile};
use rayon::prelude::*;
use std::fmt;
use std::time::Instant;

/// The pilot takes at most one in so many samples, or seconds that are left …
const PILOT_SHARE: u64 = 8;
/// … but one in so many of few samples, as long as a replicate has no more than these: one or two in a replicate overlook
/// edges, and the tile that seemed quiet then has too few.
const PILOT_SHARE_OF_FEW: u64 = 4;
const FEW_SAMPLES: u64 = 4;
/// Samples of a replicate: no more than this, however large the budget …
const MOST_SAMPLES: u64 = 64;
/// … and where the budget is in seconds, these, or one if they would last too long.
const TIMED_SAMPLES: u64 = 4;
/// Samples whose light paths are traced before the pilot.
const SPLATS_FIRST: u64 = 16;
/// Weight of an even share beside the pilot's, at least.
const EVEN_SHARE: f64 = 0.2;
/// Numbers of samples go from 2^LEAST to 2^MOST times the average: powers of two, at which Sobol' points are most even.
const LEAST: i32 = -3;
const MOST: i32 = 4;
/// Side of the tiles whose numbers of samples differ, in pixels. Smaller ones follow edges closer, and keep fewer lanes busy.
pub fn adaptive_tile(width: u32, height: u32) -> u32 {
    if width.max(height) <= 512 { 4 } else { 8 }
}

/// How samples were divided, and what shows whether that biased them.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct AdaptiveReport {
    /// Samples a pixel of the pilot; they are not in the image.
    pub pilot_samples: u64,
    /// Seconds it took.
    pub pilot_seconds: f64,
    /// Fewest samples of a pixel.
    pub least: u64,
    /// Most.
    pub most: u64,
    /// Their mean over pixels.
    pub mean: f64,
    /// Mean of the image over the pilot's, less 1, both without what light paths bring: about 0 where dividing the samples added
    /// no bias.
    pub bias: f64,
    /// Half the width of a 95 % interval around it.
    pub bias_half_width: f64,
}

impl fmt::Display for AdaptiveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "adaptive: {} to {} samples a pixel, {:.1} on average, after a pilot of {} ({:.3} s, thrown away); bias as measured: {:+.2} ± {:.2} % of the pilot's mean",
            self.least,
            self.most,
            self.mean,
            self.pilot_samples,
            self.pilot_seconds,
            100.0 * self.bias,
            100.0 * self.bias_half_width
        )
    }
}

/// How many samples each tile gets, relative to the average.
pub(super) struct Rates {
    /// Tile by tile: the factor is 2 to this.
    exponents: Vec<i32>,
    /// What the pilot took and found.
    pub samples: u64,
    pub seconds: f64,
    /// Of all pixels.
    pub seconds_per_sample: f64,
    mean: f64,
    variance: f64,
    /// Of the variance.
    dof: u32,
}

impl Rates {
    /// Samples that a tile of average rate may have.
    pub const MOST_SAMPLES: u64 = MAX_SAMPLES >> MOST;

    /// Fewest samples of the average tile at which every tile has one.
    pub const FEWEST_SAMPLES: u64 = 1 << -LEAST;

    /// By a pilot that takes a quarter of a small budget at most, of a large one an eighth; `None` if that is too little for one, or the user
    /// interrupts. Its rays are added to `counters`. In the current thread pool.
    ///
    /// Light paths of the first samples come before it, to show how bright their light is. They are kept: pixels are given what
    /// they bring whatever their samples.
    pub fn find(
        pass: &Pass,
        film: &Film,
        budget: &Budget,
        mut splats: Option<&mut SplatSums>,
        counters: &mut Counters,
    ) -> Option<Self> {
        let start = Instant::now();
        let left = budget.seconds.map(|limit| (limit - seconds_since_process_start()) / PILOT_SHARE as f64);
        if left.is_some_and(|left| left <= 0.0) {
            return None;
        }
        let count = match budget.samples {
            Some(samples) => replicate_samples(samples)?,
            None => TIMED_SAMPLES,
        };
        if let (Some(light), Some(splats)) = (pass.light, splats.as_deref_mut()) {
            splats.trace_to(pass.world, light, SPLATS_FIRST.min(count), counters);
        }
        let splats = splats.as_deref();
        let mut pilot = Pilot::run(pass, film, if left.is_some() { 1 } else { count }, splats, counters)?;
        if let Some(left) = left {
            let left = left - start.elapsed().as_secs_f64();
            if left < 0.0 {
                return None;
            }
            if pilot.seconds * count as f64 <= left {
                pilot = Pilot::run(pass, film, count, splats, counters)?;
            }
        }
        Some(Self::of(&pilot, film, start.elapsed().as_secs_f64()))
    }

    /// By what a pilot says; it and what was tried before it took `seconds`.
    fn of(pilot: &Pilot, film: &Film, seconds: f64) -> Self {
        let rects: Vec<Rect> = film.tiles().iter().map(|tile| tile.rect()).collect();
        let pixels: f64 = rects.iter().map(|rect| rect.pixels() as f64).sum();
        let found: Vec<[f64; 3]> = rects.iter().map(|&rect| pilot.weights(rect)).collect();
        let sum: f64 = found.iter().zip(&rects).map(|([weight, ..], rect)| weight * rect.pixels() as f64).sum();
        let mean = if sum > 0.0 { sum / pixels } else { 1.0 };
        let even = (1.0 - reliability(&found)).max(EVEN_SHARE);
        let weights: Vec<f64> = found.iter().map(|[weight, ..]| even * mean + (1.0 - even) * weight).collect();
        let (mean, variance, dof) = pilot.mean();
        Rates {
            exponents: exponents(&weights, &rects),
            samples: pilot.samples,
            seconds,
            seconds_per_sample: pilot.seconds / pilot.samples as f64,
            mean,
            variance,
            dof,
        }
    }

    /// One past the last sample of a tile where the average tile's is `end`.
    pub fn end(&self, tile: usize, end: u64) -> u64 {
        let exponent = self.exponents[tile];
        if exponent < 0 { end >> -exponent } else { end << exponent }
    }

    /// Of the finished film.
    pub fn report(&self, film: &Film) -> AdaptiveReport {
        let mean = mean_of_film(film);
        // Of the pilot, and of the film as if its samples were the pilot's: even points, and dividing them, make it less.
        let variance = self.variance * (1.0 + self.samples as f64 / film.mean_samples());
        // Nothing to compare where the image is black.
        let scale = if self.mean == 0.0 { 0.0 } else { 1.0 / self.mean };
        AdaptiveReport {
            pilot_samples: self.samples,
            pilot_seconds: self.seconds,
            least: film.samples(),
            most: film.tiles().iter().map(|tile| tile.samples()).max().unwrap_or(0),
            mean: film.mean_samples(),
            bias: (mean - self.mean) * scale,
            bias_half_width: student_quantile(self.dof, CONFIDENCE) * variance.sqrt() * scale.abs(),
        }
    }
}

/// Samples of each replicate for a budget: a power of two.
fn replicate_samples(budget: u64) -> Option<u64> {
    let at_share = |share: u64| budget / (share * u64::from(REPLICATES));
    let most = at_share(PILOT_SHARE).max(at_share(PILOT_SHARE_OF_FEW).min(FEW_SAMPLES)).min(MOST_SAMPLES);
    (most > 0).then(|| 1 << most.ilog2())
}

/// Over pixels and channels.
fn mean_of_film(film: &Film) -> f64 {
    let row = |y| (0..film.width()).map(|x| film.mean(x, y).iter().sum::<f64>()).sum::<f64>();
    let rows: Vec<f64> = (0..film.height()).into_par_iter().map(row).collect();
    let values = (3 * film.width() as u64 * film.height() as u64).max(1) as f64;
    rows.iter().sum::<f64>() / values
}

/// Share of the weights' variance that is theirs and not the pilot's: 2r/(1 + r), r the correlation between the weights
/// that each half of the replicates gives; 0 if there is none.
fn reliability(weights: &[[f64; 3]]) -> f64 {
    let n = weights.len().max(1) as f64;
    let mean = |k: usize| weights.iter().map(|w| w[k]).sum::<f64>() / n;
    let [first, second] = [mean(1), mean(2)];
    let product = |f: fn(f64, f64) -> f64| weights.iter().map(|w| f(w[1] - first, w[2] - second)).sum::<f64>();
    let scale = (product(|a, _| a * a) * product(|_, b| b * b)).sqrt();
    let correlation = if scale > 0.0 { (product(|a, b| a * b) / scale).max(0.0) } else { 0.0 };
    2.0 * correlation / (1.0 + correlation)
}

/// Powers of two nearest to the weights times one factor: the largest at which the mean over pixels is at most 1.
fn exponents(weights: &[f64], rects: &[Rect]) -> Vec<i32> {
    let rounded = |factor: f64| -> Vec<i32> { weights.iter().map(|weight| exponent(weight * factor)).collect() };
    let pixels: f64 = rects.iter().map(|rect| rect.pixels() as f64).sum();
    let fits = |factor: f64| {
        let samples =
            rounded(factor).into_iter().zip(rects).map(|(e, rect)| f64::from(e).exp2() * rect.pixels() as f64);
        samples.sum::<f64>() <= pixels
    };
    let smallest = weights.iter().copied().fold(f64::INFINITY, f64::min).max(f64::MIN_POSITIVE);
    // With 0 all tiles have the least, which fits; with the other all have the most, which does not.
    let (mut low, mut high) = (0.0, f64::from(MOST + 1).exp2() / smallest);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        *(if fits(middle) { &mut low } else { &mut high }) = middle;
    }
    rounded(low)
}

/// The k of LEAST … MOST whose 2ᵏ is nearest by ratio. By squares: a logarithm may round either way.
fn exponent(x: f64) -> i32 {
    (LEAST + 1..=MOST).rev().find(|&k| x * x >= f64::from(2 * k - 1).exp2()).unwrap_or(LEAST)
}
