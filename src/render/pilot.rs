//! The pilot of [adaptive sampling](super::adaptive): replicates of few samples, and what they say of each tile.

use super::interrupt;
use super::pass::{Pass, SLOTS};
use super::splats::SplatSums;
use crate::film::{Film, Rect};
use crate::kernel::{Counters, Job, REUSE_SIDE};
use crate::sampling::child_key;
use rayon::prelude::*;
use std::time::Instant;

/// Independent renders that the pilot consists of.
pub const REPLICATES: u32 = 4;
/// Sets the pilot's seeds apart.
const PILOT_SEED: u32 = 0x4164_6170;
/// Tiles across a square of the pilot: as many paths at once as keep the lanes full.
const SQUARE: u32 = 4;

/// Beyond, Student's distribution is the normal one.
const MOST_DOF: f64 = 1e4;

/// What the replicates found of squares of tiles.
pub struct Pilot {
    squares: Vec<Square>,
    across: u32,
    side: u32,
    /// Samples a pixel, of all replicates.
    pub samples: u64,
    pub seconds: f64,
}

/// What they found of one.
struct Square {
    rect: Rect,
    /// Of each pixel, summed over channels: variance of a replicate's mean over mean² + 0.01, by all replicates, by the
    /// first half of them and by the second.
    error: Vec<[f64; 3]>,
    /// Sums over pixels and channels: of the mean of all replicates, and of its variance.
    mean: f64,
    variance: f64,
    /// Sum of the squares of what each block adds to the variance.
    squares: f64,
    counters: Counters,
}

impl Pilot {
    /// With so many samples in each replicate, in the current thread pool; `None` once the user interrupts. Light paths are not in
    /// it, but count where errors are set against brightness.
    pub fn run(
        pass: &Pass,
        film: &Film,
        samples: u64,
        splats: Option<&SplatSums>,
        counters: &mut Counters,
    ) -> Option<Self> {
        let start = Instant::now();
        let side = film.tile_side() * SQUARE;
        let (width, height) = (film.width(), film.height());
        let (across, down) = (width.div_ceil(side), height.div_ceil(side));
        let corners: Vec<_> = (0..down).flat_map(|j| (0..across).map(move |i| (i * side, j * side))).collect();
        let rects = corners.into_par_iter().map(|(x, y)| Rect {
            x,
            y,
            width: side.min(width - x),
            height: side.min(height - y),
        });
        let squares: Vec<_> = rects.map(|rect| Square::run(pass, rect, samples as u32, splats)).collect();
        squares.iter().for_each(|square| counters.add(&square.counters));
        let (samples, seconds) = (samples * u64::from(REPLICATES), start.elapsed().as_secs_f64());
        (interrupt::presses() == 0).then_some(Pilot { squares, across, side, samples, seconds })
    }

    /// √(error of a pixel / rays of a sample) of a tile: by all replicates, and by each half of them.
    pub fn weights(&self, tile: Rect) -> [f64; 3] {
        self.square(tile).weights(tile)
    }

    /// Mean over pixels and channels, its variance, and the degrees of freedom of that (Satterthwaite 1946): few where few blocks
    /// make up most of it.
    pub fn mean(&self) -> (f64, f64, u32) {
        let pixels: usize = self.squares.iter().map(|square| square.rect.pixels()).sum();
        let values = 3.0 * pixels.max(1) as f64;
        let sum = |of: fn(&Square) -> f64| self.squares.iter().map(of).sum::<f64>();
        let (variance, squares) = (sum(|square| square.variance), sum(|square| square.squares));
        let of_a_block = f64::from(REPLICATES - 1);
        let dof = if squares > 0.0 { variance * variance / squares * of_a_block } else { of_a_block };
        (sum(|square| square.mean) / values, variance / (values * values), dof.clamp(1.0, MOST_DOF) as u32)
    }

    /// The square of a tile.
    fn square(&self, tile: Rect) -> &Square {
        &self.squares[(tile.y / self.side * self.across + tile.x / self.side) as usize]
    }
}

impl Square {
    fn run(pass: &Pass, rect: Rect, samples: u32, splats: Option<&SplatSums>) -> Self {
        let mut means = vec![[[0.0; 3]; REPLICATES as usize]; rect.pixels()];
        let mut counters = Counters::default();
        for replicate in 0..REPLICATES {
            let seed = child_key(pass.world.seed, PILOT_SEED + replicate);
            let Rect { x, y, width, height } = rect;
            let job = Job { x, y, width, height, first_sample: 0, samples, seed };
            SLOTS.with_borrow_mut(|slots| {
                slots.reset(job.slots(), pass.aovs);
                if interrupt::presses() == 0 {
                    (pass.kernel)(pass.world, &job, slots, &mut counters);
                }
                for (pixel, slots) in means.iter_mut().zip(slots.rgb.chunks_exact(samples as usize)) {
                    pixel[replicate as usize] = mean(slots);
                }
            });
        }
        let mut square =
            Square { rect, error: Vec::with_capacity(means.len()), mean: 0.0, variance: 0.0, squares: 0.0, counters };
        let places = (rect.y..rect.y + rect.height).flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (x, y)));
        for ((x, y), replicates) in places.zip(&means) {
            square.add(replicates, splats.map_or([0.0; 3], |splats| splats.mean(x, y)));
        }
        square.add_blocks(&means);
        square
    }

    /// Adds the variance of the sum of each block of pixels that may share paths, whose errors may be one, as those of channels.
    fn add_blocks(&mut self, means: &[[[f64; 3]; REPLICATES as usize]]) {
        let side = REUSE_SIDE as usize;
        let (width, height) = (self.rect.width as usize, self.rect.height as usize);
        for (y, x) in (0..height).step_by(side).flat_map(|y| (0..width).step_by(side).map(move |x| (y, x))) {
            let mut sums = [0.0; REPLICATES as usize];
            for row in y..(y + side).min(height) {
                for replicates in &means[row * width + x..row * width + (x + side).min(width)] {
                    for (sum, mean) in sums.iter_mut().zip(replicates) {
                        *sum += mean.iter().sum::<f64>();
                    }
                }
            }
            let variance = mean_and_variance(&sums)[1] / f64::from(REPLICATES);
            self.variance += variance;
            self.squares += variance * variance;
        }
    }

    /// The next pixel, to whose mean light paths add `splats`.
    fn add(&mut self, replicates: &[[f64; 3]; REPLICATES as usize], splats: [f64; 3]) {
        let mut error = [0.0; 3];
        for c in 0..3 {
            let values = replicates.map(|replicate| replicate[c]);
            let (earlier, later) = values.split_at(values.len() / 2);
            let mean = mean_and_variance(&values)[0];
            let bright = mean + splats[c];
            for (error, part) in error.iter_mut().zip([&values[..], earlier, later]) {
                *error += mean_and_variance(part)[1] / (bright * bright + 0.01);
            }
            self.mean += mean;
        }
        self.error.push(error);
    }

    /// See [`Pilot::weights`]; of a tile in this square.
    fn weights(&self, tile: Rect) -> [f64; 3] {
        let mut error = [0.0; 3];
        for y in tile.y..tile.y + tile.height {
            let first = self.rect.index_of(tile.x, y);
            for pixel in &self.error[first..first + tile.width as usize] {
                error = std::array::from_fn(|k| error[k] + pixel[k]);
            }
        }
        let rays = self.counters.rays().max(1) as f64 / self.counters.camera_rays.max(1) as f64;
        error.map(|error| (error / tile.pixels() as f64 / rays).sqrt())
    }
}

/// The variance is that of a single value.
fn mean_and_variance(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)]
}

/// Of the finite ones: the others count as zero, as on a film.
fn mean(samples: &[[f32; 3]]) -> [f64; 3] {
    let finite = samples.iter().filter(|rgb| rgb.iter().all(|value| value.is_finite()));
    let sum = finite.fold([0.0; 3], |sum: [f64; 3], rgb| std::array::from_fn(|c| sum[c] + f64::from(rgb[c])));
    sum.map(|sum| sum / samples.len().max(1) as f64)
}
