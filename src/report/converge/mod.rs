//! Error against samples and against run time: `octolux converge`.
//!
//! A study renders every variant at every budget with several seeds (**cells**), measures each image against a
//! reference, and reports means over seeds with their intervals. Cells are rendered in this process, seed after seed
//! so that what is finished at any moment holds whole curves, variants in turn so that a machine that slows down slows
//! them all. All variants of a budget and seed number use the same seed; no two budgets share one.
//!
//! What is measured, r being the reference, x_s the image of seed s, w = 1 or 1/(r² + 0.01), means over pixels and
//! channels (`statistics`):
//!
//! - mean w (x_s − r)² less what the reference's own noise adds ([`Noise`]): MSE (RMSE is its root) and relMSE;
//! - bias² = mean w (E x − r)², from pairs of different seeds, less the reference's noise; variance is the rest;
//! - seconds: rendering alone; and set-up + rendering + writing the image.
//!
//! Folder: `cells.json` and `cells/*.exr` (what `--resume` goes by), `report.json`, `errors.csv`, `*.svg`, `images/`,
//! `report.html`.

mod cell;
mod html;
mod pictures;
mod progress;
mod reference;
mod run;
mod statistics;
mod store;
mod summary;
mod write;

pub use cell::{Budget, Cell, CellKey};
pub use reference::{Noise, NoiseSource, Reference};
pub use run::{Plan, Variant, run};
pub use statistics::{Accumulator, LARGEST_TRUSTED_SHARE, Moments, Split};
pub use store::StoreError;
pub use summary::{ConvergeReport, REPORT_FORMAT, Row, Target, VariantReport};

use crate::film::FilmError;

/// Why a study could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ConvergeError {
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("no worker threads: {0}; ask for fewer with --threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error("{file}: {why}")]
    Reference { file: String, why: String },
    #[error("interrupted before any cell was finished; nothing was reported")]
    Interrupted,
}
