//! octolux: a CPU Monte Carlo renderer kernel.

pub mod accel;
pub mod bsdf;
pub mod film;
pub mod geometry;
pub mod lane;
pub mod light;
pub mod report;
pub mod sampling;
pub mod scene;
