//! Where results go, and what an image file says of itself.

use super::CliError;
use crate::film::{self, Attribute, Film, VarianceValidity};
use crate::render::StoppedBy;
use crate::sampling::SamplerKind;
use std::path::{Path, PathBuf};

/// What a file system takes into its cache.
const FILE_BYTES_PER_SECOND: f64 = 1e9;

/// Images to write. Every command that ends in an image has these.
#[derive(clap::Args, Clone)]
pub struct ImageArgs {
    /// EXR image: R G B, variance.R/G/B, metadata [default: named for the scene, unless another image is asked for]
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: Option<PathBuf>,
    /// 8-bit PNG preview, exposed and sRGB-encoded
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    /// Exposure of the PNG in stops
    #[arg(long, default_value_t = 0.0, requires = "png", value_parser = stops)]
    pub exposure: f32,
}

fn stops(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|x: &f32| x.abs() <= 1000.0).ok_or_else(|| "must be a number from -1000 to 1000".into())
}

/// What an image's header says of its making.
pub struct Facts {
    pub scene: String,
    pub render_seconds: f64,
    pub seed: u64,
    pub sampler: SamplerKind,
    pub stopped_by: StoppedBy,
    pub shares_points: bool,
}

/// The folders of these files exist and can be written to, and they are no folders themselves: to be known before anything is
/// rendered.
pub fn check_folders<'a>(files: impl IntoIterator<Item = &'a Path>) -> Result<(), CliError> {
    for path in files {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            let (path, folder) = (path.display(), folder.display());
            return Err(CliError::Usage(format!("{path}: there is no folder {folder}; create it")));
        }
        if path.is_dir() {
            return Err(CliError::Usage(format!("{}: is a folder; name a file", path.display())));
        }
        film::beside::check_writable(path)?;
    }
    Ok(())
}

/// No file is written over another of the same run, or over what the run reads: to be known before anything is rendered. Devices
/// and pipes keep nothing.
pub fn check_apart<'a>(
    files: impl IntoIterator<Item = &'a Path>,
    read: impl IntoIterator<Item = &'a Path>,
) -> Result<(), CliError> {
    let mut taken: Vec<(PathBuf, &str)> = read.into_iter().map(|path| (place(path), "is read here")).collect();
    for path in files.into_iter().filter(|path| !path.exists() || path.is_file()) {
        let place = place(path);
        if let Some((_, what)) = taken.iter().find(|(other, _)| *other == place) {
            return Err(CliError::Usage(format!(
                "{}: {what}, and would be written over; name another file",
                path.display()
            )));
        }
        taken.push((place, "is named twice"));
    }
    Ok(())
}

/// Do both name one file, be it there or not?
pub fn same_file(a: &Path, b: &Path) -> bool {
    place(a) == place(b)
}

/// The same for all names of a file.
fn place(path: &Path) -> PathBuf {
    let path = &film::beside::end_of_links(path);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let new = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(new).unwrap_or_else(|| path.to_owned())
}

/// The EXR file that is written where none is named.
pub fn default_exr(scene: &Path) -> PathBuf {
    let named_scene = scene.file_stem().is_some_and(|s| s == "scene");
    let folder = scene.parent().and_then(Path::file_name).filter(|_| named_scene);
    PathBuf::from(folder.or(scene.file_stem()).unwrap_or("image".as_ref())).with_added_extension("exr")
}

impl ImageArgs {
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        [self.output.as_deref(), self.png.as_deref()].into_iter().flatten()
    }

    /// Names that promise what is not written into them: known before anything is rendered.
    pub fn check(&self) -> Result<(), CliError> {
        let refused = |path: &Path, why: &str| Err(CliError::Usage(format!("{}: {why}", path.display())));
        let ends = |path: &Path, extensions: &[&str]| {
            path.extension().is_some_and(|end| extensions.iter().any(|known| end.eq_ignore_ascii_case(known)))
        };
        if let Some(path) = self.files().find(|path| *path == Path::new("-")) {
            return refused(path, "images go into files; for standard output name /dev/stdout");
        }
        match (&self.output, &self.png) {
            (Some(exr), _) if ends(exr, &["png", "jpg", "jpeg"]) => {
                refused(exr, "-o writes EXR; use --png for a PNG, or name it .exr")
            }
            (_, Some(png)) if ends(png, &["exr", "jpg", "jpeg"]) => {
                refused(png, "--png writes PNG; use -o for an EXR, or name it .png")
            }
            _ => Ok(()),
        }
    }

    /// Seconds that writing will take, before anything is known: about 150 MB/s of EXR, 60 MB/s of PNG, and a few
    /// milliseconds for each file.
    pub fn guessed_seconds(&self, pixels: f64, aovs: bool) -> f64 {
        let exr = self.output.as_ref().map_or(0.0, |_| 0.003 + pixels * if aovs { 52.0 } else { 24.0 } / 150e6);
        exr + self.png.as_ref().map_or(0.0, |_| 0.003 + pixels * 3.0 / 60e6)
    }

    /// The same from a trial on the uppermost rows: a sixteenth of the image, some milliseconds. Works in the current
    /// rayon pool.
    pub fn trial_seconds(&self, film: &Film) -> f64 {
        let rows = film.height().div_ceil(16).clamp(1, 64);
        let all = |(seconds, bytes): (f64, usize)| {
            let share = f64::from(film.height()) / f64::from(rows);
            0.003 + share * (seconds + bytes as f64 / FILE_BYTES_PER_SECOND)
        };
        let exr = self.output.as_ref().map_or(0.0, |_| all(film::exr_write::trial(film, rows)));
        exr + self.png.as_ref().map_or(0.0, |_| all(film::png::trial(film, rows, self.exposure)))
    }

    /// Works in the current rayon pool.
    pub fn write(&self, film: &Film, facts: &Facts) -> Result<(), CliError> {
        if let Some(path) = &self.output {
            film::write_exr(film, path, &attributes(film, facts), validity(facts))?;
        }
        if let Some(path) = &self.png {
            film::write_png(film, path, self.exposure)?;
        }
        Ok(())
    }
}

/// Writes a report to a file or, for `-`, to standard output.
pub fn write_json(report: &impl serde::Serialize, path: Option<&Path>) -> Result<(), CliError> {
    let Some(path) = path else { return Ok(()) };
    // Numbers, strings and lists: nothing that JSON cannot hold.
    let text = serde_json::to_string_pretty(report).map_err(|e| CliError::Usage(e.to_string()))? + "\n";
    if path == Path::new("-") {
        print!("{text}");
        return Ok(());
    }
    film::beside::write_beside(path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
    Ok(())
}

fn validity(facts: &Facts) -> VarianceValidity {
    match facts.stopped_by {
        StoppedBy::Error if !facts.shares_points => VarianceValidity::Stopped,
        _ => VarianceValidity::of(facts.sampler, facts.shares_points),
    }
}

fn attributes(film: &Film, facts: &Facts) -> Vec<(String, Attribute)> {
    let text = |s: &str| Attribute::Text(s.to_string());
    let belief = film.channels().has_posterior().then(|| ("bmc_variance".to_string(), text(BELIEF)));
    [
        ("version", text(env!("CARGO_PKG_VERSION"))),
        ("scene", text(&facts.scene)),
        ("samples", Attribute::Integer(film.mean_samples().round() as u64)),
        ("render_seconds", Attribute::Float(facts.render_seconds as f32)),
        ("seed", Attribute::Integer(facts.seed)),
        ("sampler", text(facts.sampler.name())),
        ("stopped_by", text(&format!("{:?}", facts.stopped_by).to_lowercase())),
        ("claim", text(facts.stopped_by.claim())),
        ("discarded_samples", Attribute::Integer(film.discarded().count)),
        ("cpu_features", text(&crate::cpu::compiled_features().join(" "))),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .into_iter()
    .chain(belief)
    .collect()
}

/// What `bmc.variance` is.
const BELIEF: &str = "posterior variance of the gathered light under its Gaussian process, over samples as if their errors \
                      were independent; of light and material samples, and under equal weights, the sample variance";
