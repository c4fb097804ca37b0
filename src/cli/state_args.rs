//! Options about state files, and the film a render begins with.

use super::CliError;
use crate::film::{BLOCK, Film};
use crate::kernel::{Counters, World};
use crate::render::budget::MAX_SAMPLES;
use crate::render::state::{Head, Origin, SAMPLING};
use crate::render::{self, Options, State, StoppedBy};
use crate::scene::Scene;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Seconds from one state to the next, if nothing is said.
const SAVE_EVERY: f64 = 30.0;

#[derive(clap::Args, Clone)]
pub struct StateArgs {
    /// Keep the render's state in this file, to go on with it (--resume) or to merge it (`octolux merge`)
    #[arg(long, value_name = "FILE.state")]
    state: Option<PathBuf>,
    /// Go on with this state, which is kept in the same file unless --state names another
    #[arg(long, value_name = "FILE.state")]
    resume: Option<PathBuf>,
    /// Render samples A to B − 1 of each pixel, for merging: A is a multiple of 64, and so is B but in the last part
    #[arg(long, value_name = "A..B", value_parser = parse_samples, conflicts_with_all = ["spp", "resume"])]
    samples: Option<Range<u64>>,
    /// With --state or --resume: also save after this many seconds, again and again [default: 30]
    #[arg(long, value_name = "SECONDS", value_parser = super::render::positive)]
    save_every: Option<f64>,
}

fn parse_samples(text: &str) -> Result<Range<u64>, String> {
    let range = text.split_once("..").and_then(|(a, b)| Some(a.trim().parse().ok()?..b.trim().parse().ok()?));
    let range: Range<u64> = range.ok_or("write A..B, as in 64..128")?;
    if !range.start.is_multiple_of(BLOCK) {
        return Err(format!("starts at {}: start at a multiple of {BLOCK}", range.start));
    }
    if range.end > MAX_SAMPLES {
        return Err(format!("a pixel has the samples 0 to {}: let B be {MAX_SAMPLES} at most", MAX_SAMPLES - 1));
    }
    if range.is_empty() {
        return Err("holds no samples: let A be less than B".to_string());
    }
    Ok(range)
}

impl StateArgs {
    /// The file that the state is kept in.
    pub fn file(&self) -> Option<&Path> {
        self.state.as_deref().or(self.resume.as_deref())
    }

    /// The state that is gone on with, where it is not the file that is kept.
    pub fn left_behind(&self) -> Option<&Path> {
        self.state.as_ref().filter(|state| self.resume.as_ref() != Some(state)).and(self.resume.as_deref())
    }

    pub fn save_every(&self) -> Duration {
        Duration::try_from_secs_f64(self.save_every.unwrap_or(SAVE_EVERY)).unwrap_or(Duration::MAX)
    }

    /// Samples a pixel that --samples asks for.
    pub fn count(&self) -> Option<u64> {
        self.samples.as_ref().map(|range| range.end - range.start)
    }

    pub fn resumes(&self) -> bool {
        self.resume.is_some()
    }

    /// That there is a state to save often; one that is there already is nobody's to overwrite but the one's who resumes it.
    pub fn check(&self) -> Result<(), CliError> {
        if self.save_every.is_some() && self.file().is_none() {
            return Err(CliError::Usage("--save-every: there is no state to save; give --state FILE.state".into()));
        }
        match &self.state {
            Some(path) if path.is_file() && self.resume.as_ref() != Some(path) => {
                let path = path.display();
                Err(CliError::Usage(format!("{path}: exists; go on with it by --resume {path}, or remove it")))
            }
            _ => Ok(()),
        }
    }

    /// The film to begin with and what its state file will say.
    pub fn begin(&self, scene: &Scene, world: &World, options: &Options) -> Result<(Head, Film), CliError> {
        let origin = Origin {
            version: env!("CARGO_PKG_VERSION").to_string(),
            // Hashing a large scene takes a moment that only a state is worth.
            fingerprint: self.file().map_or(String::new(), |_| format!("{:016x}", scene.fingerprint())),
            seed: world.seed,
            sampler: world.sampler,
            width: world.film.width,
            height: world.film.height,
            aovs: options.aovs,
            posterior: options.aovs && world.plan.posterior,
            shares_points: world.integrator.shares_points(),
            light_paths: world.light_paths.is_some(),
            light_paths_everywhere: world.light_paths.is_none_or(|paths| paths.everywhere),
            path_reuse: world.plan.path_reuse,
            roulette: world.integrator.roulette.to_string(),
            sampling: SAMPLING,
        };
        if let Some(path) = &self.resume {
            let State { head, film } = State::load(path)?;
            origin.admit(&head.origin, path)?;
            return Ok((Head { scene: scene.name.clone(), ..head }, film));
        }
        let film = render::empty_film(world, options, self.samples.as_ref().map_or(0, |range| range.start / BLOCK));
        let head = Head {
            origin,
            scene: scene.name.clone(),
            tile: film.tile_side(),
            samples: 0,
            stopped_by: StoppedBy::Samples,
            render_seconds: 0.0,
            rays: Counters::default(),
        };
        Ok((head, film))
    }
}
