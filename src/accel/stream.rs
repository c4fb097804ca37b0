//! Many rays in flight, one step each in turn.
//!
//! A single ray waits for itself: which node comes next depends on the last test, 34 cycles for 4 of arithmetic, and on
//! branches no predictor knows. Here each ray is in one of three lists (at a node, at a block, looking for its next child)
//! and a step moves it to another by arithmetic instead of a branch, so that the steps of different rays overlap, and what
//! a ray needs next is fetched while the others move. Work is cut into short loops over a list, each of which stores where
//! it is known beforehand: a processor overlaps some three node tests, and only if nothing is stored at an address that
//! one of them has yet to find.

use super::best::Best;
use super::flight::{FLIGHT, FLOOR, Flight, RAYS, Rays, Stacks, board, packet_of};
use super::lanes::Lanes;
use super::leaves::Leaves;
use super::lists::{BLOCKS, Chosen, Counts, Lists, NODES, POPS};
use super::node::{Child, Node};
use super::tree::{Block, Tree};
use super::visits::any_from_root;
use super::{Accel, Mode, Single, Stream};
use crate::geometry::{Hit, Ray, RaySetup};
use crate::lane::{Bits, Mask, Real};
use core::hint::select_unpredictable;

/// The rays of a flight on their way through a tree.
struct Walk<'a, B> {
    tree: &'a Tree<B>,
    stacks: &'a mut Stacks,
    /// [`Flight::top`], of which this is a copy: where steps are inlined, each would wait for the last one's stores through a
    /// reference.
    top: [u32; RAYS],
    lists: &'a mut Lists,
    chosen: &'a mut Chosen,
}

impl<B: Block> Walk<'_, B> {
    /// Sends the first rays of a list that was [taken](Counts::take) to the last child of their stacks if they enter it
    /// before their best hit, and else to look for another.
    ///
    /// A loop of its own: what was stored is known when the step before it is finished, and until then the processor would
    /// hold back whatever is read after it. So is the sorting that follows, eight rays at a time and without a branch.
    #[inline(always)]
    fn send<E: Real>(&mut self, counts: &mut Counts, kind: usize, count: usize, best: &Best) {
        let (rays, chosen) = (&self.lists.of(kind).0[..count], self.chosen.of(count));
        for k in 0..count {
            let ray = rays[k] as usize % RAYS;
            let place = self.top[ray] as usize;
            let (t_near, child) = (self.stacks.t_near[place], self.stacks.child[place]);
            chosen[k] = select_unpredictable(t_near <= best.t(ray), child, Child::NONE.0);
        }
        let before = *counts;
        self.lists.sort::<E>(counts, kind, count, self.chosen);
        if self.tree.far {
            // By kind: then nobody's child is fetched, and no choice is made for each.
            for child in self.lists.listed(NODES, before, *counts) {
                self.tree.prefetch_node(Child(*child));
            }
            for child in self.lists.listed(BLOCKS, before, *counts) {
                self.tree.prefetch_block(Child(*child));
            }
        }
    }

    /// Tests the children of the nodes that the first rays of the list are at and pushes those that are entered before their
    /// best hits, the nearest last. The tops are left at the last child, which is an older one where none is entered.
    ///
    /// Not inlined where registers are few: among the other loops this one would keep in memory what it needs for each node.
    #[cfg_attr(not(target_feature = "avx512vl"), inline(never))]
    #[cfg_attr(target_feature = "avx512vl", inline(always))]
    fn step_all<E: Real>(&mut self, count: usize, lanes: &Lanes<RAYS>, best: &Best) {
        let Walk { tree, stacks, top, lists, .. } = self;
        let (rays, nodes) = lists.of(NODES);
        let (rays, nodes) = (&rays[..count], &nodes[..count]);
        for k in 0..count {
            // Everything that can be out of bounds first: what follows is one block, whose loads fold into broadcasts.
            let node: &Node = &tree.nodes[Child(nodes[k]).index()];
            let i = rays[k] as usize % RAYS;
            let top = &mut top[i];
            let first = *top as usize;
            let t_nears = &mut stacks.t_near[first..first + 8];
            let children = &mut stacks.child[first..first + 8];
            let (bits, t_near, words) = node.entered(&lanes.crossing::<E>(i), E::splat(best.t(i)));
            t_near.compress(bits).store(t_nears);
            E::from_bits(words).compress(bits).to_bits().store(children);
            *top = (*top + bits.count_ones()) - 1;
        }
    }

    /// Takes from the stacks of the first rays of a list those of the last eight children that they enter no more.
    #[inline(always)]
    fn pop_all<E: Real>(&mut self, kind: usize, count: usize, best: &Best) {
        for ray in self.lists.rays(kind, count) {
            let below = self.top[ray] as usize - FLOOR;
            let open = E::load(&self.stacks.t_near[below..]).le_bits(E::splat(best.t(ray)));
            self.top[ray] = below as u32 + (open | 1).ilog2();
        }
    }
}

/// The closest hits of the rays of `bits` in a tree, beside what they have already.
#[inline(always)]
fn walk<B: Block, R: Real>(tree: &Tree<B>, flight: &mut Flight, bits: Rays) {
    if tree.root == Child::NONE {
        return;
    }
    let Flight { lanes, best, stacks, top, candidates, lists, chosen, .. } = flight;
    let mut walk = Walk { tree, stacks, top: *top, lists, chosen };
    let mut counts = Counts::default();
    for k in 0..RAYS / R::WIDTH {
        walk.lists.add::<R>(&mut counts, k * R::WIDTH, packet_of::<R>(bits, k).bits(), tree.root);
    }
    while !counts.none() {
        let nodes = counts.take(NODES);
        walk.step_all::<R::Eight>(nodes, lanes, best);
        walk.send::<R::Eight>(&mut counts, NODES, nodes, best);
        let blocks = counts.take(BLOCKS);
        let (rays, children) = walk.lists.of(BLOCKS);
        let leaves = Leaves { tree, rays, children };
        let found = leaves.edges::<R::Eight>(blocks, lanes, candidates);
        leaves.meet::<R::Eight>(found, lanes, candidates, best);
        walk.pop_all::<R::Eight>(BLOCKS, blocks, best);
        walk.send::<R::Eight>(&mut counts, BLOCKS, blocks, best);
        let pops = counts.take(POPS);
        walk.pop_all::<R::Eight>(POPS, pops, best);
        walk.send::<R::Eight>(&mut counts, POPS, pops, best);
    }
}

/// The closest hits of at most [`RAYS`] rays.
#[inline(never)]
fn closest<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
    FLIGHT.with_borrow_mut(|flight| {
        let bits = board(flight, rays, active, Flight::for_closest);
        walk::<_, R>(&accel.triangle_tree, flight, bits);
        if accel.sphere_tree.root != Child::NONE {
            flight.empty_stacks(0, rays.len() * R::WIDTH);
            walk::<_, R>(&accel.sphere_tree, flight, bits);
        }
        for (k, hit) in hits.iter_mut().enumerate() {
            *hit = flight.best.packet(k * R::WIDTH);
        }
    })
}

/// Which of at most [`RAYS`] rays hit anything.
#[inline(never)]
fn any<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
    FLIGHT.with_borrow_mut(|flight| {
        let bits = board(flight, rays, active, Flight::for_any);
        let mut all = any_from_root::<_, R>(&accel.triangle_tree, flight, bits);
        all |= any_from_root::<_, R>(&accel.sphere_tree, flight, bits & !all);
        for (k, found) in found.iter_mut().enumerate() {
            *found = packet_of::<R>(all, k);
        }
    })
}

impl Mode for Stream {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        Self::closest_many(accel, &[setup.ray(hit.t)], &[active], core::slice::from_mut(hit))
    }
    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        let mut found = active;
        Self::any_many(accel, &[setup.ray(t_max)], &[active], core::slice::from_mut(&mut found));
        found
    }
    #[inline(always)]
    fn closest_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
        if R::WIDTH == 1 {
            return Single::closest_many(accel, rays, active, hits);
        }
        let packets = RAYS / R::WIDTH;
        for ((rays, active), hits) in rays.chunks(packets).zip(active.chunks(packets)).zip(hits.chunks_mut(packets)) {
            closest(accel, rays, active, hits);
        }
    }
    #[inline(always)]
    fn any_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
        if R::WIDTH == 1 {
            return Single::any_many(accel, rays, active, found);
        }
        let packets = RAYS / R::WIDTH;
        for ((rays, active), found) in rays.chunks(packets).zip(active.chunks(packets)).zip(found.chunks_mut(packets)) {
            any(accel, rays, active, found);
        }
    }
}
