//! Many rays in flight, one step each in turn.
//!
//! A single ray waits for itself: which node comes next depends on the last test, 34 cycles for 4 of arithmetic, and on
//! branches no predictor knows. Here each ray is in one of four lists (at a node, at a block, at a block where it passes
//! between some triangle's edges, looking for its next child) and a step moves it to another by arithmetic instead of a
//! branch, so that the steps of different rays overlap, and what a ray needs next is fetched while the others move.

use super::flight::{FLIGHT, FLOOR, Flight, RAYS, Stacks, board};
use super::lanes::Lanes;
use super::node::{Child, Node};
use super::tree::{Block, OneHit, OneRay, Tree};
use super::{Accel, Mode, Single, Stream};
use crate::geometry::{Hit, MISS, Ray, RaySetup};
use crate::lane::{Bits, Mask, Real};
use core::hint::select_unpredictable;

/// Rays by what they need next: a node tested, a block tested, a child found.
struct Lists {
    nodes: [u8; RAYS],
    blocks: [u8; RAYS],
    pops: [u8; RAYS],
}

/// How long the lists are: apart from them, so that it stays in registers.
#[derive(Clone, Copy, Default)]
struct Lens {
    nodes: usize,
    blocks: usize,
    pops: usize,
}

/// Appends where `wanted`. Writing over what was already read is fine: a list never overtakes its reader.
#[inline(always)]
fn push_if(list: &mut [u8; RAYS], len: &mut usize, ray: usize, wanted: bool) {
    list[*len % RAYS] = ray as u8;
    *len += usize::from(wanted);
}
#[inline(always)]
fn at(list: &[u8; RAYS], k: usize) -> usize {
    list[k % RAYS] as usize % RAYS
}

struct Walk<'a, B> {
    tree: &'a Tree<B>,
    stacks: &'a mut Stacks,
    /// [`Flight::top`], of which this is a copy: through a reference each step would wait for the last one's stores.
    top: [u32; RAYS],
    child: [Child; RAYS],
    lists: Lists,
}

impl<B: Block> Walk<'_, B> {
    /// Sends ray `i` to `child`, or to look for one if there is `none`.
    #[inline(always)]
    fn send(&mut self, lens: &mut Lens, i: usize, child: Child, some: bool) {
        self.child[i] = child;
        push_if(&mut self.lists.nodes, &mut lens.nodes, i, some & (child.kind() == 0));
        push_if(&mut self.lists.blocks, &mut lens.blocks, i, some & child.is_leaf());
        push_if(&mut self.lists.pops, &mut lens.pops, i, !some);
    }

    /// Sends ray `i` to the nearest child of its stack that is entered before `t_best`, or to look among the next.
    #[inline(always)]
    fn pop<E: Real>(&mut self, lens: &mut Lens, i: usize, t_best: f32) {
        let below = self.top[i] as usize - FLOOR;
        let open = E::load(&self.stacks.t_near[i][below..]).le_bits(E::splat(t_best));
        let place = below + (u32::BITS - open.leading_zeros()).saturating_sub(1) as usize;
        self.top[i] = place as u32;
        self.send(lens, i, Child(self.stacks.child[i][place]), open != 0);
    }

    /// Tests the children of ray `i`'s node, goes to the nearest of those entered before its best hit and pushes the
    /// others.
    #[inline(always)]
    fn step<R: Real>(&mut self, lens: &mut Lens, i: usize, lanes: &Lanes<RAYS>, best: &[OneHit; RAYS]) {
        // Everything that can be out of bounds first: what follows is one block, whose loads fold into broadcasts.
        let node: &Node = &self.tree.nodes[self.child[i].index()];
        let top = self.top[i] as usize;
        let t_nears = &mut self.stacks.t_near[i][top..top + 8];
        let children = &mut self.stacks.child[i][top..top + 8];
        let ray = lanes.ray::<R>(i);
        let (bits, t_near, words) = node.entered(&ray, best[i].t);
        t_near.compress(bits).store(t_nears);
        R::Eight::from_bits(words).compress(bits).to_bits().store(children);
        // The last of what was pushed is the nearest, and stays above the top.
        self.top[i] = top as u32 + bits.count_ones().saturating_sub(1);
        let nearest = node.child_at(ray.octant, (bits | 1).ilog2());
        self.send(lens, i, nearest, bits != 0);
    }
}

/// Walks the rays of `bits` from the root on, or what they were [given](Flight::give). `leaf` tests one against a block
/// that [may be hit](Block::may_hit) and says whether the ray wants more.
#[inline(always)]
pub fn walk<B: Block, R: Real>(
    tree: &Tree<B>,
    flight: &mut Flight,
    bits: u64,
    given: bool,
    leaf: impl Fn(&B, &OneRay<R::Eight>, &mut OneHit) -> bool,
) {
    if tree.root == Child::NONE {
        return;
    }
    let Flight { lanes, best, stacks, top } = flight;
    let lists = Lists { nodes: [0; RAYS], blocks: [0; RAYS], pops: [0; RAYS] };
    let mut walk = Walk { tree, stacks, top: *top, child: [tree.root; RAYS], lists };
    let mut lens = Lens::default();
    for i in (0..RAYS).filter(|i| bits >> i & 1 != 0) {
        push_if(&mut walk.lists.pops, &mut lens.pops, i, given);
        push_if(&mut walk.lists.nodes, &mut lens.nodes, i, !given & !tree.root.is_leaf());
        push_if(&mut walk.lists.blocks, &mut lens.blocks, i, !given & tree.root.is_leaf());
    }
    let mut candidates = [0u8; RAYS];
    while lens.nodes + lens.blocks + lens.pops > 0 {
        for k in 0..core::mem::take(&mut lens.nodes) {
            let i = at(&walk.lists.nodes, k);
            walk.step::<R>(&mut lens, i, lanes, best);
        }
        let mut count = 0;
        for k in 0..core::mem::take(&mut lens.blocks) {
            let i = at(&walk.lists.blocks, k);
            let may_hit = tree.blocks[walk.child[i].index()].may_hit(&lanes.ray::<R::Eight>(i));
            push_if(&mut candidates, &mut count, i, may_hit);
            push_if(&mut walk.lists.pops, &mut lens.pops, i, !may_hit);
        }
        for k in 0..count {
            let i = at(&candidates, k);
            let more = leaf(&tree.blocks[walk.child[i].index()], &lanes.ray(i), &mut best[i]);
            push_if(&mut walk.lists.pops, &mut lens.pops, i, more);
        }
        for k in 0..core::mem::take(&mut lens.pops) {
            let i = at(&walk.lists.pops, k);
            walk.pop::<R::Eight>(&mut lens, i, best[i].t);
        }
    }
}

/// The closest hits of at most [`RAYS`] rays.
#[inline(never)]
fn closest<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
    FLIGHT.with_borrow_mut(|flight| {
        let bits = board(flight, rays, active);
        walk::<_, R>(&accel.triangle_tree, flight, bits, false, |block, ray, best| {
            block.closest_one(ray, best);
            true
        });
        if accel.sphere_tree.root != Child::NONE {
            flight.empty_stacks(0, rays.len() * R::WIDTH);
            walk::<_, R>(&accel.sphere_tree, flight, bits, false, |block, ray, best| {
                block.closest_one(ray, best);
                true
            });
        }
        for (hit, best) in hits.iter_mut().zip(flight.best.chunks_exact(R::WIDTH)) {
            *hit = Hit {
                t: R::from_fn(|i| best[i].t),
                primitive: R::Bits::from_fn(|i| best[i].primitive),
                u: R::from_fn(|i| best[i].u),
                v: R::from_fn(|i| best[i].v),
            };
        }
    })
}

/// Which rays of `bits` hit anything of a tree; those that do not are left.
#[inline(always)]
pub fn any_of<B: Block, R: Real>(tree: &Tree<B>, flight: &mut Flight, bits: u64, given: bool) -> u64 {
    walk::<B, R>(tree, flight, bits, given, |block, ray, best| {
        let hit = block.any_one(ray, ray.t_max);
        best.primitive = select_unpredictable(hit, 0, MISS);
        !hit
    });
    let hit = |i: &usize| bits >> i & 1 != 0 && flight.best[*i].primitive != MISS;
    (0..RAYS).filter(hit).fold(0u64, |bits, i| bits | 1 << i)
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
