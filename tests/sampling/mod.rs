//! Random numbers, warps and frames.

pub mod draw;
mod frame;
mod random;
mod sampler;
mod site;
mod sobol;
mod warp;
