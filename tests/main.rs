//! All integration tests, by kind, in one binary.

mod stats;

mod bsdf;
mod cli;
mod film;
mod lane;
mod light;
mod oracle;
mod sampling;
mod scene_files;
mod traversal;
