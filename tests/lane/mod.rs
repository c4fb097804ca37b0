//! The lane arithmetic and its functions.

mod bits;
mod float_mode;
mod math;
pub mod widths;
