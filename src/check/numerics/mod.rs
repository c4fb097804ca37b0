//! The catalogue of stiff and extreme cases, run on the build and CPU at hand.
//!
//! One file a concept. Each returns [`Row`]s: how many values were tried, the worst error, the bound that it must keep.
//! Bounds are derived where the tested thing is written, or are the published ones; none was fitted to what came out.

mod degenerate;
mod emission;
mod hit_point;
mod lane_functions;
mod lane_maths;
mod leaving;
mod naive;
mod random;
mod randomness;
mod rays;
mod rooms;
mod row;
mod scattering;
pub mod shapes;
mod sums;
mod two_arguments;
pub mod ulp;
mod watertight;
mod workers;

pub use row::Row;

use std::time::Instant;

/// How much of the catalogue's sampled cases to try; every case is tried at each effort.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// Seconds: for the test suite.
    Quick,
    /// Half a minute on two cores: for anyone, and CI.
    Strided,
    /// All 2³² arguments of the lane functions, 10⁹ pairs, 10⁷ rays at edges and corners: some twenty minutes.
    Full,
}

impl Effort {
    /// One of three numbers.
    fn pick<T>(self, quick: T, strided: T, full: T) -> T {
        match self {
            Effort::Quick => quick,
            Effort::Strided => strided,
            Effort::Full => full,
        }
    }
}

/// A part of the catalogue.
pub struct Group {
    pub name: &'static str,
    run: fn(Effort) -> Vec<Row>,
}

/// In the order of the table.
pub const GROUPS: &[Group] = &[
    Group { name: "workers", run: workers::rows },
    Group { name: "lane maths", run: lane_maths::rows },
    Group { name: "two arguments", run: two_arguments::rows },
    Group { name: "watertight", run: watertight::rows },
    Group { name: "degenerate scenes", run: degenerate::rows },
    Group { name: "hit point", run: hit_point::rows },
    Group { name: "leaving a surface", run: leaving::rows },
    Group { name: "scattering", run: scattering::rows },
    Group { name: "lights", run: emission::rows },
    Group { name: "random numbers", run: randomness::rows },
    Group { name: "film", run: sums::rows },
    Group { name: "rooms", run: rooms::rows },
];

/// The finished table.
#[derive(serde::Serialize)]
pub struct NumericsReport {
    pub effort: Effort,
    pub cpu_features: Vec<&'static str>,
    pub threads: usize,
    pub rows: Vec<Row>,
    pub seconds: f64,
    pub pass: bool,
}

/// Runs the groups whose name contains `only` on `pool`, handing each group's rows to `seen` as they come.
pub fn run(effort: Effort, only: &str, pool: &rayon::ThreadPool, mut seen: impl FnMut(&[Row])) -> NumericsReport {
    let start = Instant::now();
    let mut rows = Vec::new();
    for group in GROUPS.iter().filter(|group| group.name.contains(only)) {
        let found = pool.install(|| (group.run)(effort));
        seen(&found);
        rows.extend(found);
    }
    let pass = rows.iter().all(|row| row.pass);
    NumericsReport {
        effort,
        cpu_features: crate::cpu::compiled_features(),
        threads: pool.current_num_threads(),
        rows,
        seconds: start.elapsed().as_secs_f64(),
        pass,
    }
}
