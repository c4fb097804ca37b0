//! From a prepared [`World`] to a [`Film`]: passes over tiles in a thread pool of our own, until a budget is spent.

pub mod adaptive;
pub mod budget;
pub mod interrupt;
mod pass;
mod phase;
mod pilot;
mod progress;
mod splats;
#[allow(missing_docs)] // fields are keys of the state's head
pub mod state;
#[allow(missing_docs)] // fields are keys of the report
mod summary;

pub use budget::{Budget, StoppedBy};
pub use phase::Phase;
pub use progress::Progress;
pub use state::{State, StateError};
pub use summary::{Summary, Times};

use crate::film::{BLOCK, Film, FilmChannels, TileFilm};
use crate::kernel::{Counters, Job, REUSE_SIDE, SampleBuffer, Width, World, select, select_light};
use crate::lane::float_mode;
use crate::process::{allowed_cores, pin_to_core, seconds_since_process_start};
use adaptive::{AdaptiveReport, Rates};
use budget::Pacer;
use pass::Pass;
use rayon::prelude::*;
use splats::SplatSums;
use std::time::Instant;

/// How to render, apart from what the scene says.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// When to stop.
    pub budget: Budget,
    /// Lanes.
    pub width: Width,
    /// Side of a tile in pixels; see [`default_tile`].
    pub tile: u32,
    /// Keep albedo, normal and distance of the first hit.
    pub aovs: bool,
    /// Seconds to keep in reserve for writing the image, where time is limited and [`Watch::output_seconds`] knows
    /// nothing better.
    pub output_seconds: f64,
    /// Divide the samples by a [pilot](adaptive): the film must be empty and begin with sample 0, and the world
    /// [not need equal samples](World::needs_equal_samples).
    pub adaptive: bool,
}

/// Small tiles balance the load of a small image; large ones drain their lanes less often.
pub fn default_tile(width: u32, height: u32) -> u32 {
    if width.max(height) <= 512 { 16 } else { 32 }
}

/// A finished render.
pub struct Outcome {
    /// Of all samples.
    pub film: Film,
    /// What ended it.
    pub stopped_by: StoppedBy,
    /// Rays and lanes.
    pub counters: Counters,
    /// From the first sample traced to the finished film.
    pub render_seconds: f64,
    /// Where samples were divided.
    pub adaptive: Option<AdaptiveReport>,
}

impl Outcome {
    /// Samples that every pixel has, or where they were [divided](Outcome::adaptive), their mean, rounded.
    pub fn samples_per_pixel(&self) -> u64 {
        if self.adaptive.is_some() { self.film.mean_samples().round() as u64 } else { self.film.samples() }
    }
}

/// Worker threads, pinned to nothing, none of them the global pool's, each with the default
/// [floating-point mode](crate::lane::float_mode).
///
/// # Errors
/// The operating system gives no thread.
pub fn thread_pool(threads: usize) -> Result<rayon::ThreadPool, rayon::ThreadPoolBuildError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("octolux-{i}"))
        .start_handler(|_| float_mode::restore())
        .build()
}

/// The same with thread i pinned to the i-th core this process may use: for measuring.
///
/// # Errors
/// The operating system gives no thread.
pub fn pinned_thread_pool(threads: usize) -> Result<rayon::ThreadPool, rayon::ThreadPoolBuildError> {
    let cores = allowed_cores();
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .start_handler(move |i| {
            float_mode::restore();
            if let Some(&core) = cores.get(i % cores.len().max(1)) {
                pin_to_core(core);
            }
        })
        .build()
}

/// Accompanies a render: asked and told between passes.
pub trait Watch {
    /// Seconds that writing this film will take, from a trial; asked once, after the first pass.
    fn output_seconds(&mut self, _film: &Film) -> Option<f64> {
        None
    }
    /// A pass is over; `seconds` of rendering so far. Where samples are divided among tiles, these differ in
    /// number.
    fn pass_done(&mut self, _film: &Film, _counters: &Counters, _seconds: f64) {}
}

/// Watches nothing.
impl Watch for () {}

/// Renders until a budget is spent or the user interrupts. The film's bits depend on the scene, the seed and the
/// number of samples alone.
pub fn render(world: &World, options: &Options, pool: &rayon::ThreadPool, progress: &mut Progress) -> Outcome {
    render_on(empty_film(world, options, 0), world, options, pool, progress, &mut ())
}

/// A film for `world` whose first sample will be number `64 · first_block`.
pub fn empty_film(world: &World, options: &Options, first_block: u64) -> Film {
    let channels = FilmChannels::of(options.aovs, world.plan.posterior);
    // Pixels that share paths are in one tile.
    let tile = if world.plan.path_reuse { options.tile.next_multiple_of(REUSE_SIDE) } else { options.tile };
    Film::new(world.film.width, world.film.height, tile, channels, first_block)
}

/// Memory that a film for `world` takes at least: sums of the block of samples at work, and of those before it if there are any.
pub fn film_bytes(world: &World, options: &Options) -> usize {
    let pixels = world.film.width as usize * world.film.height as usize;
    let sums = FilmChannels::of(options.aovs, world.plan.posterior).stride() * size_of::<f64>();
    let blocks = if options.budget.samples.is_some_and(|samples| samples <= BLOCK) { 1 } else { 2 };
    pixels * (blocks * sums + size_of::<[f32; 3]>())
}

/// What renders a job into a buffer that was [reset](SampleBuffer::reset) for it: one of [`select`]'s, or a program's own.
pub type JobKernel<'a> = &'a (dyn Fn(&World, &Job, &mut SampleBuffer, &mut Counters) + Sync);

/// Goes on with a film of this world (whose channels and tiles count, not the options'), as [`render`] would have.
pub fn render_on(
    film: Film,
    world: &World,
    options: &Options,
    pool: &rayon::ThreadPool,
    progress: &mut Progress,
    watch: &mut dyn Watch,
) -> Outcome {
    render_by(&select(world, options.width), film, world, options, pool, progress, watch)
}

/// The same by a kernel of the caller's, which is called from many threads and must do for each job what it would do for
/// it alone.
///
/// Panics if samples are to be divided in a world that [needs equal ones](World::needs_equal_samples): that would be a bias which
/// nothing shows.
pub fn render_by(
    kernel: JobKernel,
    mut film: Film,
    world: &World,
    options: &Options,
    pool: &rayon::ThreadPool,
    progress: &mut Progress,
    watch: &mut dyn Watch,
) -> Outcome {
    let equal = world.needs_equal_samples().filter(|_| options.adaptive);
    assert!(equal.is_none(), "{equal:?}");
    let pass = Pass { world, kernel, light: select_light(world, options.width), aovs: film.channels().has_aovs() };
    let mut output = options.output_seconds;
    let mut first_pass = true;
    let start = Instant::now();
    // Fresh memory costs page faults, which would pass for the price of samples.
    pool.install(|| film.tiles_mut().par_iter_mut().for_each(TileFilm::begin));
    let mut counters = Counters::default();
    let mut splats = (options.adaptive && pass.light.is_some()).then(|| SplatSums::new(world));
    let find = || pool.install(|| Rates::find(&pass, &mut film, &options.budget, splats.as_mut(), &mut counters));
    let rates = options.adaptive.then(find).flatten();
    // What the pilot has taken is in the film, and done again by no tile.
    let (mut done, mut next) = rates.as_ref().map_or((film.samples(), film.next_sample()), |_| (0, 0));
    let most = done + rates.as_ref().map_or(budget::MAX_SAMPLES, |_| Rates::MOST_SAMPLES) - next;
    let samples = Some(options.budget.samples.unwrap_or(most).min(most));
    let budget = Budget { samples, ..options.budget };
    let mut pacer = match &rates {
        None => Pacer::new(budget),
        Some(rates) => Pacer::paced(budget, rates.seconds_per_sample),
    };
    let stopped_by = loop {
        let samples = match pacer.next(done, seconds_since_process_start(), output) {
            Ok(samples) => samples,
            Err(reason) => break reason,
        };
        let pass_start = Instant::now();
        let (tiles, end) = (film.tiles_mut(), next + samples);
        counters.add(&pool.install(|| match &rates {
            Some(rates) => pass.run_at_rates(tiles, rates, splats.as_mut(), end),
            None => pass.run(tiles, next, end),
        }));
        if interrupt::asked() {
            break StoppedBy::Interrupt;
        }
        (done, next) = (done + samples, next + samples);
        pacer.learn(samples, pass_start.elapsed().as_secs_f64(), done);
        if std::mem::take(&mut first_pass) && options.budget.seconds.is_some() {
            output = watch.output_seconds(&film).unwrap_or(output);
        }
        watch.pass_done(&film, &counters, start.elapsed().as_secs_f64());
        let relative_error = || {
            pool.install(|| match &splats {
                Some(splats) if rates.is_some() => splats.with(&film).relative_error(),
                _ => film.relative_error(),
            })
        };
        progress.update(done, &counters, start.elapsed().as_secs_f64(), relative_error);
        if pacer.tests_error(done) && relative_error().zip(options.budget.error).is_some_and(|(e, target)| e <= target)
        {
            break StoppedBy::Error;
        }
    };
    let render_seconds = start.elapsed().as_secs_f64();
    let adaptive = rates.map(|rates| pool.install(|| rates.report(&film)));
    if let Some(splats) = splats.filter(|_| adaptive.is_some()) {
        film = pool.install(|| splats.with(&film));
    }
    Outcome { film, stopped_by, counters, render_seconds, adaptive }
}
