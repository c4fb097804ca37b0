//! Random numbers, warps and frames.

mod frame;
mod random;
mod warp;
