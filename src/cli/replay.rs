//! `octolux replay`: one sample of one pixel, computed again at width 1 and printed: as a path, or bit by bit.

use super::CliError;
use super::replay_text::describe;
use super::scene_args::SceneArgs;
use crate::check::record_tile;
use crate::kernel::{Job, REUSE_SIDE, Record, Stage, Width, World};
use crate::plan::Force;

#[derive(clap::Args)]
pub struct ReplayArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Column and row, from the top left
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pixel: (u32, u32),
    /// Index of the sample
    #[arg(long, default_value_t = 0)]
    sample: u32,
    /// Lanes that compute it: 1, 8 or 16
    #[arg(long, default_value = "1", value_parser = super::scene_args::parse_lanes)]
    lanes: Width,
    /// Print every value with its bit pattern instead: what `check` compares
    #[arg(long)]
    bits: bool,
}

pub fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| "write COLUMN,ROW, as in 120,64".to_string())
}

pub fn run(args: &ReplayArgs) -> Result<bool, CliError> {
    let (scene, world, _) = args.scene.world(Force::default(), false, true)?;
    let (x, y) = args.pixel;
    let film = world.film;
    if x >= film.width || y >= film.height {
        return Err(CliError::Usage(format!(
            "pixel {x},{y} is outside the image of {}x{}; columns and rows count from 0",
            film.width, film.height
        )));
    }
    let job = job_of(&world, x, y, args.sample);
    let recorder = record_tile(&world, &job, args.lanes, None);
    let slot = (y - job.y) * job.width + x - job.x;
    println!("pixel {x},{y} sample {} seed {} of {}", args.sample, world.seed, args.scene.scene.display());
    let records = recorder.records.get(slot as usize).map_or(&[][..], Vec::as_slice);
    if !args.bits {
        print!("{}", describe(records, &scene, world.unit));
        if world.plan.light_paths {
            println!("(an image also has what paths from the lights bring to this pixel)");
        }
        return Ok(true);
    }
    for vertex in records.chunk_by(|a, b| a.bounce == b.bounce) {
        println!("vertex {}", vertex[0].bounce);
        for stage in vertex.chunk_by(|a, b| a.stage == b.stage) {
            println!("  {:20} {}", stage[0].stage.name(), stage.iter().map(value).collect::<Vec<_>>().join("  "));
        }
    }
    Ok(true)
}

/// The pixel, with those that share its paths.
fn job_of(world: &World, x: u32, y: u32, first_sample: u32) -> Job {
    let film = world.film;
    let side = if world.plan.path_reuse { REUSE_SIDE } else { 1 };
    let (x, y) = (x / side * side, y / side * side);
    Job { x, y, width: side.min(film.width - x), height: side.min(film.height - y), first_sample, samples: 1 }
}

/// The value and its bits; a primitive's number, not the float of the same bits.
fn value(record: &Record) -> String {
    match record.stage {
        Stage::HitPrimitive if record.bits == crate::geometry::MISS => "miss".to_string(),
        Stage::HitPrimitive => format!("{}", record.bits),
        _ => format!("{} [{:08x}]", f32::from_bits(record.bits), record.bits),
    }
}
