//! `octolux compare A.exr B.exr`: error metrics of A against B, for people, for programs and as a picture.

use std::fmt;
use std::io::{self, Write};
use std::path::PathBuf;

use crate::film::beside::write_beside;
use crate::film::{ExrImage, FilmError, read_exr};
use crate::render::Phase;

use super::diff::write_diff;
use super::metrics::{self, compare};

pub use super::metrics::{Comparison, Place, ZScores};

/// Arguments of `octolux compare`.
#[derive(Clone, Debug, clap::Args)]
pub struct CompareArgs {
    /// The image that is judged (EXR)
    pub a: PathBuf,
    /// The reference that it is judged against (EXR of the same size)
    pub b: PathBuf,
    /// Write the metrics as JSON to FILE; with `-` stdout carries only the JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Exit with 1 if relMSE = mean((a-b)^2/(b^2+0.01)) is above X, or a value is NaN or infinite
    #[arg(long, value_name = "X", value_parser = parse_limit)]
    pub max_relmse: Option<f64>,
    /// Write a PNG of the relative difference: red where A is brighter, blue where darker, black where equal
    #[arg(long, value_name = "FILE.png")]
    pub diff: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
}

/// Why two images could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error("{}: {}x{} pixels, but {} has {}x{}: only images of one size can be compared; render both with one --size",
        .b.display(), .size_b.0, .size_b.1, .a.display(), .size_a.0, .size_a.1)]
    Sizes { a: PathBuf, b: PathBuf, size_a: (u32, u32), size_b: (u32, u32) },
    #[error("stdout: {0}")]
    Stdout(#[from] io::Error),
    #[error("the comparison cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Reads both images, compares them and writes the difference picture if one is asked for.
///
/// # Errors
/// A file cannot be read or written, or the sizes differ.
pub fn run(args: &CompareArgs) -> Result<Comparison, CompareError> {
    let phase = Phase::begin("reading the images", args.quiet);
    let (a, b) = (read_exr(&args.a)?, read_exr(&args.b)?);
    drop(phase);
    let _phase = Phase::begin("comparing", args.quiet);
    let names = (args.a.to_string_lossy(), args.b.to_string_lossy());
    let mut comparison = compare(&a, &b, (&names.0, &names.1)).ok_or_else(|| CompareError::Sizes {
        a: args.a.clone(),
        b: args.b.clone(),
        size_a: (a.width, a.height),
        size_b: (b.width, b.height),
    })?;
    comparison.notes.extend(samples_note(&a, &b));
    if let Some(path) = &args.diff {
        write_diff(&a, &b, path)?;
    }
    Ok(comparison)
}

/// [`run`], then prints: the summary, or the JSON alone with `--json -`. False if A is beyond `--max-relmse`.
///
/// # Errors
/// As [`run`], and if the JSON or stdout cannot be written.
pub fn compare_command(args: &CompareArgs) -> Result<bool, CompareError> {
    let comparison = run(args)?;
    let mut stdout = io::stdout().lock();
    match &args.json {
        Some(path) if path.as_os_str() == "-" => {
            serde_json::to_writer_pretty(&mut stdout, &comparison)?;
            writeln!(stdout)?;
        }
        other => {
            if let Some(path) = other {
                write_beside(path, |file| serde_json::to_writer_pretty(file, &comparison))?;
            }
            write!(stdout, "{comparison}")?;
        }
    }
    stdout.flush()?;
    Ok(args.max_relmse.is_none_or(|limit| comparison.within(limit)))
}

impl Comparison {
    /// True if every value is finite and relMSE is at most `max_relmse`.
    pub fn within(&self, max_relmse: f64) -> bool {
        self.non_finite == 0 && self.relmse <= max_relmse
    }
}

fn parse_limit(text: &str) -> Result<f64, String> {
    let limit = text.parse::<f64>().ok().filter(|limit| limit.is_finite() && *limit >= 0.0);
    limit.ok_or_else(|| "a number of 0 or more is needed".to_owned())
}

fn samples_note(a: &ExrImage, b: &ExrImage) -> Option<String> {
    let (a, b) = (metrics::samples(a)?, metrics::samples(b)?);
    Some(format!("samples per pixel: A {a}, B {b}"))
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "A  {}", self.a)?;
        writeln!(f, "B  {}", self.b)?;
        writeln!(f, "size            {}x{}", self.width, self.height)?;
        if self.identical {
            writeln!(f, "identical       every value has the same bits")?;
        }
        if self.non_finite > 0 {
            writeln!(f, "not finite      {} values (left out of what follows)", self.non_finite)?;
        }
        writeln!(f, "RMSE            {:.6e}", self.rmse)?;
        writeln!(f, "relMSE          {:.6e}", self.relmse)?;
        let ratio = |c: usize| self.mean_ratio[c].map_or("-".to_owned(), |ratio| format!("{ratio:.6}"));
        writeln!(f, "mean A/B        R {}  G {}  B {}", ratio(0), ratio(1), ratio(2))?;
        write!(f, "max |A-B|       {:.6e}", self.max_abs_difference)?;
        writeln!(f, "{}", self.max_at.map_or(String::new(), |at| format!(" at {at}")))?;
        if let Some(z) = &self.z {
            write!(f, "{z}")?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))
    }
}

impl fmt::Display for ZScores {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tested, mean, standard_deviation, max_abs, max_at, bound, beyond_bound, unexplained } = self;
        writeln!(f, "z-scores        mean {mean:.4}, standard deviation {standard_deviation:.4}, {tested} tested")?;
        writeln!(f, "largest |z|     {max_abs:.3} at {max_at}")?;
        writeln!(
            f,
            "beyond bound    {beyond_bound} (|z| > {bound:.3}: none in 99 of 100 comparisons of equal images whose errors are normal)"
        )?;
        if *unexplained > 0 {
            writeln!(f, "no variance     {unexplained} values differ although both claim none")?;
        }
        Ok(())
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let channel = ["R", "G", "B"].get(self.channel as usize).copied().unwrap_or("?");
        write!(f, "({}, {}) {channel}", self.x, self.y)
    }
}
