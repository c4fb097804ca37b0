//! What goes on beside a render: its state and images are kept up to date, so that little is lost whatever happens.

use super::CliError;
use super::targets::{Facts, ImageArgs};
use crate::film::Film;
use crate::kernel::Counters;
use crate::render::state::Head;
use crate::render::{Outcome, State, StoppedBy, Watch};
use std::path::Path;
use std::time::{Duration, Instant};

/// Saving takes at most this share of the time, whatever was asked for.
const SAVING_SHARE: u32 = 20;
/// A guess at the speed of a state's way to the disk until one was written.
const STATE_BYTES_PER_SECOND: f64 = 400e6;

/// Keeps the files of a render.
pub struct Keeper<'a> {
    pub images: &'a ImageArgs,
    pub state: Option<&'a Path>,
    pub every: Duration,
    pub pool: &'a rayon::ThreadPool,
    /// As it stood when the render began; samples, rays and seconds are added.
    pub head: Head,
    last: Instant,
    cost: Duration,
}

impl<'a> Keeper<'a> {
    pub fn new(
        images: &'a ImageArgs,
        state: Option<&'a Path>,
        every: Duration,
        pool: &'a rayon::ThreadPool,
        head: Head,
    ) -> Self {
        Keeper { images, state, every, pool, head, last: Instant::now(), cost: Duration::ZERO }
    }

    /// Writes state and images of a finished render. A state that cannot be written does not keep the images from it.
    pub fn finish(&mut self, outcome: &Outcome) -> Result<(), CliError> {
        self.save(&outcome.film, &outcome.counters, outcome.render_seconds, outcome.stopped_by)
    }

    /// What all of the samples were stopped by, where `now` has stopped those of this run.
    pub fn stopped_by(&self, film: &Film, now: StoppedBy) -> StoppedBy {
        match self.head.samples {
            0 => now,
            // Nothing was added: they stand as they did.
            held if held == film.samples() => self.head.stopped_by,
            _ => now.after(self.head.stopped_by),
        }
    }

    fn save(&mut self, film: &Film, counters: &Counters, seconds: f64, stopped_by: StoppedBy) -> Result<(), CliError> {
        let mut head = self.head.clone();
        head.rays.add(counters);
        head.render_seconds += seconds;
        head.samples = film.samples();
        head.stopped_by = self.stopped_by(film, stopped_by);
        let saved = self.state.map_or(Ok(()), |path| State::save(&head, film, path));
        let facts = Facts {
            scene: head.scene,
            render_seconds: head.render_seconds,
            seed: head.origin.seed,
            sampler: head.origin.sampler,
            stopped_by: head.stopped_by,
            shares_points: head.origin.shares_points,
        };
        self.pool.install(|| self.images.write(film, &facts))?;
        Ok(saved?)
    }
}

impl Watch for Keeper<'_> {
    fn output_seconds(&mut self, film: &Film) -> Option<f64> {
        let images = self.pool.install(|| self.images.trial_seconds(film));
        let state = self.state.map_or(0.0, |_| 0.01 + film.encoded_bytes() as f64 / STATE_BYTES_PER_SECOND);
        Some(images + state)
    }

    fn pass_done(&mut self, film: &Film, counters: &Counters, seconds: f64) {
        if self.state.is_none() || self.last.elapsed() < self.every.max(self.cost * SAVING_SHARE) {
            return;
        }
        let start = Instant::now();
        // A full disk may have room again before the end; what was saved before is still there.
        if let Err(error) = self.save(film, counters, seconds, StoppedBy::Interrupt) {
            log::warn!("{error}; the render goes on");
        }
        self.last = Instant::now();
        self.cost = start.elapsed();
    }
}
