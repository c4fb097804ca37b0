//! The course's figures and pictures, with tables of their errors.
//!
//! `cargo run --release --example course -- figures|stages|methods|lobes|calibration [-o FOLDER] [--scene SCENE.toml] [--size N]`
//!
//! `figures`: mean |error| against n, 20 to 100, as SVG (P2 Monte Carlo, P3 Bayesian, P4 importance). `stages`: the
//! Bayesian renders of the course from one point set for the whole picture to points of each hit's own. `methods`: the four
//! methods at 40 directions an estimate side by side, and `path` of one bounce in the same time. `lobes`: the sphere in a
//! Phong material and in a rough metal, directions about the normal against directions of the lobe. `calibration`: how
//! often the truth lies inside the intervals of the posterior.

mod calibration;
mod figures;
mod renders;

use clap::{Parser, ValueEnum};
use std::error::Error;
use std::path::PathBuf;

#[derive(Parser)]
#[command(about = "The course's figures and pictures")]
struct Args {
    what: What,
    /// Where files go
    #[arg(short, long, default_value = "course")]
    output: PathBuf,
    /// Its environment, camera and materials
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/course/scene.toml"))]
    scene: PathBuf,
    /// Side of the pictures in pixels
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u32).range(8..=4096))]
    size: u32,
    /// Samples of the reference, `direct` with another seed
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u64).range(2..))]
    reference: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum What {
    Figures,
    Stages,
    Methods,
    Lobes,
    Calibration,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    std::fs::create_dir_all(&args.output)?;
    let mut scene = octolux::scene::load(&args.scene)?;
    scene.film = octolux::scene::FilmSize { width: args.size, height: args.size };
    match args.what {
        What::Figures => figures::write(&scene, &args.output),
        What::Stages => renders::stages(&scene, args.reference, &args.output),
        What::Methods => renders::methods(&scene, args.reference, &args.output),
        What::Lobes => renders::lobes(&scene, args.reference, &args.output),
        What::Calibration => calibration::print(&scene),
    }
}
