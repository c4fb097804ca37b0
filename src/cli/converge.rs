//! `octolux converge`: error against samples and run time, and the report of it.

use super::CliError;
use super::variants::{self, VariantArgs};
use crate::process::command_line;
use crate::render::{budget::MAX_SAMPLES, interrupt};
use crate::report::converge::{self, Budget, ConvergeReport, Plan, Variant};
use std::path::PathBuf;

/// Where no budget is given.
const DEFAULT_SPP: [u64; 5] = [1, 4, 16, 64, 256];

#[derive(clap::Args)]
pub struct ConvergeArgs {
    /// scene.toml, or a bare model.obj
    scene: PathBuf,
    /// Folder for the report and its cells
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Image to measure against; its noise is read from NAME.json beside it (`relmse_floor`, `rmse_floor`) or from its
    /// variance layer [default: one is made]
    #[arg(long, value_name = "REF.exr")]
    reference: Option<PathBuf>,
    /// Samples a pixel of a reference that is made [default: 16 times the largest budget]
    #[arg(long, value_name = "N", conflicts_with = "reference", value_parser = clap::value_parser!(u64).range(4..=MAX_SAMPLES))]
    reference_spp: Option<u64>,
    /// Budgets in samples a pixel [default: 1,4,16,64,256]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = clap::value_parser!(u64).range(1..=MAX_SAMPLES))]
    spp: Vec<u64>,
    /// Budgets in seconds of rendering
    #[arg(long, value_name = "S,S,…", value_delimiter = ',', conflicts_with = "spp", value_parser = super::render::positive)]
    times: Vec<f64>,
    /// Independent renders of each variant and budget
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// The first of them
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What to compare: "NAME: FLAGS; NAME: FLAGS" with flags of `render`, as in "8 lanes: --lanes 8; 16 lanes: --lanes
    /// 16". Flags may begin with another scene. May be given more than once
    #[arg(long, value_name = "VARIANTS", allow_hyphen_values = true)]
    variants: Vec<String>,
    /// Go on with the study in the folder
    #[arg(long)]
    resume: bool,
    /// Exposure of the images in stops [default: whole stops by the reference's brightness]
    #[arg(long, allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
    /// After `--`: flags of `render` that all variants share, as in `-- --size 128x128 --threads 2`
    #[arg(last = true, value_name = "RENDER FLAGS")]
    common: Vec<String>,
}

pub fn run(args: &ConvergeArgs) -> Result<bool, CliError> {
    interrupt::listen(super::leave);
    let plan = plan(args)?;
    interrupt::keep();
    let report = converge::run(plan)?;
    if !args.quiet {
        print!("{}", table(&report));
        crate::process::tell(format_args!("{}\n", args.output.join("report.html").display()));
    }
    Ok(true)
}

fn plan(args: &ConvergeArgs) -> Result<Plan, CliError> {
    let variants = variants::parse(&args.variants, &args.scene, &args.common)?;
    let mut ready = Vec::new();
    for variant in variants {
        ready.push(prepare(variant, &ready)?);
    }
    let size = |v: &Variant| (v.world.film.width, v.world.film.height);
    if let Some(other) = ready.iter().find(|v| size(v) != size(&ready[0])) {
        return Err(CliError::Usage(format!(
            "variant `{}` renders {:?} pixels, the first one {:?}: only images of one size can be compared",
            other.name,
            size(other),
            size(&ready[0])
        )));
    }
    Ok(Plan {
        scene: args.scene.display().to_string(),
        variants: ready,
        budgets: budgets(args),
        seeds: args.seeds,
        first_seed: args.seed,
        reference: args.reference.clone(),
        reference_samples: args.reference_spp,
        folder: args.output.clone(),
        resume: args.resume,
        exposure: args.exposure,
        quiet: args.quiet,
        command: command_line(),
    })
}

fn prepare(variant: VariantArgs, before: &[Variant]) -> Result<Variant, CliError> {
    let (scene, world, times) = variant.render.world()?;
    let options = variant.render.options(&world, Default::default(), 0.0);
    let threads = variant.render.threads();
    let named = (variant.name, variant.arguments);
    Ok(Variant::new(named, (&scene, world, times), options, threads, before)?)
}

/// In increasing order, each once.
fn budgets(args: &ConvergeArgs) -> Vec<Budget> {
    if !args.times.is_empty() {
        let mut times = args.times.clone();
        times.sort_by(f64::total_cmp);
        times.dedup();
        return times.into_iter().map(Budget::Seconds).collect();
    }
    let mut spp = if args.spp.is_empty() { DEFAULT_SPP.to_vec() } else { args.spp.clone() };
    spp.sort_unstable();
    spp.dedup();
    spp.into_iter().map(Budget::Samples).collect()
}

/// The rows as a person reads them.
fn table(report: &ConvergeReport) -> String {
    let name = report.variants.iter().map(|v| v.name.chars().count()).max().unwrap_or(0).max(7);
    let mut text = format!(
        "{:name$} {:>8} {:>5} {:>11} {:>22} {:>10} {:>10}\n",
        "variant", "spp", "seeds", "RMSE", "relMSE (95 %)", "seconds", "bias² rel"
    );
    for row in report.variants.iter().flat_map(|v| &v.rows) {
        let half = 50.0 * (row.relmse.hi - row.relmse.lo) / row.relmse.value.abs();
        // One seed has no interval, and no error none that is a share of it.
        let half = if half.is_finite() { format!("± {half:>6.1} %") } else { "-".to_owned() };
        let bias = row.relative_bias_squared.map_or("-".to_owned(), |bias| format!("{:.2e}", bias.value));
        text += &format!(
            "{:name$} {:>8} {:>5} {:>11.4e} {:>11.4e} {:>10} {:>10.4} {bias:>10}{}\n",
            row.variant,
            row.samples_per_pixel,
            row.seeds.len(),
            row.rmse.value,
            row.relmse.value,
            half,
            row.seconds.value,
            if row.doubts.is_empty() { "" } else { " *" }
        );
    }
    if report.variants.iter().flat_map(|v| &v.rows).any(|row| !row.doubts.is_empty()) {
        text += "* an interval that cannot be trusted; the report says why\n";
    }
    for v in &report.variants {
        let slope = |law: &Option<crate::report::fit::PowerLaw>| {
            law.map_or("-".to_owned(), |l| format!("{:.3} ± {:.3}", l.exponent.value, l.exponent.hi - l.exponent.value))
        };
        let to = |target: &converge::Target| match target.seconds {
            Some(s) => {
                let guess = if s.extrapolated { " ~" } else { "" };
                let doubt = if v.is_doubted(target.relmse) { " *" } else { "" };
                format!("{:e}: {:.3} s [{:.3}, {:.3}]{guess}{doubt}", target.relmse, s.budget, s.lo, s.hi)
            }
            None => format!("{:e}: -", target.relmse),
        };
        text += &format!(
            "{}: slope by samples {}, by seconds {}; relMSE {}\n",
            v.name,
            slope(&v.relmse_by_samples),
            slope(&v.relmse_by_seconds),
            v.targets.iter().map(to).collect::<Vec<_>>().join(", ")
        );
    }
    text
}
