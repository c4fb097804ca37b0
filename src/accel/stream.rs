//! Many rays in flight, one step each in turn.
//!
//! A single ray waits for itself: which node comes next depends on the last test, 34 cycles for 4 of arithmetic, and on
//! branches no predictor knows. Here each ray is in one of three lists (at a node, at a block, looking for its next child)
//! and a step moves it to another by arithmetic instead of a branch, so that the steps of different rays overlap, and what
//! a ray needs next is fetched while the others move. Work is cut into short loops over a list, each of which stores where
//! it is known beforehand: a processor overlaps some three node tests, and only if nothing is stored at an address that
//! one of them has yet to find.

use super::flight::{Best, Candidates, FLIGHT, FLOOR, Flight, RAYS, Rays, Stacks, board, rays};
use super::lanes::Lanes;
use super::leaf::Found;
use super::lists::{BLOCKS, Chosen, Counts, Lists, NODES, POPS};
use super::node::{Child, Node};
use super::tree::{Block, OneHit, Tree};
use super::{Accel, Mode, Single, Stream};
use crate::geometry::{Hit, MISS, Ray, RaySetup};
use crate::lane::array::{from_fn, map};
use crate::lane::{Bits, Mask, Real};
use core::hint::select_unpredictable;

/// Fewer candidates than this are met one after another, more side by side. Found by measuring.
const FEW: usize = 4;

/// Is told of each candidate: the ray and how it hits, at [`OneHit::NEVER`] if not.
pub trait Keep: Fn(&mut Best, usize, OneHit) {}
impl<F: Fn(&mut Best, usize, OneHit)> Keep for F {}

/// The rays of a flight on their way through a tree.
struct Walk<'a, B> {
    tree: &'a Tree<B>,
    stacks: &'a mut Stacks,
    /// [`Flight::top`], of which this is a copy: through a reference each step would wait for the last one's stores.
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
        for k in 0..count {
            let i = self.lists.ray(kind, k);
            let place = self.top[i] as usize;
            let (t_near, child) = (self.stacks.t_near[place], self.stacks.child[place]);
            let child = Child(select_unpredictable(t_near <= best.t[i], child, Child::NONE.0));
            self.chosen.set(k, child);
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

    /// Tests the children of the node that ray `k` of the list is at and pushes those that are entered before its best hit,
    /// the nearest last. The top is left at the last child, which is an older one where none is entered.
    #[inline(always)]
    fn step<E: Real>(&mut self, k: usize, lanes: &Lanes<RAYS>, best: &Best) {
        // Everything that can be out of bounds first: what follows is one block, whose loads fold into broadcasts.
        let node: &Node = &self.tree.nodes[self.lists.child(NODES, k).index()];
        let i = self.lists.ray(NODES, k);
        let top = self.top[i] as usize;
        let t_nears = &mut self.stacks.t_near[top..top + 8];
        let children = &mut self.stacks.child[top..top + 8];
        let (bits, t_near, words) = node.entered(&lanes.crossing::<E>(i), E::splat(best.t[i]));
        t_near.compress(bits).store(t_nears);
        E::from_bits(words).compress(bits).to_bits().store(children);
        self.top[i] = (top as u32 + bits.count_ones()) - 1;
    }

    /// Takes from the stacks of the first rays of a list those of the last eight children that they enter no more.
    #[inline(always)]
    fn pop_all<E: Real>(&mut self, kind: usize, count: usize, best: &Best) {
        for k in 0..count {
            let i = self.lists.ray(kind, k);
            let below = self.top[i] as usize - FLOOR;
            let open = E::load(&self.stacks.t_near[below..]).le_bits(E::splat(best.t[i]));
            self.top[i] = below as u32 + (open | 1).ilog2();
        }
    }

    /// Lists as candidates what the first `count` rays at blocks may hit there; how many.
    #[inline(always)]
    fn edges<E: Real>(&self, count: usize, lanes: &Lanes<RAYS>, found: &mut Candidates) -> usize {
        let mut passed = [0u32; RAYS];
        for k in 0..count {
            let i = self.lists.ray(BLOCKS, k);
            let block = &self.tree.blocks[self.lists.child(BLOCKS, k).index()];
            passed[k % RAYS] = block.passed(&lanes.ray::<E>(i), &mut found.edges[k % RAYS]);
        }
        let places = E::Bits::load(&[0, 1, 2, 3, 4, 5, 6, 7]);
        let mut len = 0;
        for (k, bits) in passed[..count].iter().enumerate() {
            let all = E::from_bits(places + E::Bits::splat(8 * k as u32));
            all.compress(*bits).to_bits().store(&mut found.words[len..]);
            len += bits.count_ones() as usize;
        }
        // Past the end stands the last again: a hit twice changes nothing.
        if len > 0 {
            E::Bits::splat(found.words[len - 1]).store(&mut found.words[len..]);
        }
        len
    }

    /// Meets the first `len` candidates.
    #[inline(always)]
    fn meet<E: Real>(&self, len: usize, lanes: &Lanes<RAYS>, found: &Candidates, best: &mut Best, keep: impl Keep) {
        let eights = if len % 8 < FEW { len - len % 8 } else { len };
        for first in (0..eights).step_by(8) {
            self.meet_eight::<E>(first, lanes, found, best, &keep);
        }
        for at in eights..len {
            let (k, place) = found.at(at);
            let i = self.lists.ray(BLOCKS, k);
            let block = &self.tree.blocks[self.lists.child(BLOCKS, k).index()];
            let (hit, found) = block.meet_one(place, &lanes.ray(i), &found.edges[k]);
            keep(best, i, OneHit { t: select_unpredictable(hit, found.t, OneHit::NEVER), ..found });
        }
    }

    /// Meets eight candidates from `first` on.
    #[inline(always)]
    fn meet_eight<E: Real>(
        &self,
        first: usize,
        lanes: &Lanes<RAYS>,
        found: &Candidates,
        best: &mut Best,
        keep: impl Keep,
    ) {
        let eight: [_; 8] = from_fn(|l| found.at(first + l));
        let i = map(eight, |(k, _)| self.lists.ray(BLOCKS, k));
        let ray = lanes.gather::<E>(i);
        let blocks = map(eight, |(k, _)| &self.tree.blocks[self.lists.child(BLOCKS, k).index()]);
        let places = map(eight, |(_, place)| place);
        let found = Found { blocks, places, edges: map(eight, |(k, _)| &found.edges[k]) };
        let (hits, t, u, v) = B::meet(&found, &RaySetup::new(&ray));
        let t = E::select(hits & t.lt(ray.t_max), t, E::splat(OneHit::NEVER));
        let mut columns = [[0.0; 8]; 3];
        for (column, values) in columns.iter_mut().zip([t, u, v]) {
            values.store(column);
        }
        let [t, u, v] = columns;
        for (l, i) in i.into_iter().enumerate() {
            keep(best, i, OneHit { primitive: blocks[l].id(places[l]), t: t[l], u: u[l], v: v[l] });
        }
    }
}

/// Walks the rays of `bits` from the root on, or what they were [given](Flight::give). `keep` is told of each that meets a
/// primitive whether it hits, and how.
#[inline(always)]
pub fn walk<B: Block, R: Real>(tree: &Tree<B>, flight: &mut Flight, bits: Rays, given: bool, keep: impl Keep) {
    if tree.root == Child::NONE || bits == 0 {
        return;
    }
    let Flight { lanes, best, stacks, top, candidates, lists, chosen, .. } = flight;
    let mut walk = Walk { tree, stacks, top: *top, lists, chosen };
    let mut counts = Counts::default();
    for i in rays(bits) {
        let kind = if given { POPS } else { tree.root.kind() as usize };
        walk.lists.push(&mut counts, i, tree.root, kind);
    }
    while !counts.none() {
        let nodes = counts.take(NODES);
        for k in 0..nodes {
            walk.step::<R::Eight>(k, lanes, best);
        }
        walk.send::<R::Eight>(&mut counts, NODES, nodes, best);
        let blocks = counts.take(BLOCKS);
        let found = walk.edges::<R::Eight>(blocks, lanes, candidates);
        walk.meet::<R::Eight>(found, lanes, candidates, best, &keep);
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
        let bits = board(flight, rays, active);
        walk::<_, R>(&accel.triangle_tree, flight, bits, false, Best::keep);
        if accel.sphere_tree.root != Child::NONE {
            flight.empty_stacks(0, rays.len() * R::WIDTH);
            walk::<_, R>(&accel.sphere_tree, flight, bits, false, Best::keep);
        }
        for (k, hit) in hits.iter_mut().enumerate() {
            *hit = flight.best.packet(k * R::WIDTH);
        }
    })
}

/// Which rays of `bits` hit anything of a tree; those that do not are left.
#[inline(always)]
pub fn any_of<B: Block, R: Real>(tree: &Tree<B>, flight: &mut Flight, bits: Rays, given: bool) -> Rays {
    walk::<B, R>(tree, flight, bits, given, |best, i, found| {
        let hit = found.t.is_sign_positive();
        best.primitive[i] = select_unpredictable(hit, 0, best.primitive[i]);
        // Nothing on its stack is entered so soon, but the floor.
        best.t[i] = select_unpredictable(hit, f32::NEG_INFINITY, best.t[i]);
    });
    rays(bits).fold(0, |hits, i| hits | Rays::from(flight.best.primitive[i] != MISS) << i)
}

/// Which of at most [`RAYS`] rays hit anything.
#[inline(never)]
fn any<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
    FLIGHT.with_borrow_mut(|flight| {
        let bits = board(flight, rays, active);
        let mut all = any_of::<_, R>(&accel.triangle_tree, flight, bits, false);
        if accel.sphere_tree.root != Child::NONE {
            flight.empty_stacks(0, rays.len() * R::WIDTH);
            all |= any_of::<_, R>(&accel.sphere_tree, flight, bits & !all, false);
        }
        for (k, found) in found.iter_mut().enumerate() {
            *found = R::Mask::from_bits((all >> (k * R::WIDTH)) as u32 & (u32::MAX >> (32 - R::WIDTH)));
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
