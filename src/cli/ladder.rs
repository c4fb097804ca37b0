//! `octolux render --ladder 1,2,4,…`: the same image at more and more samples a pixel, on one labelled sheet.

use super::CliError;
use super::targets::ImageArgs;
use crate::film::png::srgb8;
use crate::film::{ExrImage, Film, FilmChannels, read_exr};
use crate::kernel::World;
use crate::render::{self, Budget, Options, Outcome, Progress, StoppedBy};
use crate::report::contact_sheet::{Sheet, Tile};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Clone)]
pub struct LadderArgs {
    /// Make the PNG a sheet of the image at each of these samples per pixel, the error under each
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', requires = "png",
        value_parser = clap::value_parser!(u64).range(1..=render::budget::MAX_SAMPLES),
        conflicts_with_all = ["spp", "time", "error", "unbiased", "samples", "state", "resume"])]
    ladder: Vec<u64>,
    /// With --ladder: measure the error against this image
    #[arg(long, value_name = "REF.exr", requires = "ladder")]
    reference: Option<PathBuf>,
}

/// One rung: what the film held at so many samples.
struct Rung {
    samples: u64,
    pixels: Vec<[u8; 3]>,
    /// mean((a − b)²/(b² + 0.01)) against the reference.
    measured: Option<f64>,
}

impl LadderArgs {
    pub fn is_asked_for(&self) -> bool {
        !self.ladder.is_empty()
    }

    /// What is rendered in all; nothing without a ladder.
    pub fn budget(&self) -> Option<Budget> {
        let samples = self.ladder.iter().max().copied();
        samples.map(|_| Budget { samples, ..Budget::default() })
    }

    /// The image that errors are measured against.
    pub fn reference_file(&self) -> Option<&Path> {
        self.reference.as_deref()
    }

    /// Looks at the reference before anything is rendered.
    pub fn check(&self, world: &World) -> Result<(), CliError> {
        // Clap does not look where what --reference requires is forbidden by another option.
        if self.reference.is_some() && !self.is_asked_for() {
            return Err(CliError::Usage("--reference is of --ladder; give that, too, or leave it out".into()));
        }
        self.reference(world).map(drop)
    }

    fn reference(&self, world: &World) -> Result<Option<ExrImage>, CliError> {
        let Some(path) = &self.reference else { return Ok(None) };
        let image = read_exr(path)?;
        image.check_reference().map_err(|why| CliError::Usage(format!("{}: {why}", path.display())))?;
        let (w, h) = (world.film.width, world.film.height);
        if (image.width, image.height) == (w, h) {
            return Ok(Some(image));
        }
        let (path, width, height) = (path.display(), image.width, image.height);
        Err(CliError::Usage(format!("{path}: is {width}x{height}, the render {w}x{h}; give --size {width}x{height}")))
    }

    /// Renders from rung to rung, and writes the sheet. The outcome is the last rung's.
    pub fn run(
        &self,
        world: &World,
        options: &Options,
        pool: &rayon::ThreadPool,
        progress: &mut Progress,
        images: &ImageArgs,
    ) -> Result<Outcome, CliError> {
        let reference = self.reference(world)?;
        let mut steps = self.ladder.clone();
        steps.sort_unstable();
        steps.dedup();
        let mut rungs = Vec::new();
        let mut whole: Option<Outcome> = None;
        for samples in steps {
            let film = match &mut whole {
                Some(outcome) => std::mem::replace(&mut outcome.film, Film::new(0, 0, 1, FilmChannels::Colour, 0)),
                None => render::empty_film(world, options, 0),
            };
            let options = Options { budget: Budget { samples: Some(samples), ..Budget::default() }, ..*options };
            let mut outcome = render::render_on(film, world, &options, pool, progress, &mut ());
            let complete = outcome.stopped_by == StoppedBy::Samples;
            if complete {
                let measured = reference.as_ref().map(|reference| relmse(&outcome.film, reference));
                let pixels = pool.install(|| pixels(&outcome.film, images.exposure));
                rungs.push(Rung { samples, pixels, measured });
            }
            if let Some(before) = &whole {
                outcome.counters.add(&before.counters);
                outcome.render_seconds += before.render_seconds;
            }
            whole = Some(outcome);
            if !complete {
                break;
            }
        }
        // Clap lets no empty ladder through.
        let outcome = whole.ok_or_else(|| CliError::Usage("the ladder has no rungs; give --ladder 1,2,4".into()))?;
        match &images.png {
            Some(path) if !rungs.is_empty() => write(rungs, &outcome.film, path, pool)?,
            // Not one rung is whole, and there is no other image to keep what was rendered.
            _ if images.output.is_none() => return Err(CliError::InterruptedLadder),
            _ => {}
        }
        Ok(outcome)
    }
}

/// Labels and writes. Without a reference the error at n samples is what the variance at the last rung's N makes it:
/// N/n · mean(var_N/(mean_N² + 0.01)); an estimate from few samples would misjudge both.
fn write(rungs: Vec<Rung>, film: &Film, path: &Path, pool: &rayon::ThreadPool) -> Result<(), CliError> {
    let last = film.samples() as f64;
    let at_last = pool.install(|| film.relative_error()).map(|error| error * error);
    let label = |rung: &Rung| {
        let error = match (rung.measured, at_last) {
            (Some(error), _) => format!("relMSE {error:.2e}"),
            (None, Some(error)) => format!("expected relMSE {:.2e}", error * last / rung.samples as f64),
            (None, None) => "no variance, no relMSE".to_string(),
        };
        vec![format!("{} spp", rung.samples), error]
    };
    let tiles: Vec<Tile> = rungs.into_iter().map(|rung| Tile { label: label(&rung), pixels: rung.pixels }).collect();
    Ok(pool.install(|| Sheet::new(&tiles, (film.width(), film.height())).write(path))?)
}

fn pixels(film: &Film, exposure: f32) -> Vec<[u8; 3]> {
    let factor = f64::from(exposure).exp2();
    let row = |y| (0..film.width()).map(move |x| film.mean(x, y).map(|value| srgb8(value * factor)));
    (0..film.height()).into_par_iter().flat_map_iter(row).collect()
}

/// mean((a − b)²/(b² + 0.01)), the film's means rounded to f32 as its file would have them.
fn relmse(film: &Film, reference: &ExrImage) -> f64 {
    let planes = reference.rgb();
    let (width, height) = (film.width() as usize, film.height() as usize);
    let mut sum = 0.0;
    for (i, (x, y)) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).enumerate() {
        let mean = film.mean(x as u32, y as u32);
        for (c, plane) in planes.iter().enumerate() {
            let (a, b) = (f64::from(mean[c] as f32), f64::from(plane[i]));
            sum += (a - b) * (a - b) / (b * b + 0.01);
        }
    }
    sum / (3 * width * height).max(1) as f64
}
