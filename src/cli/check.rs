//! `octolux check`: prints what was compared and, where something differs, how to replay it.

use super::CliError;
use super::check_numerics::{self, NumericsArgs};
use super::scene_args::SceneArgs;
use crate::check::{Difference, ImageCase, StageReport, compare_images, compare_stages};
use crate::kernel::{Stage, Width, World};
use crate::plan::{BRUTE_FORCE_LIMIT, Force, GeometryMode};
use crate::render::Phase;

/// Past this many primitives the tree is not compared with brute force: it would take too long.
const BRUTE_FORCE_CHECK_LIMIT: usize = 20_000;

#[derive(clap::Args)]
#[command(mut_arg("scene", |scene| scene.required(false).required_unless_present("numerics")))]
pub struct CheckArgs {
    /// `None` with `--numerics`
    #[command(flatten)]
    scene: Option<SceneArgs>,
    #[command(flatten)]
    numerics: NumericsArgs,
    /// Samples a pixel
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=4096))]
    spp: u32,
    /// Flip a bit of this stage's values, to see that it is found
    #[arg(long, value_name = "STAGE", value_parser = parse_stage)]
    inject_fault: Option<Stage>,
    /// Write the result as JSON to standard output
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

fn parse_stage(text: &str) -> Result<Stage, String> {
    let names: Vec<_> = Stage::ALL.iter().map(|s| s.name()).collect();
    Stage::ALL.into_iter().find(|s| s.name() == text).ok_or_else(|| format!("one of {}", names.join(", ")))
}

/// Everything `check` found.
#[derive(serde::Serialize)]
struct Report {
    scene: String,
    samples_per_pixel: u32,
    images: Vec<ImageCase>,
    stages: Vec<(String, StageReport)>,
    equal: bool,
    #[serde(skip)]
    integrator_options: String,
}

pub fn run(args: &CheckArgs) -> Result<bool, CliError> {
    let Some(scene_args) = &args.scene else { return check_numerics::run(&args.numerics, args.json) };
    let phase = Phase::begin("reading the scene", args.quiet);
    let scene = scene_args.load()?;
    drop(phase);
    let primitives = scene.mesh.triangles.len() + scene.spheres.len();
    let world = |force: Force| scene_args.prepare(&scene, force, false);
    let geometry = |mode| Force { general: true, geometry: Some(mode) };
    let phase = Phase::begin("building trees and tables", args.quiet);
    let general = world(geometry(GeometryMode::Tree))?;
    let planned = world(Force::default())?;
    let mut worlds: Vec<(&str, &World)> = vec![("general", &general), ("specialised", &planned)];
    let brute = (primitives <= BRUTE_FORCE_CHECK_LIMIT).then_some(GeometryMode::Brute);
    let asked_for = scene_args.mode.filter(|&mode| Some(mode) != brute);
    let mut others = Vec::new();
    for mode in brute.into_iter().chain(asked_for) {
        others.push((mode.describe(), world(geometry(mode))?));
    }
    worlds.extend(others.iter().map(|(name, world)| (*name, world)));
    drop(phase);
    let phase = Phase::begin("comparing every value of every path", args.quiet);
    let mut stages = Vec::new();
    let all = Width::ALL;
    stages.push(("tree, widths".into(), compare_stages(&general, &general, &all, args.spp, args.inject_fault)));
    if primitives <= BRUTE_FORCE_LIMIT || args.inject_fault.is_none() {
        for (name, other) in &others {
            let report = compare_stages(&general, other, &[Width::Sixteen], args.spp, None);
            stages.push((format!("{name} against tree"), report));
        }
    }
    drop(phase);
    if let Some(stage) = args.inject_fault.filter(|_| stages.iter().all(|(_, s)| s.faults == 0)) {
        let stage = stage.name();
        return Err(CliError::Usage(format!(
            "--inject-fault {stage}: paths of this scene have no such value; take another"
        )));
    }
    let phase = Phase::begin("comparing images", args.quiet);
    let images = match args.inject_fault {
        // A fault lives in the recording kernels; images would not show it.
        Some(_) => Vec::new(),
        None => compare_images(&worlds, args.spp as u64, &all)?,
    };
    drop(phase);
    let equal = stages.iter().all(|(_, s)| s.first.is_none()) && images.iter().all(|c| c.difference.is_none());
    let integrator_options = scene.integrator.options();
    let report =
        Report { scene: scene.name.clone(), samples_per_pixel: args.spp, images, stages, equal, integrator_options };
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report).map_err(|e| CliError::Usage(e.to_string()))?);
    } else {
        print_report(&report, scene_args);
    }
    Ok(equal)
}

fn print_report(report: &Report, args: &SceneArgs) {
    for (name, stages) in &report.stages {
        println!(
            "{name}: {} values of {} samples, {} samples differ",
            stages.values, stages.samples, stages.differing_samples
        );
        if let Some(difference) = &stages.first {
            print_difference(difference, report, args);
        }
    }
    for case in &report.images {
        let verdict = match &case.difference {
            None => "equal".to_string(),
            Some(d) => format!(
                "DIFFERS first at pixel {},{} channel {}: {:016x}, expected {:016x}",
                d.x, d.y, d.channel, d.found_bits, d.expected_bits
            ),
        };
        println!(
            "image, {} kernel: {} lanes, {} threads, tile {}: {verdict}",
            case.world, case.lanes, case.threads, case.tile
        );
    }
    println!("{}", if report.equal { "all bits equal" } else { "bits differ" });
}

fn print_difference(d: &Difference, report: &Report, args: &SceneArgs) {
    let value = |bits: u32| format!("{bits:08x} ({})", f32::from_bits(bits));
    let found = d.found_bits.map_or("nothing: the path had ended".to_string(), value);
    println!(
        "  first: pixel {},{} sample {} bounce {} stage {} lane {} of {}: {found}, expected {}",
        d.x,
        d.y,
        d.sample,
        d.bounce,
        d.stage.name(),
        d.lane,
        d.lanes,
        value(d.expected_bits)
    );
    let size = args.size.map_or(String::new(), |s| format!(" --size {}x{}", s.width, s.height));
    let mode = args.mode.map_or(String::new(), |m| format!(" --mode {}", m.name()));
    let integrator = &report.integrator_options;
    println!(
        "  replay: octolux replay {} --bits --pixel {},{} --sample {} --seed {} --sampler {}{size}{integrator}{mode}",
        report.scene,
        d.x,
        d.y,
        d.sample,
        args.seed,
        args.sampler.name()
    );
}
