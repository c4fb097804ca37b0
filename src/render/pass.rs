//! A round over the film: every tile's next samples, in the current thread pool.

use super::JobKernel;
use super::adaptive::Rates;
use super::interrupt;
use super::splats::{SplatSums, Splats};
use crate::film::{AovSample, Rect, TileFilm};
use crate::kernel::{Counters, Job, LightKernel, SampleBuffer, World};
use rayon::prelude::*;
use std::cell::RefCell;

/// Samples a worker renders before it hands them to the film: their slots (12 bytes each) stay in the L2 cache.
const JOB_SLOTS: u32 = 16_384;

/// Where paths are shared a slot has up to 356 bytes: three colours, and rows of 64 for two vertices, the first one's scattering and
/// two lobes. On env 16,384 took 1.09 times the seconds.
const SHARING_JOB_SLOTS: u32 = 4096;

/// Rounds over the film.
pub(super) struct Pass<'a> {
    pub world: &'a World,
    pub kernel: JobKernel<'a>,
    pub light: Option<LightKernel>,
    pub aovs: bool,
}

thread_local! {
    /// A worker's sample slots, kept between jobs.
    static SLOTS: RefCell<SampleBuffer> = RefCell::new(SampleBuffer::default());
}

impl Pass<'_> {
    /// Samples to `end` of a tile of average rate, others by their rates and none that they have, and as many of the light paths, which reach all tiles alike.
    pub fn run_at_rates(
        &self,
        tiles: &mut [TileFilm],
        rates: &Rates,
        splats: Option<&mut SplatSums>,
        end: u64,
    ) -> Counters {
        let mut counters = Counters::default();
        if let (Some(light), Some(splats)) = (self.light, splats) {
            splats.trace_to(self.world, light, end, &mut counters);
        }
        let end = |tile: usize| rates.end(tile, end);
        counters.add(&total(tiles.par_iter_mut().enumerate().map(|(k, tile)| self.render_tile(tile, 0, end(k), None))));
        counters
    }

    /// Samples `first … end` of all tiles.
    pub fn run(&self, tiles: &mut [TileFilm], first: u64, end: u64) -> Counters {
        let Some(light) = self.light else { return self.render_tiles(tiles, first, end, None) };
        let mut counters = Counters::default();
        let at_once = Splats::samples_at_once(self.world);
        for from in (first..end).step_by(at_once as usize) {
            let to = end.min(from + at_once);
            let Some(splats) = Splats::trace(self.world, light, from, to - from, &mut counters) else { break };
            counters.add(&self.render_tiles(tiles, from, to, Some(&splats)));
        }
        counters
    }

    fn render_tiles(&self, tiles: &mut [TileFilm], first: u64, end: u64, splats: Option<&Splats>) -> Counters {
        total(tiles.par_iter_mut().map(|tile| self.render_tile(tile, first, end, splats)))
    }

    /// Renders samples of one tile, as many at a time as the cache holds; none once the user interrupts.
    fn render_tile(&self, tile: &mut TileFilm, first: u64, end: u64, splats: Option<&Splats>) -> Counters {
        let rect = tile.rect();
        let job_slots = if self.world.plan.path_reuse { SHARING_JOB_SLOTS } else { JOB_SLOTS };
        let at_once = (job_slots / (rect.width * rect.height)).max(1) as u64;
        let mut counters = Counters::default();
        // An interrupted pass left some tiles ahead of others.
        let mut first = first.max(tile.next_sample());
        while first < end && !interrupt::asked() {
            let samples = at_once.min(end - first);
            self.render_job(rect, [first, first + samples], &mut counters, |slots| {
                if let Some(splats) = splats {
                    splats.add_to(rect, first, samples as usize, &mut slots.rgb);
                }
                let aovs: &[AovSample] = slots.features.as_deref().unwrap_or(&[]);
                tile.add_samples(first, samples as usize, &slots.rgb, aovs);
            });
            first += samples;
        }
        counters
    }

    /// Renders samples `first … end` of a tile and hands over what they found.
    pub fn render_job<T>(
        &self,
        rect: Rect,
        [first, end]: [u64; 2],
        counters: &mut Counters,
        then: impl FnOnce(&mut SampleBuffer) -> T,
    ) -> T {
        let Rect { x, y, width, height } = rect;
        let job = Job { x, y, width, height, first_sample: first as u32, samples: (end - first) as u32 };
        SLOTS.with_borrow_mut(|slots| {
            slots.reset(job.slots(), self.aovs);
            (self.kernel)(self.world, &job, slots, counters);
            then(slots)
        })
    }
}

fn total(of_tiles: impl ParallelIterator<Item = Counters>) -> Counters {
    of_tiles.reduce(Counters::default, |mut a, b| {
        a.add(&b);
        a
    })
}
