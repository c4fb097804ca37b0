//! Shadow rays: together where they go the same way, each on its own from where they part.

use super::flight::{FLIGHT, Flight, RAYS, Rays, board, packet_of};
use super::interval::{Interval, Segments};
use super::lanes::ones;
use super::node::{Child, Node};
use super::tree::{Block, PacketRay, STACK, Tree};
use super::visits::{MOST, any_from_root, any_of};
use super::{Accel, Mode, Shadow, Single, Stream};
use crate::geometry::slab::slab;
use crate::geometry::{Hit, Ray, RaySetup};
use crate::lane::{MAX_WIDTH, Mask, Real, axes};
use std::cell::RefCell;

/// Where no more than this many of 16 lanes enter a child they leave the packet for it. Found by measuring.
const FEW: usize = 6;

/// Children that a packet may leave at most.
const LEFT: usize = 64;

// What all packets of a flight leave fits the lists of visits.
const _: () = assert!(LEFT * FEW * (RAYS / MAX_WIDTH) <= MOST);

/// A child still to visit, and the lanes that enter it.
#[derive(Clone, Copy)]
struct Entry {
    child: Child,
    lanes: u32,
}

thread_local! {
    // What a walk leaves behind is never read.
    static ENTRIES: RefCell<[Entry; STACK]> = const { RefCell::new([Entry { child: Child::NONE, lanes: 0 }; STACK]) };
}

/// What leaves out most boxes that no lane of a packet enters, eight at a time.
trait Around<R: Real> {
    fn entered(&self, node: &Node) -> u32;
    fn places<B: Block>(&self, block: &B) -> u32;
    /// [`RaySetup::slab`] of a child.
    fn enter(&self, node: &Node, slot: usize, setup: &RaySetup<R>) -> (R, R);
}

/// Of lanes that go into one octant.
struct Beam<E: Real> {
    interval: Interval<E>,
    negative: [usize; 3],
    farthest: f32,
}

impl<R: Real> Around<R> for Beam<R::Eight> {
    #[inline(always)]
    fn entered(&self, node: &Node) -> u32 {
        self.interval.entered(&node.planes, self.farthest)
    }
    #[inline(always)]
    fn places<B: Block>(&self, block: &B) -> u32 {
        block.places(Some(&self.interval), self.farthest)
    }
    #[inline(always)]
    fn enter(&self, node: &Node, slot: usize, setup: &RaySetup<R>) -> (R, R) {
        let plane = |k: usize, upper: usize| R::splat(node.planes[k][8 * upper + slot]);
        let near = axes(|k| plane(k, self.negative[k]));
        let far = axes(|k| plane(k, 1 - self.negative[k]));
        slab(near, far, setup.origin, setup.inverse)
    }
}

impl<R: Real> Around<R> for Segments<R::Eight> {
    #[inline(always)]
    fn entered(&self, node: &Node) -> u32 {
        self.meet(&node.planes)
    }
    #[inline(always)]
    fn places<B: Block>(&self, block: &B) -> u32 {
        block.places_about(self)
    }
    #[inline(always)]
    fn enter(&self, node: &Node, slot: usize, setup: &RaySetup<R>) -> (R, R) {
        let plane = |k: usize, upper: usize| R::splat(node.planes[k][8 * upper + slot]);
        setup.slab(axes(|k| plane(k, 0)), axes(|k| plane(k, 1)))
    }
}

/// What a packet leaves to its rays.
struct Left {
    /// A node's children may be stored past the last.
    entries: [Entry; LEFT + 8],
    len: usize,
}

impl Left {
    /// Lays out the packet of rays `first` … if there is anything left to the lanes that are `open`, and lists their visits; the
    /// lanes that then have some.
    #[inline(always)]
    fn board<R: Real>(&self, flight: &mut Flight, first: usize, setup: &RaySetup<R>, t_max: R, open: R::Mask) -> u32 {
        if self.len == 0 {
            return 0;
        }
        flight.for_any(first, setup, t_max);
        let open = open.bits();
        let entries = self.entries[..self.len].iter().map(|entry| (entry.child, entry.lanes & open));
        flight.visits.add::<R>(first, entries);
        open
    }
}

/// Walks the tree for any hits: `leaf` tests places of a block against the lanes that enter it, and returns the lanes still
/// wanted. Children that few lanes enter are `left` to those, while there is room.
///
/// The lanes are tested against the children of a node at once and without a branch, since what some lane of 16 meets is
/// anybody's guess.
#[inline(always)]
fn walk<B: Block, R: Real>(
    tree: &Tree<B>,
    setup: &RaySetup<R>,
    around: impl Around<R>,
    active: R::Mask,
    t_max: R,
    left: &mut Left,
    mut leaf: impl FnMut(&B, u32, R::Mask) -> R::Mask,
) {
    ENTRIES.with_borrow_mut(|stack| {
        let (mut open, mut len) = (active.bits(), usize::from(tree.root != Child::NONE));
        stack[0] = Entry { child: tree.root, lanes: open };
        left.len = 0;
        while let Some(last) = len.checked_sub(1) {
            len = last;
            let Entry { child, lanes } = stack[len];
            let lanes = lanes & open;
            if lanes == 0 {
                continue;
            }
            if child.is_leaf() {
                let block = &tree.blocks[child.index()];
                open = leaf(block, around.places(block), R::Mask::from_bits(lanes)).bits();
                continue;
            }
            let node = &tree.nodes[child.index()];
            let entries = &mut stack[len..len + 8];
            let leaves = &mut left.entries[left.len..left.len + 8];
            let few = if left.len + 8 <= LEFT { R::WIDTH * FEW / MAX_WIDTH } else { 0 };
            let (mut count, mut count_left) = (0, 0);
            for slot in ones(around.entered(node)) {
                let slot = slot % 8;
                let (t_near, t_far) = around.enter(node, slot, setup);
                let lanes = t_near.le_bits(t_far.min_or(t_max)) & lanes;
                if tree.far {
                    tree.prefetch(Child(node.children[slot]));
                }
                let entry = Entry { child: Child(node.children[slot]), lanes };
                let many = lanes.count_ones() as usize > few;
                entries[count % 8] = entry;
                leaves[count_left % 8] = entry;
                count += usize::from(many);
                count_left += usize::from(!many & (lanes != 0));
            }
            len += count;
            left.len += count_left;
        }
    })
}

/// The lanes of a packet that have hit nothing of a tree as far as it holds together; what is `left` they visit on their own.
#[inline(always)]
fn together<B: Block, R: Real>(
    tree: &Tree<B>,
    left: &mut Left,
    setup: &RaySetup<R>,
    t_max: R,
    active: R::Mask,
) -> R::Mask {
    let ray = PacketRay::new(setup, active);
    let mut open = active;
    let leaf = |block: &B, places: u32, inside: R::Mask| {
        open = open & !block.any_packet(&ray, places, t_max, inside & open);
        open
    };
    let interval = Interval::<R::Eight>::new(setup, ray.negative, active);
    if let (Some(interval), Some(negative)) = (interval, ray.negative) {
        let farthest = R::select(active, t_max, R::zero()).highest();
        walk(tree, setup, Beam { interval, negative, farthest }, active, t_max, left, leaf);
    } else {
        walk(tree, setup, Segments::new(setup, t_max, active), active, t_max, left, leaf);
    }
    open
}

/// At most [`RAYS`] rays.
#[inline(never)]
fn any<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
    FLIGHT.with_borrow_mut(|flight| {
        let (mut all, mut hidden, mut visiting) = (0, 0, 0);
        let mut left = Left { entries: [Entry { child: Child::NONE, lanes: 0 }; LEFT + 8], len: 0 };
        for (k, (ray, active)) in rays.iter().zip(active).enumerate() {
            let (setup, first) = (RaySetup::new(ray), k * R::WIDTH);
            let usable = *active & ray.usable();
            all |= Rays::from(usable.bits()) << first;
            let open = together(&accel.triangle_tree, &mut left, &setup, ray.t_max, usable);
            hidden |= Rays::from((usable & !open).bits()) << first;
            visiting |= Rays::from(left.board(flight, first, &setup, ray.t_max, open)) << first;
        }
        hidden |= any_of::<_, R>(&accel.triangle_tree, flight, visiting);
        if accel.sphere_tree.root != Child::NONE {
            board(flight, rays, active, Flight::for_any);
            hidden |= any_from_root::<_, R>(&accel.sphere_tree, flight, all & !hidden);
        }
        for (k, found) in found.iter_mut().enumerate() {
            *found = packet_of::<R>(hidden, k);
        }
    })
}

impl Mode for Shadow {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        Stream::closest(accel, setup, active, hit)
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        let mut found = active;
        Self::any_many(accel, &[setup.ray(t_max)], &[active], core::slice::from_mut(&mut found));
        found
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
