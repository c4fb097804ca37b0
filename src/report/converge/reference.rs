//! What images are held against, and how much noise of its own it brings.

use super::ConvergeError;
use super::run::Variant;
use super::statistics::relative;
use crate::film::exr_write::write_rows;
use crate::film::{Attribute, VarianceValidity, beside::write_beside, read_exr};
use crate::render::interrupt;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Independent renders that a made reference is the mean of: their spread is its noise, whatever the sampler.
const REPLICATES: u64 = 4;
/// Sets the reference's seeds apart from all cells'.
const REFERENCE_SEED: u64 = 0x7265_6665_7265_6e63;

/// What the reference's own noise adds to mean squared errors against it: E mean w (r − E r)².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    pub mse: f64,
    pub relmse: f64,
}

/// Where [`Noise`] is known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NoiseSource {
    /// `NAME.json` beside `NAME.exr`.
    Sidecar,
    /// The image's variance layer.
    Variance,
    /// The spread of independent renders, made for this study.
    Replicates,
    /// It is not: errors include it.
    Unknown,
}

pub struct Reference {
    pub path: PathBuf,
    pub width: u32,
    pub height: u32,
    pub planes: [Vec<f32>; 3],
    pub noise: Noise,
    pub noise_source: NoiseSource,
    pub samples_per_pixel: Option<u64>,
}

/// The part of `NAME.json` that is read; also what is written beside a made reference.
#[derive(Serialize, Deserialize)]
struct Sidecar {
    relmse_floor: f64,
    rmse_floor: f64,
    spp: Option<u64>,
    /// Of the scene that a made reference shows.
    #[serde(default)]
    fingerprint: Option<String>,
}

impl Reference {
    pub fn rgb(&self) -> [&[f32]; 3] {
        self.planes.each_ref().map(Vec::as_slice)
    }

    /// Reads an EXR, and its noise from `NAME.json` beside it or from its variance layer.
    ///
    /// # Errors
    /// It cannot be read, has another size, or the file beside it is not what it should be.
    pub fn load(path: &Path, (width, height): (u32, u32)) -> Result<Self, ConvergeError> {
        let image = read_exr(path)?;
        let fail = |why: String| ConvergeError::Reference { file: path.display().to_string(), why };
        if (image.width, image.height) != (width, height) {
            let size = format!("{}x{} pixels, but the scene renders {width}x{height}", image.width, image.height);
            return Err(fail(size + "; give the size by `-- --size`, or another reference"));
        }
        image.check_reference().map_err(fail)?;
        let sidecar = read_sidecar(&path.with_extension("json"))?;
        let planes = image.rgb().map(<[f32]>::to_vec);
        let valid = image.variance_validity() == Some(VarianceValidity::Independent);
        let variance = image.variance().filter(|_| valid && sidecar.is_none());
        if variance.is_some_and(|planes| planes.into_iter().flatten().any(|v| !v.is_finite() || *v < 0.0)) {
            let why = "its variance layer is negative or not finite in places; render it anew, or take the layer out";
            return Err(fail(why.to_owned()));
        }
        let (noise, noise_source) = match (&sidecar, variance) {
            (Some(s), _) => (Noise { mse: s.rmse_floor * s.rmse_floor, relmse: s.relmse_floor }, NoiseSource::Sidecar),
            (None, Some(variance)) => (mean_noise(&planes, variance), NoiseSource::Variance),
            (None, None) => (Noise { mse: 0.0, relmse: 0.0 }, NoiseSource::Unknown),
        };
        let samples = image.attribute("samples").and_then(|a| a.to_string().parse().ok());
        let samples_per_pixel = sidecar.and_then(|s| s.spp).or(samples);
        Ok(Reference { path: path.to_owned(), width, height, planes, noise, noise_source, samples_per_pixel })
    }

    /// What [`make`](Self::make) would write is not there yet, or a study has made it.
    ///
    /// # Errors
    /// A file of that name is somebody's.
    pub fn check_free(folder: &Path) -> Result<(), ConvergeError> {
        made_before(folder).map(drop)
    }

    /// Renders one with `samples` a pixel in all and writes it to `folder/reference.exr`, unless it is there already
    /// from the same scene and number of samples.
    ///
    /// # Errors
    /// It cannot be written or read, [one that no study has made](Self::check_free) is there, or the user interrupted.
    pub fn make(variant: &mut Variant, samples: u64, folder: &Path, loud: bool) -> Result<Self, ConvergeError> {
        let (path, film) = (folder.join("reference.exr"), variant.world.film);
        let each = samples.div_ceil(REPLICATES).max(1);
        let there = made_before(folder)?;
        let made = there.is_some_and(|sidecar| {
            sidecar.spp == Some(each * REPLICATES) && sidecar.fingerprint.as_deref() == Some(&variant.fingerprint)
        });
        if !(made && path.is_file()) {
            if loud {
                crate::process::tell(format_args!(
                    "reference: {REPLICATES} renders of {each} samples a pixel, with seeds of their own\n"
                ));
            }
            render_reference(variant, each, &path, loud)?;
        }
        let reference = Self::load(&path, (film.width, film.height))?;
        Ok(Reference { noise_source: NoiseSource::Replicates, ..reference })
    }
}

fn render_reference(variant: &mut Variant, each: u64, path: &Path, loud: bool) -> Result<(), ConvergeError> {
    let film = variant.world.film;
    let values = 3 * film.width as usize * film.height as usize;
    let (mut sum, mut squares) = (vec![0.0f64; values], vec![0.0f64; values]);
    for replicate in 0..REPLICATES {
        let outcome = variant.render(each, REFERENCE_SEED.wrapping_add(replicate), loud);
        if interrupt::asked() {
            return Err(ConvergeError::Interrupted);
        }
        for y in 0..film.height {
            for x in 0..film.width {
                let at = 3 * (y as usize * film.width as usize + x as usize);
                for (c, value) in outcome.film.mean(x, y).into_iter().enumerate() {
                    sum[at + c] += value;
                    squares[at + c] += value * value;
                }
            }
        }
    }
    let n = REPLICATES as f64;
    let mean = |i: usize| sum[i] / n;
    // f64 sums of a few positive values: what cancels is at most 1e-15 of the square.
    let variance = |i: usize| ((squares[i] - sum[i] * mean(i)) / (n * (n - 1.0))).max(0.0);
    let (mut mse, mut relmse) = (0.0, 0.0);
    for i in 0..values {
        mse += variance(i);
        relmse += variance(i) * relative(mean(i));
    }
    let (mse, relmse) = (mse / values as f64, relmse / values as f64);
    let names = ["R", "G", "B", "variance.R", "variance.G", "variance.B"];
    let width = film.width as usize;
    let attributes = [("samples".to_owned(), Attribute::Integer(each * REPLICATES))];
    write_rows(path, (width, film.height as usize), &names, &attributes, |y, planes| {
        for x in 0..width {
            for c in 0..3 {
                let i = 3 * (y * width + x) + c;
                planes[c * width + x] = mean(i) as f32;
                planes[(3 + c) * width + x] = variance(i) as f32;
            }
        }
    })?;
    let sidecar = Sidecar {
        relmse_floor: relmse,
        rmse_floor: mse.sqrt(),
        spp: Some(each * REPLICATES),
        fingerprint: Some(variant.fingerprint.clone()),
    };
    Ok(write_beside(&path.with_extension("json"), |out| serde_json::to_writer_pretty(out, &sidecar))?)
}

/// What is said of the reference that a study has made in the folder, if one has.
fn made_before(folder: &Path) -> Result<Option<Sidecar>, ConvergeError> {
    let files = ["reference.exr", "reference.json"].map(|name| folder.join(name));
    let made = read_sidecar(&files[1])?.filter(|sidecar| sidecar.fingerprint.is_some());
    match files.into_iter().find(|file| made.is_none() && file.exists()) {
        Some(file) => {
            let why =
                "is there already, and not made by a study; name another folder, or measure against it by --reference";
            Err(ConvergeError::Reference { file: file.display().to_string(), why: why.to_owned() })
        }
        None => Ok(made),
    }
}

/// `None` too for a file that is about something else: the report of a render may have this name.
fn read_sidecar(path: &Path) -> Result<Option<Sidecar>, ConvergeError> {
    let fail = |why: String| ConvergeError::Reference { file: path.display().to_string(), why };
    let text = match std::fs::read_to_string(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        text => text.map_err(|error| fail(error.to_string()))?,
    };
    if !text.contains("\"relmse_floor\"") {
        return Ok(None);
    }
    let mend = "`relmse_floor` and `rmse_floor` are the noise of the reference: mend or remove the file";
    let sidecar: Sidecar = serde_json::from_str(&text).map_err(|error| fail(format!("{error}; {mend}")))?;
    if !(sidecar.relmse_floor >= 0.0 && sidecar.rmse_floor >= 0.0) {
        return Err(fail(format!("a noise is not below 0; {mend}")));
    }
    Ok(Some(sidecar))
}

fn mean_noise(planes: &[Vec<f32>; 3], variance: [&[f32]; 3]) -> Noise {
    let (mut mse, mut relmse) = (0.0, 0.0);
    for (plane, variance) in planes.iter().zip(variance) {
        for (&r, &v) in plane.iter().zip(variance) {
            mse += f64::from(v);
            relmse += f64::from(v) * relative(f64::from(r));
        }
    }
    let n = planes.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    Noise { mse: mse / n, relmse: relmse / n }
}
