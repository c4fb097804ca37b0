//! Many rays in flight, one step each in turn.
//!
//! A single ray waits for itself: which node comes next depends on the last test, 34 cycles for 4 of arithmetic, and on
//! branches no predictor knows. Here each ray is in one of three lists (at a node, at a block, looking for its next
//! child) and a step moves it to another by arithmetic instead of a branch, so that the steps of different rays overlap.

use super::node::{Child, Node};
use super::single::{Lanes, enter};
use super::tree::{Block, OneHit, OneRay, STACK, Tree};
use super::{Accel, Mode, Packet, Shadow, Single, Stream};
use crate::geometry::{Hit, MISS, RaySetup};
use crate::lane::{Bits, Mask, Real, prefetch};
use std::cell::RefCell;

/// Rays in flight at most: the widest packet.
const RAYS: usize = 16;

/// Children still to visit, for each ray.
struct Stacks {
    t_near: [[f32; STACK]; RAYS],
    child: [[u32; STACK]; RAYS],
}

thread_local! {
    // Too large to clear for every packet, and what a walk leaves behind is never read.
    static STACKS: RefCell<Stacks> =
        const { RefCell::new(Stacks { t_near: [[0.0; STACK]; RAYS], child: [[0; STACK]; RAYS] }) };
}

/// Rays in one state.
#[derive(Clone, Copy, Default)]
struct List {
    rays: [u8; RAYS],
    len: usize,
}

impl List {
    /// Appends where `wanted`. Writing in place over what was already read is fine: a list never overtakes its reader.
    #[inline(always)]
    fn push_if(&mut self, ray: usize, wanted: bool) {
        self.rays[self.len % RAYS] = ray as u8;
        self.len += usize::from(wanted);
    }
    #[inline(always)]
    fn take(&mut self) -> usize {
        core::mem::take(&mut self.len)
    }
    #[inline(always)]
    fn at(&self, k: usize) -> usize {
        self.rays[k] as usize % RAYS
    }
}

struct Walk<'a, B> {
    tree: &'a Tree<B>,
    stacks: &'a mut Stacks,
    len: [usize; RAYS],
    child: [Child; RAYS],
    nodes: List,
    blocks: List,
    pops: List,
}

impl<B: Block> Walk<'_, B> {
    /// Sends ray `i` to its next child if that is still before `t_best`, else to look on; ends it where none is left.
    #[inline(always)]
    fn pop(&mut self, i: usize, t_best: f32) {
        let more = self.len[i] > 0;
        let top = self.len[i].saturating_sub(1);
        let (t_near, child) = (self.stacks.t_near[i][top], Child(self.stacks.child[i][top]));
        self.len[i] = top;
        self.child[i] = child;
        let open = more & (t_near <= t_best);
        self.nodes.push_if(i, open & !child.is_leaf());
        self.blocks.push_if(i, open & child.is_leaf());
        self.pops.push_if(i, more & !open);
        // Whatever is no node is harmless to fetch.
        prefetch(self.tree.nodes.as_ptr().wrapping_add(child.index()));
    }

    /// Tests the children of ray `i`'s node and pushes those entered before `t_best`, the nearest last.
    #[inline(always)]
    fn step<E: Real>(&mut self, i: usize, ray: &OneRay<E>, t_best: f32) {
        let node: &Node = &self.tree.nodes[self.child[i].index()];
        let (t_near, t_far) = enter(node, ray, 0);
        let order = E::Bits::unpack_octal(node.order[ray.octant()]);
        let t_far = t_far.min_or(E::splat(t_best));
        let (t_near, t_far) = (t_near.permute(order), t_far.permute(order));
        let children = E::from_bits(E::Bits::load(&node.children)).permute(order);
        let bits = t_near.le(t_far).bits();
        t_near.compress(bits).store(&mut self.stacks.t_near[i][self.len[i]..]);
        children.compress(bits).to_bits().store(&mut self.stacks.child[i][self.len[i]..]);
        self.len[i] += bits.count_ones() as usize;
    }
}

/// Walks the rays of `bits`. `leaf` tests one against a block and returns up to where it is still wanted, or `None`
/// when it is done.
#[inline(always)]
fn walk<B: Block, E: Real>(
    tree: &Tree<B>,
    lanes: &Lanes,
    bits: u32,
    mut t_best: [f32; RAYS],
    stacks: &mut Stacks,
    mut leaf: impl FnMut(&B, usize, &OneRay<E>) -> Option<f32>,
) {
    if tree.root == Child::NONE {
        return;
    }
    let list = List::default();
    let (len, child) = ([0; RAYS], [tree.root; RAYS]);
    let mut walk = Walk { tree, stacks, len, child, nodes: list, blocks: list, pops: list };
    for i in (0..RAYS).filter(|i| bits >> i & 1 != 0) {
        walk.nodes.push_if(i, !tree.root.is_leaf());
        walk.blocks.push_if(i, tree.root.is_leaf());
    }
    while walk.nodes.len + walk.blocks.len + walk.pops.len > 0 {
        for k in 0..walk.nodes.take() {
            let i = walk.nodes.at(k);
            walk.step(i, &lanes.ray::<E>(i), t_best[i]);
            walk.pop(i, t_best[i]);
        }
        for k in 0..walk.blocks.take() {
            let i = walk.blocks.at(k);
            if let Some(t) = leaf(&tree.blocks[walk.child[i].index()], i, &lanes.ray(i)) {
                t_best[i] = t;
                walk.pops.push_if(i, true);
            }
        }
        for k in 0..walk.pops.take() {
            let i = walk.pops.at(k);
            walk.pop(i, t_best[i]);
        }
    }
}

impl Mode for Stream {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        if R::WIDTH == 1 {
            return Single::closest(accel, setup, active, hit);
        }
        let lanes = Lanes::new(setup, hit.t);
        let mut best = lanes.t_max.map(|t| OneHit { t, primitive: MISS, u: 0.0, v: 0.0 });
        STACKS.with_borrow_mut(|stacks| {
            let bits = active.bits();
            walk::<_, R::Eight>(&accel.triangle_tree, &lanes, bits, lanes.t_max, stacks, |block, i, ray| {
                block.closest_one(ray, &mut best[i]);
                Some(best[i].t)
            });
            let t_best = core::array::from_fn(|i| best[i].t);
            walk::<_, R::Eight>(&accel.sphere_tree, &lanes, bits, t_best, stacks, |block, i, ray| {
                block.closest_one(ray, &mut best[i]);
                Some(best[i].t)
            });
        });
        *hit = Hit {
            t: R::from_fn(|i| best[i].t),
            primitive: R::Bits::from_fn(|i| best[i].primitive),
            u: R::from_fn(|i| best[i].u),
            v: R::from_fn(|i| best[i].v),
        };
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        if R::WIDTH == 1 {
            return Single::any(accel, setup, t_max, active);
        }
        let lanes = Lanes::new(setup, t_max);
        let mut found = 0;
        STACKS.with_borrow_mut(|stacks| {
            let t_max = lanes.t_max;
            walk::<_, R::Eight>(&accel.triangle_tree, &lanes, active.bits(), t_max, stacks, |block, i, ray| {
                found |= u32::from(block.any_one(ray, ray.t_max)) << i;
                (found >> i & 1 == 0).then_some(ray.t_max)
            });
            walk::<_, R::Eight>(&accel.sphere_tree, &lanes, active.bits() & !found, t_max, stacks, |block, i, ray| {
                found |= u32::from(block.any_one(ray, ray.t_max)) << i;
                (found >> i & 1 == 0).then_some(ray.t_max)
            });
        });
        R::Mask::from_bits(found)
    }
}

/// Rays that start within this of each other, per axis, count as neighbours.
const NEIGHBOURS: f32 = 1.0 / 32.0;

/// Do the rays start beside each other and go into the same octant?
#[inline(always)]
fn coherent<R: Real>(setup: &RaySetup<R>, active: R::Mask) -> bool {
    let all = active.bits();
    let same_octant = (0..3).all(|k| {
        let negative = (setup.negative[k] & active).bits();
        negative == 0 || negative == all
    });
    let among = |value: R, other: f32| R::select(active, value, R::splat(other));
    let spread = |o: R| among(o, f32::NEG_INFINITY).highest() - among(o, f32::INFINITY).lowest();
    same_octant && setup.origin.iter().all(|&o| spread(o) <= NEIGHBOURS)
}

impl Mode for Shadow {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        Stream::closest(accel, setup, active, hit)
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        if coherent(setup, active) {
            Packet::any(accel, setup, t_max, active)
        } else {
            Stream::any(accel, setup, t_max, active)
        }
    }
}
