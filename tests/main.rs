//! All integration tests, by kind, in one binary.

mod stats;

mod adaptive;
mod bsdf;
mod cli;
mod closed_forms;
mod equivalence;
mod estimate;
mod film;
mod gather;
mod independent;
mod lane;
mod light;
mod light_paths;
mod numerics;
mod oracle;
mod own;
mod references;
mod renders;
mod report;
mod reuse;
mod sampling;
mod scene_files;
mod textures;
mod traversal;
