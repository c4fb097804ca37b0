//! Adaptive sampling: more samples for tiles where they lower the relative error most.
//!
//! The first samples of every pixel, the pilot, tell each tile's error and what its samples cost. A tile's number of samples is
//! chosen by what the pilot found in the four tiles next to it, and by nothing that it found in the tile. Pixels of different
//! tiles have random numbers of their own ([`World::with_tiles_apart`]), so whatever the number, the tile's samples are expected to
//! be what they are among equal numbers: none of them has to be thrown away. (A tile that decides on itself keeps a pilot that missed the light: Kirk & Arvo
//! 1991, "Unbiased sampling techniques for image synthesis".) What is said of all tiles, the factor that makes the numbers add up
//! and how far the pilot is believed, is said of the squares of a chessboard by what was found on those of the other colour.
//!
//! The sum of vᵢ/nᵢ is least for a given sum of cᵢ nᵢ where nᵢ goes with √(vᵢ/cᵢ) (Neyman 1934). v is the variance between
//! groups of the pilot's samples, which sees what even points err by, as s²/n does not. It is believed as far as its two halves
//! agree on it, the reliability of a test in halves (Spearman 1910, Brown 1910); the rest of the samples is spread evenly.

use super::budget::{Budget, MAX_SAMPLES};
use super::pass::Pass;
use super::pilot::{Findings, GROUPS, Pilot};
use super::splats::SplatSums;
use crate::film::Film;
use crate::kernel::{Counters, World};
use crate::process::seconds_since_process_start;
use crate::student::{CONFIDENCE, student_quantile};
use rayon::prelude::*;
use std::fmt;
use std::time::Instant;

/// The pilot takes at most one in so many samples, but one a group: with fewer it overlooks edges, and the more of them are even,
/// the fewer are left to be divided.
const PILOT_SHARE: u64 = 4;
/// Of the seconds that are left: as it takes four times as many samples as before or stops, between an eighth and a half.
const PILOT_TIME_SHARE: f64 = 0.5;
/// Samples of a group: no more than this, however large the budget …
const MOST_SAMPLES: u64 = 64;
/// … and where it is an error, which even few samples may reach, these.
const UNTOLD_SAMPLES: u64 = 4;
/// Samples whose light paths are traced before the pilot.
const SPLATS_FIRST: u64 = 16;
/// Numbers of samples go from 2^LEAST to 2^MOST times the average: powers of two, at which Sobol' points are most even.
const LEAST: i32 = -3;
const MOST: i32 = 4;
/// Side of the tiles whose numbers of samples differ, in pixels. Smaller ones follow edges closer, and are closer to those that
/// decide on them; but where paths bounce they keep fewer lanes busy.
pub fn adaptive_tile(world: &World) -> u32 {
    let side = if bounces(world) { 4 } else { 2 };
    if world.film.width.max(world.film.height) <= 512 { side } else { 2 * side }
}

/// Is there light that comes by way of other surfaces?
fn bounces(world: &World) -> bool {
    world.max_bounces > 1.0
}

/// How samples were divided, and what shows whether that biased them.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct AdaptiveReport {
    /// Samples a pixel of the pilot; they are in the image.
    pub pilot_samples: u64,
    /// Seconds it took.
    pub pilot_seconds: f64,
    /// Fewest samples of a pixel.
    pub least: u64,
    /// Most.
    pub most: u64,
    /// Their mean over pixels.
    pub mean: f64,
    /// Mean of the image over the pilot's, less 1, both without what light paths bring: about 0 where dividing the samples beyond
    /// the pilot's added no bias.
    pub bias: f64,
    /// Half the width of a 95 % interval around it: that of the pilot's mean. The image has the pilot in it and so is no further from it,
    /// but for Sobol' points that are even together and not apart.
    pub bias_half_width: f64,
}

impl fmt::Display for AdaptiveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "adaptive: {} to {} samples a pixel, {:.1} on average, the first {} as a pilot ({:.3} s); bias as measured: {:+.2} ± {:.2} % of the pilot's mean",
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
    samples: u64,
    seconds: f64,
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

    /// By a pilot on an empty film, of a quarter of the samples or a sample a group, or half the time; `None` if that is too
    /// little for one, or the user interrupts: the film is empty then, too. Its rays are added to `counters`. In the current thread pool.
    ///
    /// Light paths of the first samples come before it, to show how bright their light is. They are kept: pixels are given what
    /// they bring whatever their samples.
    pub fn find(
        pass: &Pass,
        film: &mut Film,
        budget: &Budget,
        mut splats: Option<&mut SplatSums>,
        counters: &mut Counters,
    ) -> Option<Self> {
        let start = Instant::now();
        let left = budget.seconds.map(|limit| (limit - seconds_since_process_start()) * PILOT_TIME_SHARE);
        if left.is_some_and(|left| left <= 0.0) {
            return None;
        }
        let count = match (budget.samples, budget.error) {
            (Some(samples), _) => group_samples(samples)?,
            (None, None) => MOST_SAMPLES,
            (None, Some(_)) => UNTOLD_SAMPLES,
        };
        if let (Some(light), Some(splats)) = (pass.light, splats.as_deref_mut()) {
            splats.trace_to(pass.world, light, SPLATS_FIRST.min(count), counters);
        }
        let pilot = run(pass, film, count, left.map(|left| (start, left)), splats.as_deref(), counters);
        if pilot.is_none() {
            *film = Film::new(film.width(), film.height(), film.tile_side(), film.channels(), 0);
        }
        let bounces = bounces(pass.world);
        Some(Self::of(&pilot?, film, bounces, budget.samples, start.elapsed().as_secs_f64()))
    }

    /// By what a pilot says, which took `seconds`, for so many samples a pixel on average, its own among them, or any number
    /// beside its own.
    fn of(pilot: &Pilot, film: &Film, bounces: bool, average: Option<u64>, seconds: f64) -> Self {
        let tiles: Vec<f64> = film.tiles().iter().map(|tile| tile.rect().pixels() as f64).collect();
        let across = film.width().div_ceil(film.tile_side()) as usize;
        let least = average.map_or(0.0, |average| pilot.samples as f64 / average as f64);
        let found = beside(&pilot.tiles, across, bounces);
        let mut exponents = vec![0; tiles.len()];
        for colour in 0..2 {
            let own: Vec<usize> = (0..tiles.len()).filter(|k| (k / across + k % across) % 2 == colour).collect();
            let pixels: Vec<f64> = own.iter().map(|&k| tiles[k]).collect();
            let found: Vec<[f64; 3]> = own.iter().map(|&k| found[k]).collect();
            for (k, exponent) in own.into_iter().zip(exponents_of(&weights(&found, &pixels), &pixels, least)) {
                exponents[k] = exponent;
            }
        }
        let (mean, variance, dof) = pilot.mean(3.0 * tiles.iter().sum::<f64>().max(1.0));
        let (samples, seconds_per_sample) = (pilot.samples, pilot.seconds_per_sample);
        Rates { exponents, samples, seconds, seconds_per_sample, mean, variance, dof }
    }

    /// One past the last sample of a tile where the average tile's is `end`; it may have more.
    pub fn end(&self, tile: usize, end: u64) -> u64 {
        let exponent = self.exponents[tile];
        if exponent < 0 { end >> -exponent } else { end << exponent }
    }

    /// Of the finished film.
    pub fn report(&self, film: &Film) -> AdaptiveReport {
        let mean = mean_of_film(film);
        // Nothing to compare where the image is black.
        let scale = if self.mean == 0.0 { 0.0 } else { 1.0 / self.mean };
        AdaptiveReport {
            pilot_samples: self.samples,
            pilot_seconds: self.seconds,
            least: film.samples(),
            most: film.tiles().iter().map(|tile| tile.samples()).max().unwrap_or(0),
            mean: film.mean_samples(),
            bias: (mean - self.mean) * scale,
            bias_half_width: student_quantile(self.dof, CONFIDENCE) * self.variance.sqrt() * scale.abs(),
        }
    }
}

/// A pilot of `count` samples in each group; where time is limited to so many seconds from a start on, of one first, then of four
/// times as many again and again, as long as those will take no longer.
fn run(
    pass: &Pass,
    film: &mut Film,
    count: u64,
    time: Option<(Instant, f64)>,
    splats: Option<&SplatSums>,
    counters: &mut Counters,
) -> Option<Pilot> {
    let Some((start, limit)) = time else { return Pilot::run(pass, film, count, splats, counters) };
    let mut pilot = Pilot::run(pass, film, 1, splats, counters)?;
    // All samples so far become the first group.
    while pilot.samples <= count {
        let more = (u64::from(GROUPS) - 1) * pilot.samples;
        if start.elapsed().as_secs_f64() + more as f64 * pilot.seconds_per_sample > limit {
            break;
        }
        pilot = Pilot::run(pass, film, pilot.samples, splats, counters)?;
    }
    Some(pilot)
}

/// Samples of each group for a budget: a power of two; `None` where a pilot would leave nothing to be divided.
fn group_samples(budget: u64) -> Option<u64> {
    let most = (budget / (PILOT_SHARE * u64::from(GROUPS))).clamp(1, MOST_SAMPLES);
    (budget > u64::from(GROUPS)).then(|| 1 << most.ilog2())
}

/// √(error of a pixel / rays of a sample), of the four tiles next to each; three of it: by all groups of the pilot, and by each
/// half of them. Rows have `across` tiles. Where there is but one tile nothing is known.
///
/// The root is of the mean of the four where nothing bounces; where it does, rare paths make some errors large by chance, and a mean of
/// roots follows those less.
fn beside(tiles: &[Findings], across: usize, bounces: bool) -> Vec<[f64; 3]> {
    let [inner, outer]: [fn(f64) -> f64; 2] = if bounces { [f64::sqrt, |x| x] } else { [|x| x, f64::sqrt] };
    let of_tile = |k: usize| {
        let (left, right) =
            ((!k.is_multiple_of(across)).then(|| k - 1), (!(k + 1).is_multiple_of(across)).then_some(k + 1));
        let (mut sum, mut count) = ([0.0; 3], 0.0f64);
        for tile in [left, right, k.checked_sub(across), Some(k + across)].into_iter().flatten() {
            let Some(tile) = tiles.get(tile) else { continue };
            sum = std::array::from_fn(|k| sum[k] + inner(tile.error[k] / tile.rays));
            count += 1.0;
        }
        sum.map(|sum| outer(sum / count.max(1.0)))
    };
    (0..tiles.len()).into_par_iter().map(of_tile).collect()
}

/// What numbers of samples should go with, of tiles of so many pixels.
fn weights(found: &[[f64; 3]], pixels: &[f64]) -> Vec<f64> {
    let sum: f64 = found.iter().zip(pixels).map(|([weight, ..], pixels)| weight * pixels).sum();
    let mean = if sum > 0.0 { sum / pixels.iter().sum::<f64>() } else { 1.0 };
    let even = 1.0 - reliability(found);
    found.iter().map(|[weight, ..]| even * mean + (1.0 - even) * weight).collect()
}

/// Over pixels and channels.
fn mean_of_film(film: &Film) -> f64 {
    let row = |y| (0..film.width()).map(|x| film.mean(x, y).iter().sum::<f64>()).sum::<f64>();
    let rows: Vec<f64> = (0..film.height()).into_par_iter().map(row).collect();
    let values = (3 * film.width() as u64 * film.height() as u64).max(1) as f64;
    rows.iter().sum::<f64>() / values
}

/// Share of the weights' variance that is theirs and not the pilot's: 2r/(1 + r), r the correlation between the weights
/// that each half of the groups gives; 0 if there is none.
fn reliability(weights: &[[f64; 3]]) -> f64 {
    let n = weights.len().max(1) as f64;
    let mean = |k: usize| weights.iter().map(|w| w[k]).sum::<f64>() / n;
    let [first, second] = [mean(1), mean(2)];
    let product = |f: fn(f64, f64) -> f64| weights.iter().map(|w| f(w[1] - first, w[2] - second)).sum::<f64>();
    let scale = (product(|a, _| a * a) * product(|_, b| b * b)).sqrt();
    let correlation = if scale > 0.0 { (product(|a, b| a * b) / scale).max(0.0) } else { 0.0 };
    2.0 * correlation / (1.0 + correlation)
}

/// Powers of two nearest to the weights times one factor: the largest at which the mean over pixels is at most 1, where no tile
/// has less than `least`.
fn exponents_of(weights: &[f64], pixels: &[f64], least: f64) -> Vec<i32> {
    let rounded = |factor: f64| -> Vec<i32> { weights.iter().map(|weight| exponent(weight * factor)).collect() };
    let all: f64 = pixels.iter().sum();
    let fits = |factor: f64| {
        let samples =
            rounded(factor).into_iter().zip(pixels).map(|(e, pixels)| f64::from(e).exp2().max(least) * pixels);
        samples.sum::<f64>() <= all
    };
    let smallest = weights.iter().copied().filter(|&weight| weight > 0.0).fold(f64::INFINITY, f64::min);
    // With 0 all tiles have the least, which fits; with the other all that weigh anything have the most.
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
