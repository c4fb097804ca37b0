//! All integration tests, by kind, in one binary.

// The second build of .ci/run (RUSTFLAGS with `--cfg kernels_only`) tests bits and numbers on another instruction set and compiles
// no more than that takes.
#![cfg_attr(kernels_only, allow(dead_code, unused_imports))]

mod stats;

mod bsdf;
mod equivalence;
mod lane;
mod light_paths;
mod numerics;
mod oracle;
mod renders;
mod sampling;
mod traversal;

#[cfg(not(kernels_only))]
mod adaptive;
#[cfg(not(kernels_only))]
mod cli;
#[cfg(not(kernels_only))]
mod closed_forms;
#[cfg(not(kernels_only))]
mod estimate;
#[cfg(not(kernels_only))]
mod film;
#[cfg(not(kernels_only))]
mod gather;
#[cfg(not(kernels_only))]
mod independent;
#[cfg(not(kernels_only))]
mod light;
#[cfg(not(kernels_only))]
mod own;
#[cfg(not(kernels_only))]
mod references;
#[cfg(not(kernels_only))]
mod report;
#[cfg(not(kernels_only))]
mod reuse;
#[cfg(not(kernels_only))]
mod scene_files;
#[cfg(not(kernels_only))]
mod textures;
