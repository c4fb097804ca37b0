//! The report as data: what `report.json` holds.

use super::cell::{Budget, Cell};
use super::reference::{Noise, NoiseSource, Reference};
use super::run::{Plan, Variant};
use super::statistics::{LARGEST_TRUSTED_SHARE, Split};
use crate::film::shares::LARGEST_TRUSTED_OF_ERROR;
use crate::report::fit::{Estimate, PowerLaw, Reached, budget_for, fit_power_law};
use crate::student::CONFIDENCE;
use serde::{Deserialize, Serialize};

/// Version of the JSON's form; raised when a field changes its meaning or goes.
pub const REPORT_FORMAT: u32 = 1;
/// relMSE that budgets are given for.
pub const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvergeReport {
    pub format: u32,
    /// `converge`.
    pub kind: String,
    pub scene: String,
    pub command: String,
    pub width: u32,
    pub height: u32,
    pub budgets: Vec<Budget>,
    pub seeds: u64,
    /// Budget i uses seeds first_seed + 2^20 i + 0, 1, 2 …
    pub first_seed: u64,
    pub confidence: f64,
    pub reference: ReferenceReport,
    pub variants: Vec<VariantReport>,
    pub cells_done: usize,
    pub cells: usize,
    /// Of this session.
    pub wall_seconds: f64,
    pub machine: Machine,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceReport {
    pub file: String,
    pub samples_per_pixel: Option<u64>,
    pub noise: Noise,
    pub noise_source: NoiseSource,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    pub cpu: Option<String>,
    /// Cores that this process may use.
    pub cores: usize,
    pub version: String,
    pub build: String,
    pub optimised: bool,
    pub cpu_features: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariantReport {
    pub name: String,
    pub arguments: String,
    pub lanes: usize,
    pub threads: usize,
    pub load_seconds: f64,
    /// Load included.
    pub setup_seconds: f64,
    pub rows: Vec<Row>,
    /// relMSE against samples a pixel, and against seconds of rendering, whose own spread is in the interval.
    pub relmse_by_samples: Option<PowerLaw>,
    pub relmse_by_seconds: Option<PowerLaw>,
    pub targets: Vec<Target>,
}

impl VariantReport {
    /// Rests what is said of a relMSE on intervals that cannot be trusted: on those of one of the two nearest rows?
    pub fn is_doubted(&self, relmse: f64) -> bool {
        let far =
            |row: &&Row| if row.relmse.value > 0.0 { (row.relmse.value / relmse).ln().abs() } else { f64::INFINITY };
        let mut rows: Vec<&Row> = self.rows.iter().collect();
        rows.sort_by(|a, b| far(a).total_cmp(&far(b)));
        rows.iter().take(2).any(|row| !row.doubts.is_empty())
    }
}

/// What a relMSE costs; `None` where it cannot be said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    pub relmse: f64,
    pub paths: Option<Reached>,
    /// Rendering alone.
    pub seconds: Option<Reached>,
    /// Set-up, rendering, writing.
    pub wall_seconds: Option<Reached>,
}

/// One variant at one budget, over seeds. Errors are against the reference, less its own noise (but for MAE).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub variant: String,
    pub budget: Budget,
    pub samples_per_pixel: u64,
    pub mse: Estimate,
    pub rmse: Estimate,
    pub relmse: Estimate,
    /// The reference's noise is in it.
    pub mae: Estimate,
    pub bias_squared: Option<Estimate>,
    pub variance: Option<Estimate>,
    pub relative_bias_squared: Option<Estimate>,
    pub relative_variance: Option<Estimate>,
    pub seconds: Estimate,
    pub wall_seconds: Estimate,
    /// variance × seconds.
    pub time_to_unit_variance: Option<Estimate>,
    /// Camera paths of one seed.
    pub paths: u64,
    pub rays: u64,
    /// Of all seeds.
    pub discarded_samples: u64,
    /// The largest value's share of the summed squared error, and of the summed relative one.
    pub largest_share: f64,
    pub largest_relative_share: f64,
    /// The largest single sample's share of the squared relative error of all seeds, as their own variances have it; `None`
    /// of one sample a pixel.
    pub largest_sample_share: Option<f64>,
    /// May the intervals of MSE and RMSE be relied on, and that of relMSE? Of relMSE only where nothing is in doubt: seeds in which no
    /// value stands out may be those that missed what others find, and the squared error tells of that sooner.
    pub rmse_trusted: bool,
    pub relmse_trusted: bool,
    /// Why they may not, in words; empty if both may.
    pub doubts: Vec<String>,
    pub seeds: Vec<SeedRow>,
}

/// One cell's own values; the reference's noise is in them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeedRow {
    pub seed: u64,
    pub mae: f64,
    pub render_seconds: f64,
    pub output_seconds: f64,
    pub image: String,
}

pub fn row(variant: String, cells: &[&Cell], setup: f64, (absolute, relative): (Split, Split), mae: &[f64]) -> Row {
    let seconds: Vec<f64> = cells.iter().map(|cell| cell.render_seconds).collect();
    let wall: Vec<f64> = cells.iter().map(|cell| setup + cell.render_seconds + cell.output_seconds).collect();
    let seed = |(cell, &mae): (&&Cell, &f64)| SeedRow {
        seed: cell.key.seed,
        mae,
        render_seconds: cell.render_seconds,
        output_seconds: cell.output_seconds,
        image: cell.image.clone(),
    };
    let first = cells[0];
    let seconds = Estimate::mean(&seconds);
    let shares = (absolute.largest_share, relative.largest_share);
    let all_doubts = all_doubts(cells, shares, (absolute.error, relative.error));
    Row {
        variant,
        budget: first.key.budget,
        samples_per_pixel: first.samples_per_pixel,
        mse: absolute.error,
        rmse: absolute.error.sqrt(),
        relmse: relative.error,
        mae: Estimate::mean(mae),
        bias_squared: absolute.bias_squared,
        variance: absolute.variance,
        relative_bias_squared: relative.bias_squared,
        relative_variance: relative.variance,
        seconds,
        wall_seconds: Estimate::mean(&wall),
        time_to_unit_variance: absolute.variance.map(|variance| variance.times(seconds)),
        paths: first.paths,
        rays: first.rays,
        discarded_samples: cells.iter().map(|cell| cell.discarded_samples).sum(),
        largest_share: shares.0,
        largest_relative_share: shares.1,
        largest_sample_share: largest_sample_share(cells),
        rmse_trusted: doubts(cells.len(), shares.0, absolute.error, "").is_empty(),
        relmse_trusted: all_doubts.is_empty(),
        doubts: all_doubts,
        seeds: cells.iter().zip(mae).map(seed).collect(),
    }
}

/// Why an interval of `error` cannot be trusted.
fn doubts(seeds: usize, share: f64, error: Estimate, metric: &str) -> Vec<String> {
    let mut doubts = Vec::new();
    if seeds < 3 {
        doubts.push(format!("{seeds} seed{}", if seeds == 1 { "" } else { "s" }));
    }
    if share > LARGEST_TRUSTED_SHARE {
        doubts.push(format!("one value makes up {:.1} % of the {metric}", 100.0 * share));
    }
    if error.value <= 0.0 || (error.lo <= 0.0 && seeds >= 3) {
        doubts.push(format!("{metric} not told from zero"));
    }
    doubts
}

fn all_doubts(cells: &[&Cell], shares: (f64, f64), errors: (Estimate, Estimate)) -> Vec<String> {
    let mut all = doubts(cells.len(), shares.0, errors.0, "squared error");
    all.extend(doubts(cells.len(), shares.1, errors.1, "relMSE"));
    if let Some(share) = largest_sample_share(cells).filter(|&share| share > LARGEST_TRUSTED_OF_ERROR) {
        all.push(format!("one sample makes up {:.1} % of the squared relative error", 100.0 * share));
    }
    all.dedup();
    all
}

/// Each seed's largest sample against the errors of all.
fn largest_sample_share(cells: &[&Cell]) -> Option<f64> {
    let parts = cells.iter().map(|cell| Some([cell.estimated_error?, cell.largest_sample_share?]));
    let parts: Vec<[f64; 2]> = parts.collect::<Option<_>>()?;
    let all: f64 = parts.iter().map(|[error, _]| error).sum();
    let largest = parts.iter().map(|[error, share]| error * share).fold(0.0, f64::max);
    (!parts.is_empty()).then(|| if all > 0.0 { largest / all } else { 0.0 })
}

impl ConvergeReport {
    /// Names of variants whose errors have the same bits at every budget, in groups of two or more.
    pub fn same_images(&self) -> Vec<Vec<&str>> {
        let errors = |v: &VariantReport| -> Vec<[u64; 3]> {
            v.rows.iter().map(|row| [row.mse.value, row.relmse.value, row.mae.value].map(f64::to_bits)).collect()
        };
        let mut groups: Vec<(Vec<[u64; 3]>, Vec<&str>)> = Vec::new();
        for variant in &self.variants {
            let own = errors(variant);
            match groups.iter_mut().find(|(known, _)| *known == own) {
                Some((_, names)) => names.push(&variant.name),
                None => groups.push((own, vec![&variant.name])),
            }
        }
        groups.into_iter().map(|(_, names)| names).filter(|names| names.len() > 1).collect()
    }
}

/// `done` and `cells`: how many were finished, of how many.
pub fn report(
    plan: &Plan,
    reference: &Reference,
    rows: Vec<Row>,
    (done, cells): (usize, usize),
    seconds: f64,
) -> ConvergeReport {
    let own = |v: &Variant| rows.iter().filter(|row| row.variant == v.name).cloned().collect();
    ConvergeReport {
        format: REPORT_FORMAT,
        kind: "converge".to_owned(),
        scene: plan.scene.clone(),
        command: plan.command.clone(),
        width: reference.width,
        height: reference.height,
        budgets: plan.budgets.clone(),
        seeds: plan.seeds,
        first_seed: plan.first_seed,
        confidence: CONFIDENCE,
        reference: ReferenceReport {
            file: reference.path.display().to_string(),
            samples_per_pixel: reference.samples_per_pixel,
            noise: reference.noise,
            noise_source: reference.noise_source,
        },
        variants: plan.variants.iter().map(|v| variant_report(v, own(v))).collect(),
        cells_done: done,
        cells,
        wall_seconds: seconds,
        machine: Machine {
            cpu: crate::process::cpu_model(),
            cores: crate::process::allowed_cores().len(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            build: super::store::build_id(),
            optimised: !cfg!(debug_assertions),
            cpu_features: crate::cpu::compiled_features().into_iter().map(str::to_owned).collect(),
        },
    }
}

fn variant_report(variant: &Variant, rows: Vec<Row>) -> VariantReport {
    let curve = |x: fn(&Row) -> f64| rows.iter().map(|row| (x(row), row.relmse)).collect::<Vec<_>>();
    let samples = curve(|row| row.samples_per_pixel as f64);
    let seconds: Vec<_> = rows.iter().map(|row| (row.seconds.value, row.relmse.uncertain_by(row.seconds))).collect();
    let (by_samples, by_seconds) = (fit_power_law(&samples), fit_power_law(&seconds));
    let slope = |law: &Option<PowerLaw>| law.map(|law| law.exponent);
    let overhead = |row: &Row| row.wall_seconds.value - row.seconds.value;
    let target = |&relmse: &f64| {
        let seconds = budget_for(&seconds, relmse, slope(&by_seconds));
        let around = rows.last().map_or(0.0, overhead);
        Target {
            relmse,
            paths: budget_for(&curve(|row| row.paths as f64), relmse, slope(&by_samples)),
            seconds,
            // Not along the wall clock's own slope, which the fixed part bends.
            wall_seconds: seconds.map(|s| s.plus(around)),
        }
    };
    let targets = TARGETS.iter().map(target).collect();
    VariantReport {
        name: variant.name.clone(),
        arguments: variant.arguments.clone(),
        lanes: variant.options.width.lanes(),
        threads: variant.threads,
        load_seconds: variant.times.load,
        setup_seconds: variant.times.load + variant.times.setup,
        relmse_by_samples: by_samples,
        relmse_by_seconds: by_seconds,
        targets,
        rows,
    }
}
