//! Renders the scenes of `../shared/refs` and holds them against their converged images by an independent renderer.
//!
//! `cargo run --release --example references -- [SCENE …] [--spp N] [--seeds K] [--json FILE|-]`
//!
//! A row: mean over seeds of relMSE − floor, C = that times the samples of one render beside the C that an independent
//! sampler of that renderer has, and the ratio of image means. Verdicts: |ratio − 1| within Šidák's bound (family-wise
//! 1 % over all rows and channels) of the combined standard errors, `env` within 0.3 %; relMSE − floor ≤ 3·C/N. Exit
//! code 1 if a verdict fails.

mod measure;

use clap::Parser;
use measure::{Measured, Settings, measure};
use octolux::report::sidak::sidak_bound;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// A reference scene, and the C of independent sampling in `refs/README.md` where it gives one.
const SCENES: [(&str, Option<f64>); 11] = [
    ("cornell", Some(0.273)),
    ("cornell_direct", Some(0.023)),
    ("veach_mis", Some(0.438)),
    ("env", Some(0.298)),
    ("glass", Some(2.65)),
    ("many_lights", Some(17.9)),
    ("door_ajar", Some(24.9)),
    ("furnace_diffuse05", None),
    ("furnace_ggx_a0.2", None),
    ("furnace_ggx_a1", None),
    ("furnace_rglass_a0.5", None),
];
/// The reference's environment rows lie elsewhere, which brightens it by up to 0.22 % (`refs/README.md`).
const ENV_TOLERANCE: f64 = 0.003;
/// How much worse than the table's C is accepted.
const C_MARGIN: f64 = 3.0;

#[derive(Parser)]
#[command(about = "Holds renders against the reference images")]
struct Args {
    /// Scenes to render [default: all]
    scenes: Vec<String>,
    /// Samples per pixel of each render
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u64).range(2..))]
    spp: u64,
    /// Renders of each scene, with seeds 0, 1, 2 …
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Worker threads [default: one a core]
    #[arg(long)]
    threads: Option<usize>,
    /// Write JSON too; `-` is standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

/// One line of the table.
#[derive(serde::Serialize)]
struct Row {
    #[serde(flatten)]
    measured: Measured,
    c_reference: Option<f64>,
    /// Allowed |mean ratio − 1| of each channel.
    mean_tolerance: [f64; 3],
    mean_ok: bool,
    error_ok: bool,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let args = Args::parse();
    let Some(folder) = references_folder() else {
        eprintln!("skipped: no shared/refs beside this crate or up to two levels higher");
        return Ok(ExitCode::SUCCESS);
    };
    let chosen: Vec<_> =
        SCENES.iter().filter(|(name, _)| args.scenes.is_empty() || args.scenes.iter().any(|s| s == name)).collect();
    let threads = args.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()));
    let settings = Settings { samples: args.spp, seeds: args.seeds, pool: octolux::render::thread_pool(threads)? };
    let bound = sidak_bound(3 * chosen.len() as u64);
    eprintln!("{} renders of {} samples each, {threads} threads, |z| allowed {bound:.3}", args.seeds, args.spp);
    print_header();
    let mut rows = Vec::new();
    for &&(name, c_reference) in &chosen {
        let row = judge(measure(&folder, name, &settings)?, c_reference, bound);
        print_row(&row);
        rows.push(row);
    }
    write_json(&rows, args.json.as_deref())?;
    let all_ok = rows.iter().all(|row| row.mean_ok && row.error_ok);
    Ok(if all_ok { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// `shared/refs` beside the crate, or higher for work trees.
fn references_folder() -> Option<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().skip(1).take(3).map(|d| d.join("shared/refs")).find(|d| d.is_dir())
}

fn judge(measured: Measured, c_reference: Option<f64>, bound: f64) -> Row {
    let env = measured.scene == "env";
    let mean_tolerance = measured.mean_ratio_error.map(|e| if env { ENV_TOLERANCE } else { bound * e });
    let mean_ok = (0..3).all(|c| (measured.mean_ratio[c] - 1.0).abs() <= mean_tolerance[c]);
    let error_ok = c_reference.is_none_or(|c| measured.c <= C_MARGIN * c);
    Row { measured, c_reference, mean_tolerance, mean_ok, error_ok }
}

fn print_header() {
    println!(
        "{:20} {:>9} {:>8} {:>10} {:>9} {:>8} {:>7} {:>9}  mean ratio R G B, each ± its standard error",
        "scene", "samples", "seconds", "relMSE-fl", "floor", "C", "C ref", "verdict"
    );
}

fn print_row(row: &Row) {
    let m = &row.measured;
    let verdict = match (row.mean_ok, row.error_ok) {
        (true, true) => "ok",
        (false, true) => "MEAN",
        (true, false) => "ERROR",
        (false, false) => "BOTH",
    };
    let ratios: Vec<String> =
        (0..3).map(|c| format!("{:.6} ± {:.6}", m.mean_ratio[c], m.mean_ratio_error[c])).collect();
    println!(
        "{:20} {:>9} {:>8.2} {:>10.3e} {:>9.2e} {:>8.3} {:>7} {:>9}  {}{}",
        m.scene,
        format!("{}x{}", m.seeds, m.samples_per_pixel),
        m.seconds,
        m.relmse_minus_floor,
        m.floor,
        m.c,
        row.c_reference.map_or("-".to_string(), |c| c.to_string()),
        verdict,
        ratios.join("  "),
        if m.discarded > 0 { format!("  {} samples discarded", m.discarded) } else { String::new() }
    );
}

fn write_json(rows: &[Row], path: Option<&Path>) -> Result<(), Box<dyn Error>> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(rows)? + "\n";
    if path.as_os_str() == "-" {
        print!("{text}");
    } else {
        std::fs::write(path, text)?;
    }
    Ok(())
}
