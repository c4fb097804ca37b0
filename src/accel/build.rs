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
    /// The tree is soonest there.
    Fast,
    /// Most of the rays per second for a fraction of the build.
    #[default]
    Medium,
    /// 5–10 % more incoherent rays for some three times the build.
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
///
/// The boxes in the tree are only near those given, for [`collapse`](super::collapse) to replace.
pub fn binary_tree(boxes: &[Bounds], preset: Preset) -> Bvh2 {
    let boxes: Vec<Aabb> = boxes.iter().enumerate().map(|(i, b)| without_ties(i, b)).collect();
    let params = match preset {
        Preset::Fast => BvhBuildParams::fast_build(),
        Preset::Medium => BvhBuildParams::medium_build(),
        // Its first reinsertion pass already tries every node: a second doubles the build and buys no rays.
        Preset::Best => BvhBuildParams {
            post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
            ..BvhBuildParams::very_slow_build()
        },
    };
    let params = BvhBuildParams { pre_split: false, max_prims_per_leaf: 1, ..params };
    build_bvh2(&boxes, params, &mut Duration::default())
}

/// The box grown on each side by a random share of its size, 2⁻¹⁰ at most.
///
/// The builder joins boxes that are each other's nearest. Among equal distances it takes the lower index, so that of n
/// coincident boxes (or of a regular grid) one pair finds itself at a time: 10⁵ took minutes and gave a list.
fn without_ties(index: usize, bounds: &Bounds) -> Aabb {
    let mut state = index as u64;
    let mut share = || {
        // splitmix64 (Steele, Lea, Flood 2014): any well mixed function of the index does.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (state ^ index as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 40) as f32 / (16_777_216.0 * 1024.0)
    };
    let size = (0..3).map(|k| bounds.hi[k] - bounds.lo[k]).fold(0.0, f32::max);
    let lo: [f32; 3] = core::array::from_fn(|k| bounds.lo[k] - size * share());
    let hi: [f32; 3] = core::array::from_fn(|k| bounds.hi[k] + size * share());
    Aabb::new(lo.into(), hi.into())
}
