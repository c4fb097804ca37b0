//! Random numbers, warps and frames.

pub mod draw;
mod frame;
mod nets;
mod random;
mod sampler;
mod site;
mod sobol;
mod warp;
