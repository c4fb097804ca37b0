//! What a render reports: the JSON file, and the lines a person reads at the end.

use super::adaptive::AdaptiveReport;
use super::{Options, Outcome, StoppedBy};
use crate::film::{Discarded, SampleShares};
use crate::kernel::{Counters, Setup, World};
use crate::plan::Plan;
use crate::process::{peak_memory_bytes, seconds_since_process_start};
use crate::sampling::SamplerKind;
use std::fmt;

/// Version of the JSON's form; raised when a field changes its meaning.
const FORMAT: u32 = 1;

/// The report of one render. Seconds are wall clock; rates are per second of `render_seconds` less `discarded_seconds`.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Summary {
    pub format: u32,
    pub version: &'static str,
    pub scene: String,
    pub plan: Plan,
    pub cpu_features: Vec<&'static str>,
    pub width: u32,
    pub height: u32,
    pub lanes: usize,
    pub threads: usize,
    pub tile: u32,
    pub seed: u64,
    pub sampler: SamplerKind,
    pub samples_per_pixel: u64,
    /// Where tiles have numbers of samples of their own; [`Summary::samples_per_pixel`] is then their mean.
    pub adaptive: Option<AdaptiveReport>,
    /// Of these, held at the start: from a state.
    pub resumed_samples: u64,
    pub stopped_by: StoppedBy,
    /// What the way it was stopped does to the estimate.
    pub claim: &'static str,
    /// What the estimator itself does to it; `None` where its samples are unbiased.
    pub note: Option<&'static str>,
    pub relative_error: Option<f64>,
    /// May it, and the variances, be relied on?
    pub sample_shares: Option<SampleShares>,
    pub relative_error_trusted: Option<bool>,
    /// Reading the scene and building what the kernel reads.
    pub setup_seconds: f64,
    pub load_seconds: f64,
    pub setup: Setup,
    /// From the first sample traced for any purpose to the finished film.
    pub render_seconds: f64,
    /// Of these, those of a pilot whose samples are counted nowhere.
    pub discarded_seconds: f64,
    pub output_seconds: f64,
    /// From exec to the written image.
    pub wall_seconds: f64,
    pub paths: u64,
    pub paths_per_second: f64,
    pub rays: Counters,
    pub rays_per_second: f64,
    /// Mean share of lanes alive when a packet is shaded.
    pub lane_utilisation: f64,
    pub discarded_samples: u64,
    /// (x, y, sample) of the first few.
    pub discarded_first: Vec<(u32, u32, u64)>,
    pub peak_memory_bytes: Option<u64>,
    /// See [`Integrator::options`](crate::scene::Integrator::options).
    #[serde(skip)]
    pub integrator_options: String,
}

/// Seconds spent around the render.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    pub load: f64,
    pub setup: f64,
    /// Rendering that is not in the film: a discarded pilot.
    pub pilot: f64,
}

impl Summary {
    /// Everything but the output's own time, which is not over yet: see [`Summary::finish`].
    pub fn new(name: &str, world: &World, options: &Options, threads: usize, outcome: &Outcome, times: Times) -> Self {
        let counters = outcome.counters;
        let render_seconds = outcome.render_seconds + times.pilot;
        let relative_error = outcome.film.relative_error();
        let sample_shares = relative_error.map(|error| outcome.film.sample_shares(error));
        let discarded: Discarded = outcome.film.discarded();
        let lanes = options.width.lanes();
        Summary {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            scene: name.to_string(),
            plan: world.plan.clone(),
            cpu_features: crate::cpu::compiled_features(),
            width: world.film.width,
            height: world.film.height,
            lanes,
            threads,
            tile: outcome.film.tile_side(),
            seed: world.seed,
            sampler: world.sampler,
            samples_per_pixel: outcome.samples_per_pixel(),
            adaptive: outcome.adaptive,
            resumed_samples: 0,
            stopped_by: outcome.stopped_by,
            claim: outcome.stopped_by.claim(),
            note: world.integrator.note(),
            relative_error,
            sample_shares,
            relative_error_trusted: sample_shares.map(|shares| shares.error_trusted()),
            setup_seconds: times.setup + times.load,
            load_seconds: times.load,
            setup: world.setup.clone(),
            render_seconds,
            discarded_seconds: times.pilot,
            output_seconds: 0.0,
            wall_seconds: 0.0,
            paths: counters.camera_rays,
            paths_per_second: counters.camera_rays as f64 / outcome.render_seconds.max(1e-9),
            rays: counters,
            rays_per_second: counters.rays() as f64 / outcome.render_seconds.max(1e-9),
            lane_utilisation: counters.active_lanes as f64 / (counters.packets.max(1) * lanes as u64) as f64,
            discarded_samples: discarded.count,
            discarded_first: discarded.first.iter().map(|d| (d.x, d.y, d.sample)).collect(),
            peak_memory_bytes: None,
            integrator_options: world.integrator.options(),
        }
    }

    /// Where samples of an earlier run are among them: what all were stopped by.
    pub fn resumed(&mut self, held: u64, stopped_by: StoppedBy) {
        (self.resumed_samples, self.stopped_by, self.claim) = (held, stopped_by, stopped_by.claim());
    }

    /// Closes the books once the image is written.
    pub fn finish(&mut self, output_seconds: f64) {
        self.output_seconds = output_seconds;
        self.wall_seconds = seconds_since_process_start();
        self.peak_memory_bytes = peak_memory_bytes();
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mega = |count: u64| count as f64 / (self.render_seconds - self.discarded_seconds).max(1e-9) / 1e6;
        writeln!(
            f,
            "{} × {}, {} samples per pixel, stopped by {:?} ({})",
            self.width, self.height, self.samples_per_pixel, self.stopped_by, self.claim
        )?;
        if let Some(adaptive) = &self.adaptive {
            let few = self.relative_error_trusted == Some(false);
            writeln!(f, "{adaptive}{}", if few { " (not to be trusted: see below)" } else { "" })?;
        }
        if let Some(note) = self.note {
            writeln!(f, "{note}")?;
        }
        writeln!(
            f,
            "{:.2} Mpaths/s; Mrays/s: {:.1} camera, {:.1} bounce, {:.1} shadow; lanes {:.0} % of {} on {} threads",
            self.paths_per_second / 1e6,
            mega(self.rays.camera_rays),
            mega(self.rays.bounce_rays),
            mega(self.rays.shadow_rays),
            (self.lane_utilisation * 100.0).floor(),
            self.lanes,
            self.threads
        )?;
        writeln!(
            f,
            "seconds: {:.3} load, {:.3} build, {:.3} render, {:.3} output, {:.3} in all; peak memory {} MB",
            self.load_seconds,
            self.setup_seconds - self.load_seconds,
            self.render_seconds,
            self.output_seconds,
            self.wall_seconds,
            self.peak_memory_bytes.unwrap_or(0) >> 20
        )?;
        if let Some(e) = self.relative_error {
            // Where few samples carry it, most renders miss some of what there is: no bound then.
            let known = self.relative_error_trusted == Some(true);
            let bound = if known && self.sampler != SamplerKind::Independent {
                ", at most: even samples do better than s²/n says"
            } else {
                ""
            };
            writeln!(f, "relative error {e:.5}{bound}")?;
        }
        if let Some(shares) = self.sample_shares {
            write!(f, "{shares}")?;
        }
        if self.discarded_samples > 0 {
            let (x, y, s) = self.discarded_first.first().copied().unwrap_or_default();
            let Summary { discarded_samples: count, scene, seed, width, height, .. } = self;
            let sampler = self.sampler.name();
            writeln!(
                f,
                "{count} samples were not finite and count as 0; the first: octolux replay {scene} --pixel {x},{y} --sample {s} --size {width}x{height} --seed {seed} --sampler {sampler}{}",
                self.integrator_options
            )?;
            if self.plan.light_paths {
                writeln!(
                    f,
                    "(replay follows the path from the camera; if that is finite, a light path of sample {s} brought what was not)"
                )?;
            }
        }
        Ok(())
    }
}
