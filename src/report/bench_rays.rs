//! `octolux bench rays`: ray throughput on files of rays and triangles that any tracer can be timed on.

mod files;
mod measure;

use crate::accel::{Accel, BuildOptions, BuildReport, Preset};
use crate::kernel::Width;
use files::{RaySet, Triangles};
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};

/// What to time.
#[derive(Clone, Debug, clap::Args)]
pub struct BenchRaysArgs {
    /// DATA/NAME: reads NAME.tri and NAME.{P,B1,B2,S,A}.rays
    pub data: PathBuf,
    /// Ray sets; those without a file are skipped
    #[arg(long, value_delimiter = ',', default_value = "P,B1,B2,S,A")]
    pub sets: Vec<String>,
    /// Widths: 1, 8, 16 [default: the one the kernel would use]
    #[arg(long, value_delimiter = ',')]
    pub lanes: Vec<usize>,
    /// Numbers of pinned threads
    #[arg(long, value_delimiter = ',', default_value = "1")]
    pub threads: Vec<usize>,
    /// auto (what the kernel would use), brute, single, packet, stream, shadow
    #[arg(long, value_delimiter = ',', default_value = "auto")]
    pub modes: Vec<TraceMode>,
    /// Timed passes over each set, after one that is not timed
    #[arg(long, default_value_t = 7)]
    pub windows: usize,
    /// Tree quality
    #[arg(long, default_value = "medium")]
    pub build: Preset,
}

impl BenchRaysArgs {
    /// All that may be read.
    pub fn files(&self) -> Vec<PathBuf> {
        let sets = self.sets.iter().map(|set| format!(".{set}.rays"));
        std::iter::once(".tri".to_owned()).chain(sets).map(|end| with_suffix(&self.data, &end)).collect()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum TraceMode {
    Auto,
    Brute,
    Single,
    Packet,
    Stream,
    Shadow,
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct BenchRaysReport {
    pub scene: String,
    pub triangles: usize,
    pub build: BuildReport,
    pub sets: Vec<SetReport>,
}

/// One set, width, mode and number of threads. Rates in 10⁶ rays/s: median, least and greatest window.
#[derive(Clone, Debug, Serialize)]
pub struct SetReport {
    pub set: String,
    pub threads: usize,
    pub lanes: usize,
    pub mode: TraceMode,
    pub mrays_per_s: f64,
    pub min: f64,
    pub max: f64,
    /// Per second of processor time: what a busy machine does not halve.
    pub mrays_per_cpu_s: f64,
    pub hits: usize,
    pub rays: usize,
    /// Of hits, in the file's units; 0 for any-hit sets.
    pub sum_t: f64,
}

#[derive(Debug, thiserror::Error)]
pub enum BenchRaysError {
    #[error("{}: cannot read: {source}; name DATA/NAME, of which NAME.tri is there", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: {what}; name recorded rays, or record them anew", path.display())]
    Format { path: PathBuf, what: String },
    #[error("--{option} {value}: {mend}")]
    Argument { option: &'static str, value: String, mend: &'static str },
}

/// Up to this many triangles brute force is what the kernel uses.
pub const BRUTE_LIMIT: usize = crate::plan::BRUTE_FORCE_LIMIT;

/// Reads, builds, measures.
pub fn bench_rays(args: &BenchRaysArgs) -> Result<BenchRaysReport, BenchRaysError> {
    check(args)?;
    let mut triangles = Triangles::read(&with_suffix(&args.data, ".tri"))?;
    let mut sets = Vec::new();
    for name in &args.sets {
        let path = with_suffix(&args.data, &format!(".{name}.rays"));
        if path.exists() {
            sets.push((name.clone(), RaySet::read(&path)?));
        } else {
            log::warn!("{}: not there, skipped", path.display());
        }
    }
    let largest = sets.iter().map(|s| s.1.largest()).fold(triangles.largest(), f32::max);
    if largest > 0.0 && largest < LEAST_SIZE {
        let what = format!("no coordinate, of rays neither, is as large as {LEAST_SIZE:e}: scale the scene");
        return Err(BenchRaysError::Format { path: with_suffix(&args.data, ".tri"), what });
    }
    let scale = power_of_two_to_unit(largest);
    triangles.rescale(scale);
    sets.iter_mut().for_each(|(_, rays)| rays.rescale(scale));
    let options = BuildOptions { lists: triangles.count() <= BRUTE_LIMIT * 64, trees: true, preset: args.build };
    let accel = Accel::build(&triangles.positions, &triangles.indices(), &[], options);
    let native = [Width::native().lanes()];
    let widths = if args.lanes.is_empty() { &native[..] } else { &args.lanes };
    let mut reports = Vec::new();
    for (name, rays) in &sets {
        for &mode in &args.modes {
            let mode = resolve(mode, triangles.count(), rays);
            if mode == TraceMode::Brute && !options.lists {
                log::warn!("brute force skipped: {} triangles", triangles.count());
                continue;
            }
            for &lanes in widths {
                for &threads in &args.threads {
                    reports.push(measure::measure(&accel, name, rays, mode, lanes, threads, args.windows, scale));
                }
            }
        }
    }
    let scene = args.data.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    Ok(BenchRaysReport { scene, triangles: triangles.count(), build: accel.report().clone(), sets: reports })
}

fn check(args: &BenchRaysArgs) -> Result<(), BenchRaysError> {
    let bad = |option, value: String, mend| Err(BenchRaysError::Argument { option, value, mend });
    if let Some(lanes) = args.lanes.iter().find(|n| ![1, 8, 16].contains(n)) {
        return bad("lanes", lanes.to_string(), "widths are 1, 8 and 16");
    }
    if let Some(threads) = args.threads.iter().find(|n| !(1..=1024).contains(*n)) {
        return bad("threads", threads.to_string(), "1 to 1024");
    }
    if !(1..=100_000).contains(&args.windows) {
        return bad("windows", args.windows.to_string(), "1 to 100000");
    }
    Ok(())
}

/// What the kernel does with such rays: see [`TreeTraversal`](crate::kernel::TreeTraversal).
fn resolve(mode: TraceMode, triangles: usize, rays: &RaySet) -> TraceMode {
    match mode {
        TraceMode::Auto if triangles <= BRUTE_LIMIT => TraceMode::Brute,
        TraceMode::Auto if rays.coherent && !rays.any => TraceMode::Packet,
        TraceMode::Auto if rays.any => TraceMode::Shadow,
        TraceMode::Auto => TraceMode::Stream,
        named => named,
    }
}

/// The power of two that brings `largest` into [1, 2); 1 for 0.
/// What scales the largest coordinate to 1 is to be an f32, and is not for all that are smaller.
const LEAST_SIZE: f32 = 1e-30;

fn power_of_two_to_unit(largest: f32) -> f32 {
    if largest == 0.0 { 1.0 } else { (2.0f64.powi(-(f64::from(largest).log2().floor() as i32))) as f32 }
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

impl fmt::Display for BenchRaysReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} triangles, built in {:.3} s", self.scene, self.triangles, self.build.seconds)?;
        writeln!(f, "set threads lanes    mode   Mrays/s (min–max)       hits /    rays        Σt")?;
        for s in &self.sets {
            let mode = format!("{:?}", s.mode).to_lowercase();
            writeln!(
                f,
                "{:3} {:7} {:5} {mode:>7}  {:8.2} ({:.2}–{:.2})  {:8} / {:7}  {:.6e}",
                s.set, s.threads, s.lanes, s.mrays_per_s, s.min, s.max, s.hits, s.rays, s.sum_t
            )?;
        }
        Ok(())
    }
}
