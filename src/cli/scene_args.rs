//! What every command that loads a scene understands, and the way from a path to a prepared world.

use super::CliError;
use crate::accel::Preset;
use crate::kernel::{Prepare, Width, World};
use crate::plan::{Force, GeometryMode, Plan};
use crate::render::{self, Phase, Times};
use crate::sampling::SamplerKind;
use crate::scene::{FilmSize, LightPaths, PathReuse, Roulette, Scene};
use std::path::PathBuf;
use std::time::Instant;

#[derive(clap::Args, Clone)]
pub struct SceneArgs {
    /// scene.toml, or a bare model.obj
    pub scene: PathBuf,
    /// Image size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<FilmSize>,
    /// Seed of every random number
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// How samples relate: even over a pixel and a block of pixels (scrambled Sobol' points), or independent
    #[arg(long, value_enum, default_value_t = SamplerKind::Sobol)]
    pub sampler: SamplerKind,
    /// Trace paths from the lights, too [default: as the scene says, else auto: where the plan finds that they pay]
    #[arg(long, value_enum)]
    pub light_paths: Option<LightPaths>,
    /// Let pixels of a block share what their paths find after the first bounce: less noise, but the same within a block
    /// [default: as the scene says, else auto: where the plan finds that they can]
    #[arg(long, value_enum)]
    pub path_reuse: Option<PathReuse>,
    /// Russian roulette from scattering event AFTER on, for paths that carry less than BELOW of what they started with
    /// [default: as the scene says, else 2,0.25; many renderers: 5,1]
    #[arg(long, value_name = "AFTER,BELOW")]
    pub roulette: Option<Roulette>,
    /// Tree quality
    #[arg(long, value_enum, default_value_t = Preset::Medium)]
    pub build: Preset,
    /// How all rays find geometry, to compare: the same bits [default: as the plan decides, see `octolux info`]
    #[arg(long, value_enum)]
    pub mode: Option<GeometryMode>,
}

/// Lane width and threads.
#[derive(clap::Args, Clone)]
pub struct MachineArgs {
    /// Lanes: 1, 8 or 16 [default: the fastest of this build]
    #[arg(long, value_parser = parse_lanes)]
    pub lanes: Option<Width>,
    /// Worker threads [default: one a core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Side of a tile in pixels [default: 16, or 32 for images past 512 pixels]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=512))]
    pub tile: Option<u32>,
}

impl MachineArgs {
    pub fn width(&self) -> Width {
        self.lanes.unwrap_or(Width::native())
    }
    pub fn threads(&self) -> usize {
        self.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()), usize::from)
    }
    pub fn tile(&self, film: FilmSize) -> u32 {
        self.tile.unwrap_or_else(|| render::default_tile(film.width, film.height))
    }
}

impl SceneArgs {
    pub fn load(&self) -> Result<Scene, CliError> {
        let mut scene = crate::scene::load(&self.scene)?;
        if let Some(size) = self.size {
            scene.film = size;
        }
        if let Some(light_paths) = self.light_paths {
            scene.integrator.light_paths = light_paths;
        }
        if let Some(path_reuse) = self.path_reuse {
            scene.integrator.path_reuse = path_reuse;
        }
        if let Some(roulette) = self.roulette {
            scene.integrator.roulette = roulette;
        }
        Ok(scene)
    }

    /// Loads, plans and prepares, and says so where that takes long and is not `quiet`.
    pub fn world(&self, force: Force, albedo: bool, quiet: bool) -> Result<(Scene, World, Times), CliError> {
        let start = Instant::now();
        let phase = Phase::begin("reading the scene", quiet);
        let scene = self.load()?;
        let load = start.elapsed().as_secs_f64();
        drop(phase);
        let start = Instant::now();
        let _phase = Phase::begin("building the tree and tables", quiet);
        let world = self.prepare(&scene, force, albedo)?;
        Ok((scene, world, Times { load, setup: start.elapsed().as_secs_f64(), pilot: 0.0 }))
    }

    pub fn prepare(&self, scene: &Scene, force: Force, albedo: bool) -> Result<World, CliError> {
        self.prepare_plan(scene, Plan::new(scene, self.force(force), albedo))
    }

    /// With the way to find geometry that is asked for, where `force` leaves that open.
    pub fn force(&self, force: Force) -> Force {
        Force { geometry: force.geometry.or(self.mode), ..force }
    }

    pub fn prepare_plan(&self, scene: &Scene, plan: Plan) -> Result<World, CliError> {
        if let Some(why) = plan.geometry.refusal(scene) {
            return Err(CliError::Usage(why));
        }
        let options = Prepare { seed: self.seed, sampler: self.sampler, build: self.build };
        Ok(World::new(scene, plan, options)?)
    }
}

pub fn parse_size(text: &str) -> Result<FilmSize, String> {
    let side = |s: &str| s.parse().ok();
    text.split_once('x')
        .and_then(|(w, h)| Some(FilmSize { width: side(w)?, height: side(h)? }))
        .filter(|size| size.is_possible())
        .ok_or_else(|| {
            let (longest, most) = (FilmSize::LONGEST_SIDE, FilmSize::MOST_PIXELS);
            format!("write WIDTHxHEIGHT, each 1 to {longest} and at most {most} pixels in all, as in 640x480")
        })
}

pub fn parse_lanes(text: &str) -> Result<Width, String> {
    text.parse().ok().and_then(Width::from_lanes).ok_or_else(|| "there are kernels of 1, 8 and 16 lanes".to_string())
}
