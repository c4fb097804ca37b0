//! `octolux bench`: paths per second on a scene; `octolux bench rays`: rays per second on recorded rays.

use super::CliError;
use super::scene_args::{SceneArgs, parse_lanes};
use super::targets::{check_apart, check_folders};
use crate::film::beside::write_beside;
use crate::kernel::{Width, World};
use crate::plan::{Feature, Force, GeometryMode, Plan};
use crate::render::Phase;
use crate::report::ablation::{AblationBench, bench_ablations};
use crate::report::bench::{SceneBench, bench_scene};
use crate::report::bench_rays::{BenchRaysArgs, bench_rays};
use std::path::{Path, PathBuf};

/// Past this many primitives an ablation does not try brute force.
const MOST_FOR_BRUTE_FORCE: usize = 2000;

#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct BenchArgs {
    #[command(subcommand)]
    what: Option<BenchWhat>,
    #[command(flatten)]
    scene: Option<SceneArgs>,
    /// Lane widths to measure, interleaved [default: the fastest of this build]
    #[arg(long, value_delimiter = ',', value_parser = parse_lanes)]
    lanes: Vec<Width>,
    /// Thread counts to measure; threads are pinned to cores
    #[arg(long, value_delimiter = ',', default_value = "1,2", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Vec<u16>,
    /// Windows of each setting; the median is reported
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..=1000))]
    windows: u16,
    /// Seconds a window lasts at least
    #[arg(long, default_value_t = 0.3, value_parser = window_seconds)]
    seconds: f64,
    /// Measure the general kernel
    #[arg(long)]
    general: bool,
    /// Put each stage that this scene's plan leaves out back in, and take each other way to find geometry, one at a time:
    /// what it costs, and whether the bits stay (at the first of --lanes and --threads)
    #[arg(long, conflicts_with = "general")]
    ablate: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
    /// Write JSON; `-` is standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

fn window_seconds(text: &str) -> Result<f64, String> {
    super::render::positive(text)
        .ok()
        .filter(|&s| s <= 3600.0)
        .ok_or_else(|| "must be above 0, and an hour at most".into())
}

#[derive(clap::Subcommand)]
enum BenchWhat {
    /// Rays per second on the .tri and .rays files of DATA/NAME
    Rays {
        #[command(flatten)]
        args: BenchRaysArgs,
        /// Write JSON; `-` is standard output
        #[arg(long, value_name = "FILE|-")]
        json: Option<PathBuf>,
    },
}

pub fn run(args: &BenchArgs) -> Result<bool, CliError> {
    if let Some(BenchWhat::Rays { args, json }) = &args.what {
        check_report(json.as_deref(), args.files().iter().map(PathBuf::as_path))?;
        print_report(&bench_rays(args)?, json.as_deref())?;
        return Ok(true);
    }
    let Some(scene_args) = &args.scene else {
        return Err(CliError::Usage("bench what? give a scene, or `bench rays DATA/NAME`".into()));
    };
    if args.ablate {
        return ablate(args, scene_args);
    }
    let force = Force { general: args.general, geometry: None };
    let (scene, world, _): (_, World, _) = scene_args.world(force, false, args.quiet)?;
    check_report(args.json.as_deref(), scene.files.iter().map(PathBuf::as_path))?;
    let _phase = Phase::begin("measuring", args.quiet);
    let lanes = if args.lanes.is_empty() { vec![Width::native()] } else { args.lanes.clone() };
    let bench = SceneBench {
        name: scene.name,
        lanes,
        threads: args.threads.iter().map(|&n| n.into()).collect(),
        windows: args.windows,
        seconds: args.seconds,
    };
    let report = bench_scene(&world, &bench)?;
    print_report(&report, args.json.as_deref())?;
    Ok(true)
}

/// Before anything is measured: the report can be written, and not over what is read.
fn check_report<'a>(json: Option<&'a Path>, read: impl IntoIterator<Item = &'a Path>) -> Result<(), CliError> {
    let json = json.filter(|path| *path != Path::new("-"));
    check_folders(json)?;
    check_apart(json, read)
}

/// Every world that differs from the planned one in one decision, against it.
fn ablate(args: &BenchArgs, scene_args: &SceneArgs) -> Result<bool, CliError> {
    let phase = Phase::begin("reading the scene", args.quiet);
    let scene = scene_args.load()?;
    check_report(args.json.as_deref(), scene.files.iter().map(PathBuf::as_path))?;
    drop(phase);
    let phase = Phase::begin("building trees and tables", args.quiet);
    let prepare = |plan| scene_args.prepare_plan(&scene, plan);
    let force = scene_args.force(Force::default());
    let planned = prepare(Plan::new(&scene, force, false))?;
    let mut others = Vec::new();
    for feature in Feature::ALL.into_iter().filter(|&feature| !planned.plan.keeps(feature)) {
        let plan = Plan::keeping(Some(feature), &scene, force, false);
        if plan.keeps(feature) {
            others.push((feature.name().to_string(), prepare(plan)?));
        }
    }
    let primitives = scene.mesh.triangles.len() + scene.spheres.len();
    let possible = |mode: &GeometryMode| mode.has_tree() || primitives <= MOST_FOR_BRUTE_FORCE;
    for mode in GeometryMode::ALL.into_iter().filter(possible).filter(|&mode| mode != planned.plan.geometry) {
        let force = Force { geometry: Some(mode), ..force };
        others.push((mode.describe().to_string(), prepare(Plan::new(&scene, force, false))?));
    }
    others.push(("everything (--general)".into(), {
        prepare(Plan::new(&scene, Force { general: true, ..force }, false))?
    }));
    drop(phase);
    let phase = Phase::begin("measuring", args.quiet);
    let bench = AblationBench {
        name: scene.name.clone(),
        lanes: args.lanes.first().copied().unwrap_or(Width::native()),
        threads: args.threads.first().map_or(1, |&n| n.into()),
        windows: args.windows,
        seconds: args.seconds,
    };
    let report = bench_ablations(&planned, &others, &bench)?;
    drop(phase);
    print_report(&report, args.json.as_deref())?;
    Ok(report.rows.iter().all(|row| row.same_bits))
}

/// For a person, or as JSON to a file or standard output.
fn print_report(report: &(impl serde::Serialize + std::fmt::Display), json: Option<&Path>) -> Result<(), CliError> {
    let Some(path) = json else {
        print!("{report}");
        return Ok(());
    };
    let text = serde_json::to_string_pretty(report).map_err(|e| CliError::Usage(e.to_string()))? + "\n";
    if path.as_os_str() == "-" {
        print!("{text}");
        return Ok(());
    }
    Ok(write_beside(path, |file| std::io::Write::write_all(file, text.as_bytes()))?)
}
