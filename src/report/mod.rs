//! What is said about images once they exist: error metrics and comparisons.

pub mod ablation;
pub mod bench;
pub mod bench_rays;
pub mod compare;
pub mod contact_sheet;
pub mod converge;
pub mod diff;
pub mod fit;
pub mod font;
pub mod metrics;
pub mod page;
pub mod plot;
pub mod sidak;

pub use compare::{CompareArgs, CompareError, compare_command};
