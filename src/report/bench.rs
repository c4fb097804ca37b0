//! Paths per second on a scene: settings interleaved window by window, threads pinned, medians.

use crate::film::Film;
use crate::kernel::{Counters, Width, World};
use crate::plan::GeometryMode;
use crate::process;
use crate::render::{self, Budget, Options, Progress};
use std::fmt;

/// What to measure.
#[derive(Clone, Debug)]
pub struct SceneBench {
    pub name: String,
    pub lanes: Vec<Width>,
    pub threads: Vec<usize>,
    pub windows: u16,
    /// Seconds a window lasts at least.
    pub seconds: f64,
}

/// What was measured. Rates are medians over the windows.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SceneBenchReport {
    pub scene: String,
    pub cpu_features: Vec<&'static str>,
    /// How rays found geometry.
    pub geometry: GeometryMode,
    pub settings: Vec<Setting>,
}

#[derive(Clone, Debug, serde::Serialize)]
pub struct Setting {
    pub lanes: usize,
    pub threads: usize,
    pub mpaths_per_s: f64,
    pub min: f64,
    pub max: f64,
    pub mrays_per_s: f64,
    pub rays_per_path: f64,
    pub lane_utilisation: f64,
    pub windows: usize,
}

/// Measures every pair of width and thread count.
///
/// # Errors
/// The operating system gives no threads.
pub fn bench_scene(world: &World, bench: &SceneBench) -> Result<SceneBenchReport, rayon::ThreadPoolBuildError> {
    let mut runs = Vec::new();
    for &threads in &bench.threads {
        let pool = std::sync::Arc::new(render::pinned_thread_pool(threads)?);
        runs.extend(bench.lanes.iter().map(|&width| Run::new(world, width, threads, pool.clone())));
    }
    for run in &mut runs {
        run.calibrate(bench.seconds);
    }
    for _ in 0..bench.windows {
        runs.iter_mut().for_each(|run| drop(run.window()));
    }
    let settings = runs.into_iter().map(Run::report).collect();
    Ok(SceneBenchReport {
        scene: bench.name.clone(),
        cpu_features: crate::cpu::compiled_features(),
        geometry: world.plan.geometry,
        settings,
    })
}

pub(super) struct Run<'a> {
    world: &'a World,
    options: Options,
    threads: usize,
    pool: std::sync::Arc<rayon::ThreadPool>,
    pub(super) rates: Vec<f64>,
    /// Paths per processor second of the last window, which other programs disturb less.
    pub(super) cpu_rate: f64,
    counters: Counters,
}

impl<'a> Run<'a> {
    pub(super) fn new(world: &'a World, width: Width, threads: usize, pool: std::sync::Arc<rayon::ThreadPool>) -> Self {
        let tile = render::default_tile(world.film.width, world.film.height);
        let budget = Budget { samples: Some(1), ..Budget::default() };
        let options = Options { budget, width, tile, aovs: false, output_seconds: 0.0, adaptive: false };
        Run { world, options, threads, pool, rates: Vec::new(), cpu_rate: f64::NAN, counters: Counters::default() }
    }

    /// Doubles the samples of a window until it lasts long enough; this also warms up.
    pub(super) fn calibrate(&mut self, seconds: f64) {
        loop {
            let outcome = render::render(self.world, &self.options, &self.pool, &mut Progress::quiet());
            let samples = self.samples();
            if outcome.render_seconds >= seconds || samples >= 1 << 20 {
                return;
            }
            self.options.budget.samples = Some(samples * 2);
        }
    }

    /// Samples a pixel in a window.
    pub(super) fn samples(&self) -> u64 {
        self.options.budget.samples.unwrap_or(1)
    }

    /// Renders so many samples from now on.
    pub(super) fn set_samples(&mut self, samples: u64) {
        self.options.budget.samples = Some(samples);
    }

    /// Measures one window.
    pub(super) fn window(&mut self) -> Film {
        let before = process::cpu_seconds();
        let outcome = render::render(self.world, &self.options, &self.pool, &mut Progress::quiet());
        self.cpu_rate = outcome.counters.camera_rays as f64 / (process::cpu_seconds() - before);
        self.rates.push(outcome.counters.camera_rays as f64 / outcome.render_seconds / 1e6);
        self.counters = outcome.counters;
        outcome.film
    }

    fn report(mut self) -> Setting {
        self.rates.sort_by(f64::total_cmp);
        let c = &self.counters;
        let rays_per_path = c.rays() as f64 / c.camera_rays.max(1) as f64;
        let median = self.rates[self.rates.len() / 2];
        let lanes = self.options.width.lanes();
        Setting {
            lanes,
            threads: self.threads,
            mpaths_per_s: median,
            min: self.rates[0],
            max: self.rates[self.rates.len() - 1],
            mrays_per_s: median * rays_per_path,
            rays_per_path,
            lane_utilisation: c.active_lanes as f64 / (c.packets.max(1) * lanes as u64) as f64,
            windows: self.rates.len(),
        }
    }
}

impl fmt::Display for SceneBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}", self.scene, self.geometry.describe())?;
        writeln!(f, "lanes threads  Mpaths/s (min–max)  Mrays/s  rays/path  lanes alive")?;
        for s in &self.settings {
            writeln!(
                f,
                "{:5} {:7}  {:8.3} ({:.3}–{:.3})  {:7.2}  {:9.2}  {:10.1} %",
                s.lanes,
                s.threads,
                s.mpaths_per_s,
                s.min,
                s.max,
                s.mrays_per_s,
                s.rays_per_path,
                s.lane_utilisation * 100.0
            )?;
        }
        Ok(())
    }
}
