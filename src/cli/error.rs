//! Everything that ends a command: one line, exit code 2.

use crate::film::FilmError;
use crate::scene::SceneError;
use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
pub enum CliError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error(transparent)]
    Compare(#[from] crate::report::CompareError),
    #[error(transparent)]
    Converge(#[from] crate::report::converge::ConvergeError),
    #[error(transparent)]
    BenchRays(#[from] crate::report::bench_rays::BenchRaysError),
    #[error(transparent)]
    State(#[from] crate::render::StateError),
    #[error(transparent)]
    Light(#[from] crate::light::LightError),
    #[error("{path}: cannot write: {source}; choose another path", path = .path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("no worker threads: {0}; ask for fewer with --threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error("interrupted before every pixel had a sample; nothing was written")]
    Interrupted,
    #[error("interrupted before the first rung of the ladder was done; nothing was written")]
    InterruptedLadder,
    #[error("{0}")]
    Usage(String),
}
