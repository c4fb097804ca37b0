//! Options and report of a build, and the binary tree it starts from.

use crate::geometry::Bounds;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;
use serde::Serialize;

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
/// The boxes in the tree are only near those given, for [`Plan`](super::collapse::Plan) to replace.
pub fn binary_tree(boxes: &[Bounds], preset: Preset) -> Bvh2 {
    let effort = Effort::of(preset);
    let boxes: Vec<Aabb> = boxes.par_iter().enumerate().map(|(i, b)| without_ties(i, b)).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        effort.distance,
        &boxes,
        (0..boxes.len() as u32).collect(),
        effort.precision,
        effort.hasty,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    for _ in 0..effort.runs {
        // Of a share of the nodes 1/1, 1/3, 1/5 …
        let passes = (0..effort.passes).map(|pass| 1.0 / (2 * pass + 1) as f32);
        optimizer.run(&mut tree, effort.share, Some(passes.collect()));
    }
    tree
}

/// What a binary tree is worth. Found by measuring; see benches/README.md.
struct Effort {
    /// How far along the curve boxes look for the one to join.
    distance: PlocSearchDistance,
    /// Rounds in which they look at their neighbours alone.
    hasty: usize,
    precision: SortPrecision,
    /// Of all nodes those that are tried elsewhere, and how often.
    share: f32,
    runs: usize,
    passes: usize,
}

impl Effort {
    fn of(preset: Preset) -> Self {
        let (low, medium) = (PlocSearchDistance::Low, PlocSearchDistance::Medium);
        let (fine, finest) = (SortPrecision::U64, SortPrecision::U128);
        match preset {
            Preset::Fast => Self { distance: low, hasty: 2, precision: fine, share: 0.02, runs: 1, passes: 16 },
            Preset::Medium => Self { distance: low, hasty: 2, precision: fine, share: 0.05, runs: 2, passes: 8 },
            Preset::Best => Self { distance: medium, hasty: 1, precision: finest, share: 1.0, runs: 1, passes: 16 },
        }
    }
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
