//! The lane arithmetic and its functions.

mod float_mode;
mod math;
pub mod widths;
