//! A tree of eight-wide nodes over blocks of eight primitives.

use super::collapse::Plan;
use super::emit::Emit;
use super::interval::{Interval, Segments};
use super::leaf::Leaf;
use super::node::{Child, Node};
use super::preorder::Preorder;
use super::{Preset, build};
use crate::geometry::{Bounds, Hit, RaySetup};
use crate::lane::{Bits, Mask, Real, axes, prefetch_second};
use core::hint::select_unpredictable;

/// Nodes on the longest way down are at most this many (see [`emit`](super::emit)), so a walk never holds more than
/// [`STACK`] entries: each node leaves at most seven behind, and is stored as eight.
pub const MAX_DEPTH: usize = 36;
pub const STACK: usize = MAX_DEPTH * 7 + 16;

/// Up to eight primitives side by side.
pub trait Block: Leaf + Copy + Send + Sync {
    /// Which of them some lane of a packet may hit before `t_best`, as bits: all, where nothing is known of the packet.
    fn places<E: Real>(&self, interval: Option<&Interval<E>>, t_best: f32) -> u32;
    /// Which of them some of a packet's segments may meet, as bits.
    fn places_about<E: Real>(&self, segments: &Segments<E>) -> u32;
    /// A packet against each of `places` in turn.
    fn closest_packet<R: Real>(&self, ray: &PacketRay<R>, places: u32, active: R::Mask, hit: &mut Hit<R>, t_max: R);
    fn any_packet<R: Real>(&self, ray: &PacketRay<R>, places: u32, t_max: R, active: R::Mask) -> R::Mask;
}

/// One ray in every lane of `E`, with what is uniform as plain numbers.
#[derive(Clone, Copy, Debug)]
pub struct OneRay<E: Real> {
    pub setup: RaySetup<E>,
    /// [`RaySetup::order`].
    pub order: [usize; 3],
    /// 1 where the direction is negative.
    pub negative: [usize; 3],
    /// Which octant the direction points to: bit k for a negative component k.
    pub octant: usize,
    pub t_max: f32,
}

/// A packet, with what its active lanes have in common.
#[derive(Clone, Copy, Debug)]
pub struct PacketRay<'a, R: Real> {
    pub setup: &'a RaySetup<R>,
    /// [`RaySetup::order`], where all agree.
    pub order: Option<[usize; 3]>,
    /// By axis, is the direction negative? Where all agree.
    pub negative: Option<[usize; 3]>,
    /// Lanes whose order has, at each of its places, axis 1 and axis 2.
    is_axis: [[R::Mask; 2]; 3],
}

impl<'a, R: Real> PacketRay<'a, R> {
    #[inline(always)]
    pub fn new(setup: &'a RaySetup<R>, active: R::Mask) -> Self {
        let all = active.bits();
        let first = all.trailing_zeros() as usize % R::WIDTH;
        let is_axis = axes(|k| [setup.order[k].eq(R::Bits::splat(1)), setup.order[k].eq(R::Bits::splat(2))]);
        let common = |mask: R::Mask| {
            let bits = (mask & active).bits();
            bits == 0 || bits == all
        };
        let ordered = (0..2).all(|k| common(is_axis[k][0]) && common(is_axis[k][1]));
        Self {
            setup,
            order: ordered.then(|| axes(|k| setup.order[k].lane(first) as usize % 3)),
            negative: common_octant(setup, active),
            is_axis,
        }
    }
    /// The coordinate at place `k` of each lane's order.
    #[inline(always)]
    pub fn pick(&self, k: usize, p: [R; 3]) -> R {
        let [is_y, is_z] = self.is_axis[k];
        R::select(is_z, p[2], R::select(is_y, p[1], p[0]))
    }
}

/// [`PacketRay::negative`].
#[inline(always)]
pub fn common_octant<R: Real>(setup: &RaySetup<R>, active: R::Mask) -> Option<[usize; 3]> {
    let all = active.bits();
    let negative = axes(|k| (setup.negative[k] & active).bits());
    negative.iter().all(|&bits| bits == 0 || bits == all).then(|| axes(|k| usize::from(negative[k] != 0)))
}

/// The best hit so far of one ray.
#[derive(Clone, Copy, Debug)]
pub struct OneHit {
    pub primitive: u32,
    pub t: f32,
    pub u: f32,
    pub v: f32,
}

impl OneHit {
    /// The distance of what is no hit: no [key](OneHit::key) is greater.
    pub const NEVER: f32 = f32::from_bits(u32::MAX);

    /// Less for better hits: those nearer, or as near and of a lower primitive. Domain: distances that are not negative, and
    /// [`OneHit::NEVER`].
    #[inline(always)]
    pub fn key(&self) -> u64 {
        u64::from(self.t.to_bits()) << 32 | u64::from(self.primitive)
    }
}

#[derive(Clone, Debug)]
pub struct Tree<B> {
    pub root: Child,
    pub nodes: Vec<Node>,
    pub blocks: Vec<B>,
    /// Nodes on the longest way down.
    pub depth: usize,
    /// Is it too large for the caches near a core? Then it pays to [prefetch](Tree::prefetch).
    pub far: bool,
    /// Is it too large for all caches? Then packets take [turns](super::group::side_by_side).
    pub in_memory: bool,
}

/// Bytes from which a tree is [far](Tree::far). Found by measuring: a stream of rays loses 3 % by prefetching 5 MB, gains as
/// much with 11 MB and a third with 690 MB.
const FAR: usize = 8 << 20;

/// Bytes from which a tree is [in memory](Tree::in_memory). By measuring: camera packets lose 4 % by taking turns in 11 MB, and gain
/// 7 % in 690 MB.
const IN_MEMORY: usize = 64 << 20;

impl<B> Default for Tree<B> {
    fn default() -> Self {
        Self { root: Child::NONE, nodes: Vec::new(), blocks: Vec::new(), depth: 0, far: false, in_memory: false }
    }
}

impl<B: Block> Tree<B> {
    /// `block` makes the block of up to eight primitives, given by index into `boxes`.
    pub fn build(boxes: &[Bounds], preset: Preset, block: impl Fn(&[u32]) -> B + Sync) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        if boxes.len() <= 8 {
            let all: Vec<u32> = (0..boxes.len() as u32).collect();
            return Self { root: Child::leaf(0), blocks: vec![block(&all)], ..Self::default() };
        }
        let order = Preorder::new(&build::binary_tree(boxes, preset));
        let tree = Emit { plan: &Plan::new(&order, boxes), boxes, block }.tree();
        let bytes = tree.node_bytes() + tree.block_bytes();
        Self { far: bytes >= FAR, in_memory: bytes >= IN_MEMORY, ..tree }
    }

    /// Starts to bring the node or block that `child` names towards the core. Any child will do.
    #[inline(always)]
    pub fn prefetch(&self, child: Child) {
        let block = self.blocks.as_ptr().wrapping_add(child.index()).cast::<[u8; 64]>();
        let node = self.nodes.as_ptr().wrapping_add(child.index()).cast::<[u8; 64]>();
        let is_leaf = child.is_leaf();
        let first = select_unpredictable(is_leaf, block, node);
        for line in 0..size_of::<Node>() / 64 {
            prefetch_second(first.wrapping_add(line));
        }
        // Blocks of triangles have a line more, those of spheres one less.
        prefetch_second(select_unpredictable(is_leaf, block.wrapping_add(size_of::<B>() / 64 - 1), node));
    }
    /// [`Tree::prefetch`] where `child` is known to be a node.
    #[inline(always)]
    pub fn prefetch_node(&self, child: Child) {
        prefetch_second(self.nodes.as_ptr().wrapping_add(child.index()));
    }
    /// [`Tree::prefetch`] where `child` is known to be a block.
    #[inline(always)]
    pub fn prefetch_block(&self, child: Child) {
        prefetch_second(self.blocks.as_ptr().wrapping_add(child.index()));
    }
    pub fn node_bytes(&self) -> usize {
        core::mem::size_of_val(self.nodes.as_slice())
    }
    pub fn block_bytes(&self) -> usize {
        core::mem::size_of_val(self.blocks.as_slice())
    }
    /// Children of all nodes together.
    pub fn children(&self) -> usize {
        self.nodes.iter().map(Node::count).sum()
    }
}
