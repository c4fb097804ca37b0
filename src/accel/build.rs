//! Options and report of a build, and the binary tree it starts from.

use crate::geometry::Bounds;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::{BvhBuildParams, bvh2::builder::build_bvh2};
use serde::Serialize;
use std::time::Duration;

/// How much time to spend on the tree. Results do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    Fast,
    #[default]
    Medium,
    /// A few per cent more rays for ten times the build.
    Best,
}

#[derive(Clone, Copy, Debug)]
pub struct BuildOptions {
    /// For [`Brute`](super::Brute).
    pub lists: bool,
    /// For every other mode.
    pub trees: bool,
    pub preset: Preset,
}

impl BuildOptions {
    pub fn lists() -> Self {
        Self { lists: true, trees: false, preset: Preset::default() }
    }
    pub fn trees(preset: Preset) -> Self {
        Self { lists: false, trees: true, preset }
    }
}

/// What [`Accel::build`](super::Accel::build) made.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BuildReport {
    pub seconds: f64,
    pub node_bytes: usize,
    pub block_bytes: usize,
    pub list_bytes: usize,
    pub nodes: usize,
    pub blocks: usize,
    /// Children of all nodes together.
    pub children: usize,
    /// Nodes on the longest way down.
    pub depth: usize,
}

/// A binary tree with one primitive a leaf. Pre-splitting stays off: a piece of a triangle does not contain the
/// triangle's own box.
pub fn binary_tree(boxes: &[Bounds], preset: Preset) -> Bvh2 {
    let boxes: Vec<Aabb> = boxes.iter().map(|b| Aabb::new(b.lo.into(), b.hi.into())).collect();
    let params = match preset {
        Preset::Fast => BvhBuildParams::fast_build(),
        Preset::Medium => BvhBuildParams::medium_build(),
        Preset::Best => BvhBuildParams::very_slow_build(),
    };
    let params = BvhBuildParams { pre_split: false, max_prims_per_leaf: 1, ..params };
    build_bvh2(&boxes, params, &mut Duration::default())
}
