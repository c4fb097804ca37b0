//! The study itself: pilots, cells in turn, statistics, files.

use super::cell::{Budget, Cell, CellKey};
use super::progress::CellProgress;
use super::reference::Reference;
use super::statistics::{Accumulator, relative};
use super::store::{Store, checksum};
use super::summary::{self, ConvergeReport, Row};
use super::{ConvergeError, html, pictures, store, write};
use crate::film::{self, Attribute, VarianceValidity, read_exr};
use crate::kernel::World;
use crate::render::{self, Options, Outcome, Progress, Times, interrupt};
use crate::scene::Scene;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Seeds that a budget may use before the next one's begin.
const SEEDS_PER_BUDGET: u64 = 1 << 20;
/// A budget in seconds is paced by a pilot that lasts this share of it at least …
const PILOT_SHARE: f64 = 0.4;
/// … so many times, of which the fastest counts: what disturbs a pilot would shorten all cells.
const PILOTS: usize = 3;

/// A scene, ready, and how it is rendered.
pub struct Variant {
    pub name: String,
    /// As they were given: the variant's identity in a folder.
    pub arguments: String,
    pub world: World,
    pub options: Options,
    pub threads: usize,
    pub times: Times,
    /// Of the scene as loaded.
    pub fingerprint: String,
    pool: Arc<rayon::ThreadPool>,
}

/// What to measure.
pub struct Plan {
    pub scene: String,
    pub variants: Vec<Variant>,
    /// In increasing order, all of one kind.
    pub budgets: Vec<Budget>,
    pub seeds: u64,
    pub first_seed: u64,
    /// `None`: one is made from the first variant's scene.
    pub reference: Option<PathBuf>,
    /// Samples a pixel of a made reference; `None`: `REFERENCE_FACTOR` times the largest budget's.
    pub reference_samples: Option<u64>,
    pub folder: PathBuf,
    pub resume: bool,
    /// Stops; `None`: whole stops by the reference's brightness.
    pub exposure: Option<f32>,
    pub quiet: bool,
    /// The command that does this again.
    pub command: String,
}

/// A made reference has this many times the samples of the largest budget: it adds a sixteenth of the least error.
pub const REFERENCE_FACTOR: u64 = 16;

impl Variant {
    /// `pools` are those of the variants before: one for each number of threads, pinned to cores.
    ///
    /// # Errors
    /// The operating system gives no threads.
    pub fn new(
        (name, arguments): (String, String),
        (scene, world, times): (&Scene, World, Times),
        options: Options,
        threads: usize,
        before: &[Variant],
    ) -> Result<Self, rayon::ThreadPoolBuildError> {
        let known = before.iter().find(|v| v.threads == threads).map(|v| v.pool.clone());
        let pool = match known {
            Some(pool) => pool,
            None => Arc::new(render::pinned_thread_pool(threads)?),
        };
        let fingerprint = format!("{:016x}", scene.fingerprint());
        Ok(Variant { name, arguments, world, options, threads, times, fingerprint, pool })
    }

    /// `loud`: with progress of its own.
    pub(super) fn render(&mut self, samples: u64, seed: u64, loud: bool) -> Outcome {
        let budget = render::Budget { samples: Some(samples), ..render::Budget::default() };
        let own = std::mem::replace(&mut self.world.seed, seed);
        let options = Options { budget, ..self.options };
        let mut progress = if loud { Progress::new(budget) } else { Progress::quiet() };
        let outcome = render::render(&self.world, &options, &self.pool, &mut progress);
        progress.finish();
        self.world.seed = own;
        outcome
    }

    /// Samples a pixel that last about `seconds`, by pilots whose samples are thrown away; 0 if interrupted.
    fn pace(&mut self, seconds: f64, seed: u64) -> u64 {
        let (mut samples, mut pilots) = (1, Vec::new());
        while pilots.len() < PILOTS {
            let took = self.render(samples, seed, false).render_seconds;
            if interrupt::asked() {
                return 0;
            }
            if took >= PILOT_SHARE * seconds || samples >= render::budget::MAX_SAMPLES / 2 || !pilots.is_empty() {
                pilots.push(took);
            } else {
                samples *= 2;
            }
        }
        let fastest = pilots.into_iter().fold(f64::INFINITY, f64::min).max(1e-9);
        (samples as f64 * seconds / fastest).round().clamp(1.0, render::budget::MAX_SAMPLES as f64) as u64
    }
}

/// Runs a study and writes its files; what is finished is reported even if the user interrupts.
///
/// # Errors
/// The folder or reference cannot be used, or the user interrupted before a cell was finished.
pub fn run(mut plan: Plan) -> Result<ConvergeReport, ConvergeError> {
    let start = Instant::now();
    store::check_free(
        &plan.folder,
        write::NAMES.map(str::to_owned).into_iter().chain(pictures::names(plan.variants.len())),
    )?;
    if plan.reference.is_none() {
        Reference::check_free(&plan.folder)?;
    }
    // Before anything is written: what cannot be read leaves no study behind.
    let given = given_reference(&plan)?;
    let mut store = Store::open(&plan.folder, &plan.variants, plan.resume)?;
    // The first render of a world touches its memory for the first time: neither a pilot's time nor a cell's.
    plan.variants.iter_mut().for_each(|v| drop(v.render(1, u64::MAX, false)));
    pace_all(&mut plan, &mut store)?;
    let reference = match given {
        Some(reference) => reference,
        None => made_reference(&mut plan, &store)?,
    };
    let cells = render_cells(&mut plan, &mut store)?;
    let mut rows = Vec::new();
    for variant in 0..plan.variants.len() {
        for budget in 0..plan.budgets.len() {
            rows.extend(row(&plan, &store, &reference, (variant, budget), &cells)?);
        }
    }
    if rows.is_empty() {
        return Err(ConvergeError::Interrupted);
    }
    let done = rows.iter().map(|row| row.seeds.len()).sum();
    let report = summary::report(&plan, &reference, rows, (done, cells.len()), start.elapsed().as_secs_f64());
    let images = pictures::write(&plan, &store, &reference, &report)?;
    write::files(&plan.folder, &report)?;
    html::write(&plan.folder, &report, &images)?;
    Ok(report)
}

/// Turns budgets in seconds into samples, by variant, once for all seeds and sessions.
fn pace_all(plan: &mut Plan, store: &mut Store) -> Result<(), ConvergeError> {
    for budget in plan.budgets.clone() {
        let Budget::Seconds(seconds) = budget else { continue };
        for variant in &mut plan.variants {
            if samples_of(store, variant, budget).is_some() {
                continue;
            }
            let samples = variant.pace(seconds, u64::MAX);
            if samples == 0 {
                return Err(ConvergeError::Interrupted);
            }
            store.origin.paced.push((variant.arguments.clone(), budget, samples));
        }
    }
    Ok(store.write()?)
}

fn samples_of(store: &Store, variant: &Variant, budget: Budget) -> Option<u64> {
    let paced = |(arguments, known, _): &&(String, Budget, u64)| *arguments == variant.arguments && *known == budget;
    match budget {
        Budget::Samples(samples) => Some(samples),
        Budget::Seconds(_) => store.origin.paced.iter().find(paced).map(|p| p.2),
    }
}

fn given_reference(plan: &Plan) -> Result<Option<Reference>, ConvergeError> {
    let (Some(path), Some(first)) = (&plan.reference, plan.variants.first()) else { return Ok(None) };
    let film = first.world.film;
    Reference::load(path, (film.width, film.height)).map(Some)
}

fn made_reference(plan: &mut Plan, store: &Store) -> Result<Reference, ConvergeError> {
    let last = plan.budgets.last().copied();
    let largest = plan.variants.iter().filter_map(|v| samples_of(store, v, last?)).max().unwrap_or(1);
    let samples = plan.reference_samples.unwrap_or(REFERENCE_FACTOR * largest).min(render::budget::MAX_SAMPLES);
    // Variants have one image size: that was checked when they were made.
    let Some(first) = plan.variants.first_mut() else { return Err(ConvergeError::Interrupted) };
    Reference::make(first, samples, &plan.folder, !plan.quiet)
}

/// All cells in the order they are rendered: a seed's curves first, budgets from small to large, variants in turn.
fn order(plan: &Plan) -> Vec<(usize, usize, u64)> {
    let mut cells = Vec::new();
    for seed in 0..plan.seeds {
        for budget in 0..plan.budgets.len() {
            cells.extend((0..plan.variants.len()).map(|variant| (variant, budget, seed)));
        }
    }
    cells
}

fn key(plan: &Plan, (variant, budget, seed): (usize, usize, u64)) -> CellKey {
    let seed = plan.first_seed.wrapping_add(budget as u64 * SEEDS_PER_BUDGET).wrapping_add(seed);
    CellKey { variant: plan.variants[variant].arguments.clone(), budget: plan.budgets[budget], seed }
}

/// Renders what is missing, until done or interrupted. Returns the keys of all cells, finished or not.
fn render_cells(plan: &mut Plan, store: &mut Store) -> Result<Vec<CellKey>, ConvergeError> {
    let order = order(plan);
    let keys: Vec<_> = order.iter().map(|&cell| key(plan, cell)).collect();
    let work = |store: &Store, plan: &Plan, at: usize| {
        let (variant, budget, _) = order[at];
        samples_of(store, &plan.variants[variant], plan.budgets[budget]).unwrap_or(1) as f64
    };
    let missing: Vec<_> = (0..keys.len()).filter(|&i| store.find(&keys[i]).is_none()).collect();
    let all_work = missing.iter().map(|&at| work(store, plan, at)).sum();
    let mut progress = CellProgress::new(keys.len(), keys.len() - missing.len(), all_work, plan.quiet);
    for at in missing {
        let (samples, name) = (work(store, plan, at), plan.variants[order[at].0].name.clone());
        progress.start(&format!("{name}, {}, seed {}", keys[at].budget, keys[at].seed));
        let variant = &mut plan.variants[order[at].0];
        let outcome = variant.render(samples as u64, keys[at].seed, false);
        if interrupt::asked() {
            break;
        }
        let cell = save(&plan.folder, variant, keys[at].clone(), &outcome)?;
        store.add(cell)?;
        progress.finish(samples);
    }
    progress.end();
    Ok(keys)
}

/// Writes the image as `render` would, and says what the cell cost.
fn save(folder: &Path, variant: &Variant, key: CellKey, outcome: &Outcome) -> Result<Cell, ConvergeError> {
    let image = format!("cells/{}.exr", checksum(format!("{key:?}").as_bytes()));
    let attributes = [
        ("variant".to_owned(), Attribute::Text(key.variant.clone())),
        ("samples".to_owned(), Attribute::Integer(outcome.samples_per_pixel())),
        ("seed".to_owned(), Attribute::Integer(key.seed)),
    ];
    let start = Instant::now();
    let path = folder.join(&image);
    let validity = VarianceValidity::of(variant.world.sampler, variant.world.integrator.shares_points());
    variant.pool.install(|| film::write_exr(&outcome.film, &path, &attributes, validity))?;
    let output_seconds = start.elapsed().as_secs_f64();
    let error = variant.pool.install(|| outcome.film.relative_error());
    Ok(Cell {
        samples_per_pixel: outcome.samples_per_pixel(),
        render_seconds: outcome.render_seconds,
        output_seconds,
        paths: outcome.counters.camera_rays,
        rays: outcome.counters.rays(),
        discarded_samples: outcome.film.discarded().count,
        estimated_error: error.map(|error| error * error),
        largest_sample_share: error
            .map(|error| variant.pool.install(|| outcome.film.sample_shares(error)).largest_of_error),
        image,
        key,
    })
}

/// Statistics of one variant and budget over the seeds that are finished; `None` where there are none.
fn row(
    plan: &Plan,
    store: &Store,
    reference: &Reference,
    (variant, budget): (usize, usize),
    keys: &[CellKey],
) -> Result<Option<Row>, ConvergeError> {
    let of_row = |key: &&CellKey| key.variant == plan.variants[variant].arguments && key.budget == plan.budgets[budget];
    let cells: Vec<&Cell> = keys.iter().filter(of_row).filter_map(|key| store.find(key)).collect();
    let mut images = Accumulator::new(reference.rgb());
    for cell in &cells {
        images.add(read_exr(&store.path_of(cell))?.rgb());
    }
    if cells.is_empty() {
        return Ok(None);
    }
    let absolute = images.moments(|_| 1.0).split(reference.noise.mse);
    let relative = images.moments(relative).split(reference.noise.relmse);
    let setup = plan.variants[variant].times.load + plan.variants[variant].times.setup;
    let name = plan.variants[variant].name.clone();
    Ok(Some(summary::row(name, &cells, setup, (absolute, relative), &images.absolute_errors)))
}
