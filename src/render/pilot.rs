//! The pilot of [adaptive sampling](super::adaptive): the first samples of every pixel, and what they say of each tile.

use super::interrupt;
use super::pass::Pass;
use super::splats::SplatSums;
use crate::film::{AovSample, Film, TileFilm};
use crate::kernel::Counters;
use rayon::prelude::*;
use std::time::Instant;

/// Groups of samples, one after the other, that are set against each other. Of a power of two each, so that the points of
/// each are even, and groups differ by what even points err by.
pub const GROUPS: u32 = 4;

/// Beyond, Student's distribution is the normal one.
const MOST_DOF: f64 = 1e4;

/// What the first samples found, tile by tile.
pub struct Pilot {
    pub tiles: Vec<Findings>,
    /// Samples a pixel.
    pub samples: u64,
    /// Of all pixels.
    pub seconds_per_sample: f64,
}

/// What they found of one tile.
#[derive(Clone, Copy, Default)]
pub struct Findings {
    /// Mean over its pixels, summed over channels: variance of a group's mean over mean² + 0.01, by all groups, by the first
    /// half of them and by the second.
    pub error: [f64; 3],
    /// Of a sample.
    pub rays: f64,
    /// Sum over pixels and channels of the mean, and its variance.
    mean: f64,
    variance: f64,
}

impl Pilot {
    /// With so many samples in each group, in the current thread pool, on a film that has none or those of the first group; `None`
    /// once the user interrupts. Light paths are not in it, but count where errors are set against brightness.
    pub fn run(
        pass: &Pass,
        film: &mut Film,
        samples: u64,
        splats: Option<&SplatSums>,
        counters: &mut Counters,
    ) -> Option<Self> {
        let (start, first) = (Instant::now(), film.samples());
        let end = samples * u64::from(GROUPS);
        let tiles = film.tiles_mut().par_iter_mut();
        let (tiles, of_tiles): (Vec<_>, Vec<_>) = tiles.map(|tile| explore(pass, tile, first, end, splats)).unzip();
        of_tiles.iter().for_each(|of_tile| counters.add(of_tile));
        let seconds_per_sample = start.elapsed().as_secs_f64() / (end - first) as f64;
        (!interrupt::asked()).then_some(Pilot { tiles, samples: end, seconds_per_sample })
    }

    /// Mean over so many values, its variance, and the degrees of freedom of that (Satterthwaite 1946): few where few tiles make
    /// up most of it.
    pub fn mean(&self, values: f64) -> (f64, f64, u32) {
        let sum = |of: fn(&Findings) -> f64| self.tiles.iter().map(of).sum::<f64>();
        let (variance, squares) = (sum(|tile| tile.variance), sum(|tile| tile.variance * tile.variance));
        let of_a_tile = f64::from(GROUPS - 1);
        let dof = if squares > 0.0 { variance * variance / squares * of_a_tile } else { of_a_tile };
        (sum(|tile| tile.mean) / values, variance / (values * values), dof.clamp(1.0, MOST_DOF) as u32)
    }
}

/// Gives a tile its samples `first … end`, unless the user interrupts. It is rendered alone, so that its rays say nothing of other
/// tiles.
fn explore(pass: &Pass, tile: &mut TileFilm, first: u64, end: u64, splats: Option<&SplatSums>) -> (Findings, Counters) {
    let mut counters = Counters::default();
    if interrupt::asked() {
        return (Findings::default(), counters);
    }
    let samples = (end - first) as usize;
    let mut found = pass.render_job(tile.rect(), [first, end], &mut counters, |slots| {
        let found = Findings::of(tile, &slots.rgb, samples, (end / u64::from(GROUPS)) as usize, splats);
        let aovs: &[AovSample] = slots.features.as_deref().unwrap_or(&[]);
        tile.add_samples(first, samples, &slots.rgb, aovs);
        found
    });
    found.rays = counters.rays().max(1) as f64 / counters.camera_rays.max(1) as f64;
    (found, counters)
}

impl Findings {
    /// Of a tile that has no samples, or those of the first group, and is about to be given others.
    fn of(tile: &TileFilm, rgb: &[[f32; 3]], samples: usize, group: usize, splats: Option<&SplatSums>) -> Self {
        let rect = tile.rect();
        let mut found = Findings::default();
        let mut sums = [0.0; GROUPS as usize];
        let pixels = (rect.y..rect.y + rect.height).flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (x, y)));
        for ((x, y), slots) in pixels.zip(rgb.chunks_exact(samples)) {
            let mut means = [[0.0; 3]; GROUPS as usize];
            means[0] = tile.pixel(x, y).mean();
            let missing = slots.len() / group;
            for (to, slots) in means[GROUPS as usize - missing..].iter_mut().zip(slots.chunks_exact(group)) {
                *to = mean(slots);
            }
            found.add(&means, splats.map_or([0.0; 3], |splats| splats.mean(x, y)));
            for (sum, mean) in sums.iter_mut().zip(&means) {
                *sum += mean.iter().sum::<f64>();
            }
        }
        found.error = found.error.map(|error| error / rect.pixels() as f64);
        // Of the sum: where pixels share paths, and among channels, errors may be one.
        let [mean, variance] = mean_and_variance(&sums);
        (found.mean, found.variance) = (mean, variance / f64::from(GROUPS));
        found
    }

    /// The groups' means of a pixel, to which light paths add `splats`.
    fn add(&mut self, groups: &[[f64; 3]; GROUPS as usize], splats: [f64; 3]) {
        for (c, splat) in splats.into_iter().enumerate() {
            let values = groups.map(|mean| mean[c]);
            let (earlier, later) = values.split_at(values.len() / 2);
            let bright = mean_and_variance(&values)[0] + splat;
            for (error, part) in self.error.iter_mut().zip([&values[..], earlier, later]) {
                *error += mean_and_variance(part)[1] / (bright * bright + 0.01);
            }
        }
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
