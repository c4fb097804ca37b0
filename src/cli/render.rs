//! `octolux render`: scene in, image out.

use super::CliError;
use super::scene_args::{MachineArgs, SceneArgs};
use crate::film::{self, Attribute, Film, VarianceValidity};
use crate::kernel::World;
use crate::plan::Force;
use crate::render::{self, Budget, Options, Outcome, Progress, StoppedBy, Summary, Times, interrupt};
use crate::scene::Scene;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Samples a pixel where no limit is given.
const DEFAULT_SAMPLES: u64 = 64;
/// Samples of the discarded pilot of `--error --unbiased`, and what sets its seed apart.
const PILOT_SAMPLES: u64 = 64;
const PILOT_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

#[derive(clap::Args)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// EXR image: R G B, variance.R/G/B, metadata [default: the scene's name, unless --png is given]
    #[arg(short, long, value_name = "FILE.exr")]
    output: Option<PathBuf>,
    /// 8-bit PNG preview, exposed and sRGB-encoded
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Exposure of the PNG in stops
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
    /// Report as JSON; `-` writes it to standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Stop after this many samples a pixel [default: 64, if no other limit is given]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=render::budget::MAX_SAMPLES))]
    spp: Option<u64>,
    /// Stop so that the image is written this many seconds after the process started
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    time: Option<f64>,
    /// Stop once the estimated relative error √(mean var/(mean² + 0.01)) is at most this
    #[arg(long, value_name = "E", value_parser = positive)]
    error: Option<f64>,
    /// With --error: choose the sample count from a discarded pilot, so that the estimate stays unbiased
    #[arg(long, requires = "error")]
    unbiased: bool,
    /// Also write albedo.*, N.* and Z of the first hit
    #[arg(long)]
    aovs: bool,
    /// Print what the plan kept and left out for this scene, and why
    #[arg(long)]
    explain: bool,
    /// Run the general kernel: leave nothing out (for comparison; same bits)
    #[arg(long)]
    general: bool,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "must be a number above 0".into())
}

/// What `render` and every variant of `converge` make of the same arguments.
impl RenderArgs {
    pub(super) fn world(&self) -> Result<(Scene, World, Times), CliError> {
        self.scene.world(Force { general: self.general, geometry: None }, self.aovs)
    }

    pub(super) fn options(&self, world: &World, budget: Budget, output_seconds: f64) -> Options {
        let (width, tile) = (self.machine.width(), self.machine.tile(world.film));
        Options { budget, width, tile, aovs: self.aovs, output_seconds }
    }

    pub(super) fn threads(&self) -> usize {
        self.machine.threads()
    }
}

pub fn run(args: &RenderArgs) -> Result<bool, CliError> {
    interrupt::listen();
    let targets = Targets::new(args)?;
    let (scene, mut world, mut times) = args.world()?;
    if !args.quiet {
        scene.assumptions.iter().for_each(|line| eprintln!("assumed: {line}"));
    }
    if args.explain {
        eprint!("{}", world.plan.explain());
    }
    let threads = args.threads();
    let pool = render::thread_pool(threads)?;
    let budget = Budget { samples: args.spp, seconds: args.time, error: args.error };
    let mut options = args.options(&world, budget, targets.predicted_seconds(&world, args.aovs));
    if options.budget == Budget::default() {
        options.budget.samples = Some(DEFAULT_SAMPLES);
    }
    if args.unbiased {
        times.pilot = choose_samples(&mut world, &mut options, &pool);
    }
    let mut progress = if args.quiet { Progress::quiet() } else { Progress::new(options.budget) };
    let outcome = render::render(&world, &options, &pool, &mut progress);
    progress.finish();
    let mut summary = Summary::new(&scene.name, &world, &options, threads, &outcome, times);
    let start = Instant::now();
    if outcome.counters.camera_rays == 0 {
        eprintln!("interrupted before the first sample; nothing was written");
        return Ok(true);
    }
    pool.install(|| targets.write_images(&outcome, &summary, args.exposure))?;
    summary.finish(start.elapsed().as_secs_f64());
    targets.write_json(&summary)?;
    if !args.quiet {
        eprint!("{summary}");
    }
    Ok(true)
}

/// Two-stage sampling: a pilot with a seed of its own says how many samples the error target needs; its samples are
/// thrown away. Returns the seconds it took.
fn choose_samples(world: &mut World, options: &mut Options, pool: &rayon::ThreadPool) -> f64 {
    let Some(target) = options.budget.error.take() else { return 0.0 };
    let seed = world.seed;
    world.seed = seed ^ PILOT_SEED;
    let pilot_options = Options {
        budget: Budget { samples: Some(PILOT_SAMPLES), seconds: options.budget.seconds, error: None },
        ..*options
    };
    let pilot = render::render(world, &pilot_options, pool, &mut Progress::quiet());
    world.seed = seed;
    let samples = pilot.film.samples() as f64;
    if let Some(error) = pool.install(|| pilot.film.relative_error()) {
        let needed = (samples * (error / target).powi(2)).ceil().max(1.0) as u64;
        options.budget.samples = Some(options.budget.samples.map_or(needed, |n| n.min(needed)));
    }
    pilot.render_seconds
}

/// Where results go. Checked before anything is rendered.
struct Targets<'a> {
    exr: Option<PathBuf>,
    png: Option<&'a Path>,
    json: Option<&'a Path>,
}

impl<'a> Targets<'a> {
    fn new(args: &'a RenderArgs) -> Result<Self, CliError> {
        let stem = || {
            let path = &args.scene.scene;
            let named_scene = path.file_stem().is_some_and(|s| s == "scene");
            let folder = path.parent().and_then(Path::file_name).filter(|_| named_scene);
            PathBuf::from(folder.or(path.file_stem()).unwrap_or("image".as_ref())).with_added_extension("exr")
        };
        let exr = args.output.clone().or_else(|| args.png.is_none().then(stem));
        let targets = Targets { exr, png: args.png.as_deref(), json: args.json.as_deref() };
        let files = [targets.exr.as_deref(), targets.png, targets.json.filter(|p| *p != Path::new("-"))];
        for path in files.into_iter().flatten() {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            if !folder.is_dir() {
                return Err(CliError::Usage(format!(
                    "{}: there is no folder {}; create it",
                    path.display(),
                    folder.display()
                )));
            }
        }
        Ok(targets)
    }

    /// Measured on two cores: about 150 MB/s of EXR, 60 MB/s of PNG, and a few milliseconds for each file.
    fn predicted_seconds(&self, world: &World, aovs: bool) -> f64 {
        let pixels = world.film.width as f64 * world.film.height as f64;
        let exr = self.exr.as_ref().map_or(0.0, |_| 0.003 + pixels * if aovs { 52.0 } else { 24.0 } / 150e6);
        let png = self.png.map_or(0.0, |_| 0.003 + pixels * 3.0 / 60e6);
        exr + png
    }

    fn write_images(&self, outcome: &Outcome, summary: &Summary, exposure: f32) -> Result<(), CliError> {
        let film = &outcome.film;
        if let Some(path) = &self.exr {
            film::write_exr(film, path, &attributes(film, summary), validity(outcome.stopped_by))?;
        }
        if let Some(path) = self.png {
            film::write_png(film, path, exposure)?;
        }
        Ok(())
    }

    fn write_json(&self, summary: &Summary) -> Result<(), CliError> {
        let Some(path) = self.json else { return Ok(()) };
        // Numbers, strings and lists: nothing that JSON cannot hold.
        let text = serde_json::to_string_pretty(summary).map_err(|e| CliError::Usage(e.to_string()))? + "\n";
        if path == Path::new("-") {
            print!("{text}");
            return Ok(());
        }
        film::beside::write_beside(path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
        Ok(())
    }
}

fn validity(stopped_by: StoppedBy) -> VarianceValidity {
    match stopped_by {
        StoppedBy::Error => VarianceValidity::Stopped,
        _ => VarianceValidity::Independent,
    }
}

fn attributes(film: &Film, summary: &Summary) -> Vec<(String, Attribute)> {
    let text = |s: &str| Attribute::Text(s.to_string());
    [
        ("octolux.version", text(summary.version)),
        ("octolux.scene", text(&summary.scene)),
        ("octolux.samples", Attribute::Integer(film.samples())),
        ("octolux.render_seconds", Attribute::Float(summary.render_seconds as f32)),
        ("octolux.seed", Attribute::Integer(summary.seed)),
        ("octolux.stopped_by", text(&format!("{:?}", summary.stopped_by).to_lowercase())),
        ("octolux.claim", text(summary.claim)),
        ("octolux.discarded_samples", Attribute::Integer(summary.discarded_samples)),
        ("octolux.cpu_features", text(&summary.cpu_features.join(" "))),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec()
}
