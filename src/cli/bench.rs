//! `octolux bench`: paths per second on a scene; `octolux bench rays`: rays per second on recorded rays.

use super::CliError;
use super::scene_args::{SceneArgs, parse_lanes};
use crate::kernel::{Width, World};
use crate::plan::Force;
use crate::report::bench::{SceneBench, bench_scene};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct BenchArgs {
    #[command(flatten)]
    scene: Option<SceneArgs>,
    /// Lane widths to measure, interleaved [default: the fastest of this build]
    #[arg(long, value_delimiter = ',', value_parser = parse_lanes)]
    lanes: Vec<Width>,
    /// Thread counts to measure; threads are pinned to cores
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// Windows of each setting; the median is reported
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..=1000))]
    windows: u16,
    /// Seconds a window lasts at least
    #[arg(long, default_value_t = 0.3)]
    seconds: f64,
    /// Measure the general kernel
    #[arg(long)]
    general: bool,
    /// Write JSON; `-` is standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

pub fn run(args: &BenchArgs) -> Result<bool, CliError> {
    let Some(scene_args) = &args.scene else {
        return Err(CliError::Usage("bench what? give a scene, or `bench rays DATA/NAME`".into()));
    };
    let (scene, world, _): (_, World, _) = scene_args.world(Force { general: args.general, geometry: None }, false)?;
    let lanes = if args.lanes.is_empty() { vec![Width::native()] } else { args.lanes.clone() };
    let bench = SceneBench { name: scene.name, lanes, threads: args.threads.clone(), windows: args.windows, seconds: args.seconds };
    let report = bench_scene(&world, &bench)?;
    match &args.json {
        None => print!("{report}"),
        Some(path) => {
            let text = serde_json::to_string_pretty(&report).map_err(|e| CliError::Usage(e.to_string()))? + "\n";
            if path.as_os_str() == "-" {
                print!("{text}");
            } else {
                std::fs::write(path, text).map_err(|source| CliError::Write { path: path.clone(), source })?;
            }
        }
    }
    Ok(true)
}
