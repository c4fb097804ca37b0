//! Shadow rays: together where they go the same way, each on its own from where they part.

use super::flight::{FLIGHT, Flight, RAYS, board};
use super::node::Child;
use super::packet::walk;
use super::stream::any_of;
use super::tree::{Block, PacketRay, STACK, Tree};
use super::{Accel, Mode, Shadow, Single, Stream};
use crate::geometry::{Hit, Ray, RaySetup};
use crate::lane::{Mask, Real, axes};

/// Where no more than one of this many lanes enters a child they leave the packet for it. Found by measuring.
const FEW: usize = 4;

/// A child still to visit, and the lanes that enter it.
#[derive(Clone, Copy)]
struct Entry {
    child: Child,
    lanes: u32,
}

/// [`packet::walk`](walk) for any hits of rays that do not go into the same octant: the children of a node are tested
/// at once and without a branch, since what some lane of 16 meets is anybody's guess.
#[inline(always)]
fn walk_apart<B: Block, R: Real>(
    tree: &Tree<B>,
    ray: &PacketRay<R>,
    active: R::Mask,
    t_max: R,
    mut left: impl FnMut(Child, R::Mask) -> bool,
    mut leaf: impl FnMut(&B, u32, R::Mask) -> R::Mask,
) {
    let mut stack = [Entry { child: tree.root, lanes: active.bits() }; STACK];
    let (mut open, mut len) = (active.bits(), usize::from(tree.root != Child::NONE));
    while let Some(last) = len.checked_sub(1) {
        len = last;
        let Entry { child, lanes } = stack[len];
        let lanes = lanes & open;
        if lanes == 0 || left(child, R::Mask::from_bits(lanes)) {
            continue;
        }
        if child.is_leaf() {
            let block = &tree.blocks[child.index()];
            let all = block.places::<R::Eight>(None, 0.0);
            open = leaf(block, all, R::Mask::from_bits(lanes)).bits();
            continue;
        }
        let node = &tree.nodes[child.index()];
        let entries = &mut stack[len..len + 8];
        let mut count = 0;
        for slot in 0..8 {
            let plane = |k: usize, upper: usize| R::splat(node.planes[2 * k + upper][slot]);
            let (t_near, t_far) = ray.setup.slab(axes(|k| plane(k, 0)), axes(|k| plane(k, 1)));
            let lanes = t_near.le_bits(t_far.min_or(t_max)) & lanes;
            entries[count % 8] = Entry { child: Child(node.children[slot]), lanes };
            count += usize::from(lanes != 0);
        }
        len += count;
    }
}

/// Which rays of a packet, `first` … of the flight, hit anything of a tree: the packet goes as far as it holds together,
/// and the rays finish what it left to them in flight with those of the other packets. Those are added to `given`.
#[inline(always)]
fn together<B: Block, R: Real>(
    tree: &Tree<B>,
    flight: &mut Flight,
    first: usize,
    setup: &RaySetup<R>,
    t_max: R,
    active: R::Mask,
    given: &mut u64,
) -> R::Mask {
    let ray = PacketRay::new(setup, active);
    let mut open = active;
    let mut boarded = false;
    let leave = |child: Child, lanes: R::Mask| {
        let bits = lanes.bits();
        if bits.count_ones() as usize * FEW > R::WIDTH {
            return false;
        }
        if !boarded {
            flight.board(first, setup, t_max);
            boarded = true;
        }
        *given |= u64::from(bits) << first;
        flight.give(first, bits, child)
    };
    let leaf = |block: &B, places: u32, inside: R::Mask| {
        open = open & !block.any_packet(&ray, places, t_max, inside & open);
        open
    };
    if ray.negative.is_some() {
        let mut leaf = leaf;
        walk(tree, &ray, active, t_max, leave, |block, places, inside| (leaf(block, places, inside), t_max));
    } else {
        walk_apart(tree, &ray, active, t_max, leave, leaf);
    }
    active & !open
}

/// At most [`RAYS`] rays.
#[inline(never)]
fn any<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
    FLIGHT.with_borrow_mut(|flight| {
        let (mut all, mut hidden, mut given) = (0u64, 0u64, 0u64);
        let lanes =
            |k: usize, bits: u64| R::Mask::from_bits((bits >> (k * R::WIDTH)) as u32 & (u32::MAX >> (32 - R::WIDTH)));
        for (k, (ray, active)) in rays.iter().zip(active).enumerate() {
            let (setup, first) = (RaySetup::new(ray), k * R::WIDTH);
            let usable = *active & ray.usable();
            all |= u64::from(usable.bits()) << first;
            let hit = together(&accel.triangle_tree, flight, first, &setup, ray.t_max, usable, &mut given);
            hidden |= u64::from(hit.bits()) << first;
        }
        hidden |= any_of::<_, R>(&accel.triangle_tree, flight, given & !hidden, true);
        if accel.sphere_tree.root != Child::NONE {
            board(flight, rays, active);
            hidden |= any_of::<_, R>(&accel.sphere_tree, flight, all & !hidden, false);
        }
        for (k, found) in found.iter_mut().enumerate() {
            *found = lanes(k, hidden);
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
