//! What the light paths of some samples splat, summed pixel by pixel in the order of the paths: the same at any width, number
//! of threads and size of a job.

use super::interrupt;
use crate::film::{Discarded, DiscardedSample, Film, Rect};
use crate::kernel::{Counters, LightJob, LightKernel, Splat, World};
use rayon::prelude::*;

/// Light paths that a worker traces at once: their splats stay in its caches.
const JOB_PATHS: u32 = 4096;
/// Values of pixels and samples held at once, 12 bytes each, where a sample has no more.
const MOST_VALUES: u64 = 1 << 20;

/// Sums of splats: one image a sample.
pub struct Splats {
    first_sample: u64,
    width: usize,
    images: Vec<Vec<[f32; 3]>>,
}

impl Splats {
    /// How many samples to hold at once.
    pub fn samples_at_once(world: &World) -> u64 {
        (MOST_VALUES / pixels(world).max(1) as u64).max(1)
    }

    /// Traces all light paths of `samples` samples, in the current thread pool. `None` once the user interrupts.
    pub fn trace(
        world: &World,
        kernel: LightKernel,
        first_sample: u64,
        samples: u64,
        counters: &mut Counters,
    ) -> Option<Splats> {
        let count = world.light_paths?.count;
        let jobs_of = |sample: u64| {
            (0..count).step_by(JOB_PATHS as usize).map(move |first| LightJob {
                sample: sample as u32,
                first,
                count: JOB_PATHS.min(count - first),
            })
        };
        let jobs: Vec<LightJob> = (first_sample..first_sample + samples).flat_map(jobs_of).collect();
        let traced: Vec<(Vec<Splat>, Counters)> = jobs.par_iter().map(|job| one_job(world, kernel, job)).collect();
        if interrupt::asked() {
            return None;
        }
        traced.iter().for_each(|(_, of_job)| counters.add(of_job));
        let jobs_a_sample = count.div_ceil(JOB_PATHS) as usize;
        let images = traced.par_chunks(jobs_a_sample).map(|jobs| sum(jobs, pixels(world))).collect();
        Some(Splats { first_sample, width: world.film.width as usize, images })
    }

    /// Adds what belongs to samples `first_sample …` of a rectangle to their slots, `samples` a pixel.
    pub fn add_to(&self, rect: Rect, first_sample: u64, samples: usize, slots: &mut [[f32; 3]]) {
        let images = &self.images[(first_sample - self.first_sample) as usize..][..samples];
        let pixels = (rect.y..rect.y + rect.height).flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (x, y)));
        for (slots, (x, y)) in slots.chunks_exact_mut(samples).zip(pixels) {
            let pixel = y as usize * self.width + x as usize;
            for (slot, image) in slots.iter_mut().zip(images) {
                *slot = std::array::from_fn(|c| slot[c] + image[pixel][c]);
            }
        }
    }
}

/// What light paths add to pixels whose numbers of samples differ: an estimate of its own, by a number of samples of its own, with
/// its variance.
pub struct SplatSums {
    width: usize,
    samples: u64,
    /// Σx and Σx² of each pixel, by channel.
    sums: Vec<[[f64; 2]; 3]>,
    /// What was no number of them.
    discarded: Discarded,
}

impl SplatSums {
    /// Nothing yet.
    pub fn new(world: &World) -> Self {
        let sums = vec![[[0.0; 2]; 3]; pixels(world)];
        SplatSums { width: world.film.width as usize, samples: 0, sums, discarded: Discarded::default() }
    }

    /// Traces the light paths of samples up to `end`, or as far as the user does not interrupt.
    pub fn trace_to(&mut self, world: &World, kernel: LightKernel, end: u64, counters: &mut Counters) {
        while self.samples < end {
            let samples = Splats::samples_at_once(world).min(end - self.samples);
            let Some(splats) = Splats::trace(world, kernel, self.samples, samples, counters) else { return };
            let pixels = self.sums.par_iter_mut().enumerate();
            let dropped: Vec<(usize, usize)> = pixels
                .flat_map_iter(|(pixel, sums)| {
                    let images = splats.images.iter().enumerate();
                    images.filter_map(move |(k, image)| (!add(sums, image[pixel])).then_some((pixel, k)))
                })
                .collect();
            self.note(&dropped);
            self.samples += samples;
        }
    }

    /// Pixels and samples, of those last traced, that were no number.
    fn note(&mut self, dropped: &[(usize, usize)]) {
        for &(pixel, k) in dropped {
            let (x, y) = ((pixel % self.width) as u32, (pixel / self.width) as u32);
            self.discarded.record(DiscardedSample { x, y, sample: self.samples + k as u64 });
        }
    }

    /// Of a pixel.
    pub fn mean(&self, x: u32, y: u32) -> [f64; 3] {
        let n = self.samples.max(1) as f64;
        self.sums[y as usize * self.width + x as usize].map(|[sum, _]| sum / n)
    }

    /// A film with it added to the means of its pixels, its variance to theirs, and what it dropped to what that did.
    pub fn with(&self, film: &Film) -> Film {
        let (mut film, n) = (film.clone(), self.samples.max(1) as f64);
        film.tiles_mut().par_iter_mut().for_each(|tile| {
            tile.add_estimate(|x, y| {
                let sums = self.sums[y as usize * self.width + x as usize];
                sums.map(|[sum, squares]| [sum / n, (squares - sum * sum / n).max(0.0) / (n * (n - 1.0).max(1.0))])
            });
        });
        film.note_discarded(&self.discarded);
        film
    }
}

/// Another sample of a pixel, unless it is not finite: says whether it was, as on a film.
fn add(sums: &mut [[f64; 2]; 3], sample: [f32; 3]) -> bool {
    let finite = sample.iter().all(|value| value.is_finite());
    if finite {
        for ([sum, squares], value) in sums.iter_mut().zip(sample.map(f64::from)) {
            (*sum, *squares) = (*sum + value, *squares + value * value);
        }
    }
    finite
}

fn pixels(world: &World) -> usize {
    world.film.width as usize * world.film.height as usize
}

/// The splats of a job in the order of its paths; each path's come in its own.
fn one_job(world: &World, kernel: LightKernel, job: &LightJob) -> (Vec<Splat>, Counters) {
    let (mut splats, mut counters) = (Vec::new(), Counters::default());
    if !interrupt::asked() {
        kernel(world, job, &mut splats, &mut counters);
    }
    (by_path(&splats, job.count as usize), counters)
}

/// Sorted by path, those of a path left in order: by counting.
fn by_path(splats: &[Splat], paths: usize) -> Vec<Splat> {
    let Some(&any) = splats.first() else { return Vec::new() };
    let mut place = vec![0u32; paths + 1];
    splats.iter().for_each(|splat| place[splat.path as usize + 1] += 1);
    (0..paths).for_each(|path| place[path + 1] += place[path]);
    let mut sorted = vec![any; splats.len()];
    for splat in splats {
        let place = &mut place[splat.path as usize];
        sorted[*place as usize] = *splat;
        *place += 1;
    }
    sorted
}

fn sum(jobs: &[(Vec<Splat>, Counters)], pixels: usize) -> Vec<[f32; 3]> {
    let mut image = vec![[0.0f32; 3]; pixels];
    for splat in jobs.iter().flat_map(|(splats, _)| splats) {
        let value = &mut image[splat.pixel as usize];
        *value = std::array::from_fn(|c| value[c] + splat.rgb[c]);
    }
    image
}
