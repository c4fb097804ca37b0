//! The proof, on a user's own scene and machine, that nothing but the scene, the seed and the sample count decides an
//! image's bits.
//!
//! Two comparisons, both against width 1 on one thread with the general kernel: whole images over combinations of
//! width, threads, tile and plan (`images`); and every tapped value of every path (`stages`), which names the first
//! that differs.
//!
//! [`DirectionTest`] holds samplers of directions to their pdfs.
//!
//! [`numerics`] is about the build and the CPU rather than a scene: the catalogue of extreme cases.

mod chi_squared;
mod directions;
#[allow(missing_docs)] // fields are keys of a report, as in the others
mod images;
#[allow(missing_docs)]
pub mod numerics;
#[allow(missing_docs)]
mod stages;

pub use chi_squared::ChiSquared;
pub use directions::{DirectionReport, DirectionTest};
pub use images::{ImageCase, compare_images};
pub use stages::{Difference, StageReport, compare_stages, record_tile};
