//! The lane arithmetic and its functions.

mod math;
pub mod ulp;
pub mod widths;
