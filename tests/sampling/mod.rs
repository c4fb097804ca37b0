//! Random numbers, warps and frames.

pub mod draw;
mod frame;
mod random;
mod sobol;
mod warp;
