//! `octolux render`: scene in, image out.

use super::CliError;
use super::keeper::Keeper;
use super::ladder::LadderArgs;
use super::scene_args::{MachineArgs, SceneArgs};
use super::state_args::StateArgs;
use super::targets::{ImageArgs, check_apart, check_folders, default_exr, write_json};
use crate::kernel::World;
use crate::plan::Force;
use crate::render::adaptive::adaptive_tile;
use crate::render::{self, Budget, Options, Phase, Progress, Summary, Times, interrupt};
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
    #[command(flatten)]
    images: ImageArgs,
    #[command(flatten)]
    state: StateArgs,
    #[command(flatten)]
    ladder: LadderArgs,
    /// Report as JSON; `-` writes it to standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Stop once every pixel has this many samples [default: 64, if no other limit is given]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=render::budget::MAX_SAMPLES))]
    spp: Option<u64>,
    /// Stop so that the image is written this many seconds after the process started (if one sample a pixel takes over
    /// 5 % of that, at most so much later)
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    time: Option<f64>,
    /// Stop once the estimated relative error √(mean var/(mean² + 0.01)) is at most this
    #[arg(long, value_name = "E", value_parser = positive)]
    error: Option<f64>,
    /// With --error: choose the sample count from a discarded pilot, so that the estimate stays unbiased
    #[arg(long, requires = "error")]
    unbiased: bool,
    /// Give tiles numbers of samples that lower the relative error most, each by what the first samples (a quarter, four at least) of
    /// the tiles next to it tell: adds no bias. With --spp N they have N on average
    #[arg(long, conflicts_with_all = ["tile", "state", "resume", "samples", "ladder", "unbiased"])]
    adaptive: bool,
    /// Also write albedo.*, N.* and Z (distance along the ray) of the first hit, and bmc.variance.* where the scene gathers by bmc or bmc-is
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

/// What `render` and every variant of `converge` make of the same arguments: whatever changes an estimate or its cost
/// belongs here, or a variant would not have it.
impl RenderArgs {
    pub(super) fn world(&self) -> Result<(Scene, World, Times), CliError> {
        let force = Force { general: self.general, geometry: None };
        let (scene, world, times) = self.scene.world(force, self.aovs, self.quiet)?;
        let world = if self.adaptive { world.with_tiles_apart() } else { world };
        match self.adaptive.then(|| world.needs_equal_samples()).flatten() {
            Some(why) => Err(CliError::Usage(format!("--adaptive: {why}"))),
            None => Ok((scene, world, times)),
        }
    }

    pub(super) fn options(&self, world: &World, budget: Budget, output_seconds: f64) -> Options {
        let tile = if self.adaptive { adaptive_tile(world) } else { self.machine.tile(world.film) };
        let (width, adaptive) = (self.machine.width(), self.adaptive);
        Options { budget, width, tile, aovs: self.aovs, output_seconds, adaptive }
    }

    pub(super) fn threads(&self) -> usize {
        self.machine.threads()
    }
}

pub fn run(args: &RenderArgs) -> Result<bool, CliError> {
    interrupt::listen(super::leave);
    let images = images(args)?;
    let threads = args.threads();
    let pool = render::thread_pool(threads)?;
    // Building the tree takes the pool's threads, too.
    let (scene, mut world, mut times) = pool.install(|| args.world())?;
    interrupt::keep();
    check_apart(files(args, &images), scene.files.iter().map(PathBuf::as_path))?;
    if !args.quiet {
        scene.assumptions.iter().for_each(|line| crate::process::tell(format_args!("assumed: {line}\n")));
    }
    if args.explain {
        crate::process::tell(format_args!("{}", world.plan.explain()));
    }
    let pixels = f64::from(world.film.width) * f64::from(world.film.height);
    let mut options = args.options(&world, budget(args)?, images.guessed_seconds(pixels, args.aovs));
    args.ladder.check(&world)?;
    check_memory(&world, &options)?;
    let (head, film) = args.state.begin(&scene, &world, &options)?;
    if args.unbiased {
        let _phase = Phase::begin("rendering the pilot", args.quiet);
        times.pilot = choose_samples(&mut world, &mut options, &pool);
    }
    let mut progress =
        if args.quiet { Progress::quiet() } else { Progress::new(args.ladder.budget().unwrap_or(options.budget)) };
    let held = film.samples();
    // A ladder's PNG is its sheet.
    let kept = ImageArgs { png: images.png.clone().filter(|_| !args.ladder.is_asked_for()), ..images.clone() };
    let mut keeper = Keeper::new(&kept, args.state.file(), args.state.save_every(), &pool, head);
    let outcome = match args.ladder.is_asked_for() {
        true => args.ladder.run(&world, &options, &pool, &mut progress, &images)?,
        false => render::render_on(film, &world, &options, &pool, &mut progress, &mut keeper),
    };
    progress.finish();
    let mut summary = Summary::new(&scene.name, &world, &options, threads, &outcome, times);
    summary.resumed(held, keeper.stopped_by(&outcome.film, outcome.stopped_by));
    // Pixels without a sample would be black.
    if outcome.film.samples() == 0 {
        return Err(CliError::Interrupted);
    }
    if args.adaptive && outcome.adaptive.is_none() {
        log::warn!(
            "--adaptive: the budget is too small for a pilot (time for some five samples a pixel is enough); all pixels have as many"
        );
    }
    let start = Instant::now();
    let phase = Phase::begin("writing", args.quiet);
    keeper.finish(&outcome)?;
    drop(phase);
    summary.finish(start.elapsed().as_secs_f64());
    write_json(&summary, args.json.as_deref())?;
    if !args.quiet {
        crate::process::tell(format_args!("{summary}"));
    } else if summary.discarded_samples > 0 {
        let count = summary.discarded_samples;
        log::warn!("{count} samples were not finite and count as 0; without --quiet the first is named");
    }
    Ok(true)
}

/// The images to write; folders and states are looked at before anything is rendered.
fn images(args: &RenderArgs) -> Result<ImageArgs, CliError> {
    let mut images = args.images.clone();
    if images.files().next().is_none() {
        images.output = Some(default_exr(&args.scene.scene));
    }
    images.check()?;
    check_folders(files(args, &images))?;
    let read =
        [args.scene.scene.as_path()].into_iter().chain(args.state.left_behind()).chain(args.ladder.reference_file());
    check_apart(files(args, &images), read)?;
    args.state.check()?;
    Ok(images)
}

/// All that will be written.
fn files<'a>(args: &'a RenderArgs, images: &'a ImageArgs) -> impl Iterator<Item = &'a Path> {
    let report = args.json.as_deref().filter(|path| *path != Path::new("-"));
    images.files().chain(report).chain(args.state.file())
}

/// A film that the system gives no memory for would end the process in the middle of its work.
fn check_memory(world: &World, options: &Options) -> Result<(), CliError> {
    let (width, height) = (world.film.width, world.film.height);
    let bytes = render::film_bytes(world, options);
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| {
        let megabytes = bytes >> 20;
        CliError::Usage(format!(
            "a film of {width}x{height} pixels needs {megabytes} MB, which the system does not give; ask for fewer by --size"
        ))
    })
}

fn budget(args: &RenderArgs) -> Result<Budget, CliError> {
    let samples = args.spp.or(args.state.count());
    let budget = Budget { samples, seconds: args.time, error: args.error };
    match budget == Budget::default() {
        false => Ok(budget),
        true if args.state.resumes() => {
            Err(CliError::Usage("how far should it go on? give --spp N (samples in all), --time or --error".into()))
        }
        true => Ok(Budget { samples: Some(DEFAULT_SAMPLES), ..budget }),
    }
}

/// Two-stage sampling: a pilot with a seed of its own says how many samples the error target needs; its samples are
/// thrown away. Returns the seconds it took.
fn choose_samples(world: &mut World, options: &mut Options, pool: &rayon::ThreadPool) -> f64 {
    let Some(target) = options.budget.error.take() else { return 0.0 };
    let seed = world.seed;
    world.seed = seed ^ PILOT_SEED;
    // At most a quarter of the time that is left.
    let now = crate::process::seconds_since_process_start();
    let seconds = options.budget.seconds.map(|end| now + 0.25 * (end - now).max(0.0));
    let pilot_options = Options { budget: Budget { samples: Some(PILOT_SAMPLES), seconds, error: None }, ..*options };
    let pilot = render::render(world, &pilot_options, pool, &mut Progress::quiet());
    world.seed = seed;
    let samples = pilot.film.samples() as f64;
    if let Some(error) = pool.install(|| pilot.film.relative_error()) {
        let needed = (samples * (error / target).powi(2)).ceil().max(1.0) as u64;
        options.budget.samples = Some(options.budget.samples.map_or(needed, |n| n.min(needed)));
    }
    pilot.render_seconds
}
