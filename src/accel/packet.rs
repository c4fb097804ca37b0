//! All lanes together through the tree.

use super::group::{Group, PACKETS, side_by_side};
use super::interval::Interval;
use super::node::{Child, Node};
use super::tree::{Block, PacketRay, STACK, Tree};
use super::{Accel, Mode, Packet, Single};
use crate::geometry::slab::slab;
use crate::geometry::{Hit, Ray, RaySetup};
use crate::lane::array::from_fn;
use crate::lane::{Bits, Mask, Real, axes};
use core::array::{from_mut, from_ref};

/// Slots still to visit: node·8 + slot.
struct Stack {
    slot: [u32; STACK],
    len: usize,
}

impl Stack {
    #[inline(always)]
    fn push_children<R: Real>(
        &mut self,
        index: usize,
        node: &Node,
        interval: Option<&Interval<R::Eight>>,
        octant: usize,
        t_best: f32,
    ) {
        let first = (index * 8) as u32;
        match interval {
            Some(interval) => {
                let (bits, order) = interval.slots(node, t_best);
                // `unpack_octal` leaves higher digits above the low three bits.
                let slots = (order & Bits::splat(7)) + Bits::splat(first);
                <R::Eight as Real>::from_bits(slots).compress(bits).to_bits().store(&mut self.slot[self.len..]);
                self.len += bits.count_ones() as usize;
            }
            None => {
                let order = node.order[octant];
                for i in 8 - node.count()..8 {
                    self.slot[self.len] = first + (order >> (3 * i) & 7);
                    self.len += 1;
                }
            }
        }
    }
}

/// Walks the tree; `leaf` tests places of a block against the lanes that enter it, and returns the lanes still wanted with
/// the distance up to which they are.
#[inline(always)]
pub fn walk<B: Block, R: Real>(
    tree: &Tree<B>,
    ray: &PacketRay<R>,
    active: R::Mask,
    t_max: R,
    mut leaf: impl FnMut(&B, u32, R::Mask) -> (R::Mask, R),
) {
    if tree.root == Child::NONE || active.none() {
        return;
    }
    if tree.root.is_leaf() {
        let block = &tree.blocks[tree.root.index()];
        leaf(block, block.places::<R::Eight>(None, 0.0), active);
        return;
    }
    let interval = Interval::<R::Eight>::new(ray.setup, ray.negative, active);
    let first = active.bits().trailing_zeros() as usize % R::WIDTH;
    let octant = (0..3).map(|k| usize::from(ray.setup.negative[k].lane(first)) << k).sum();
    let farthest = |active: R::Mask, t: R| R::select(active, t, R::zero()).highest();
    let (mut active, mut t_best) = (active, t_max);
    let mut t_farthest = farthest(active, t_best);
    let mut stack = Stack { slot: [0; STACK], len: 0 };
    stack.push_children::<R>(tree.root.index(), &tree.nodes[tree.root.index()], interval.as_ref(), octant, t_farthest);
    while let Some(len) = stack.len.checked_sub(1) {
        stack.len = len;
        let (node, slot) = (stack.slot[len] as usize / 8, stack.slot[len] as usize % 8);
        let node = &tree.nodes[node];
        let (t_near, t_far) = enter(node, slot, ray);
        let inside = t_near.le(t_far) & t_near.le(t_best) & active;
        if inside.none() {
            continue;
        }
        let child = Child(node.children[slot]);
        if child.is_leaf() {
            let block = &tree.blocks[child.index()];
            (active, t_best) = leaf(block, block.places(interval.as_ref(), t_farthest), inside);
            if active.none() {
                return;
            }
            t_farthest = farthest(active, t_best);
        } else {
            stack.push_children::<R>(child.index(), &tree.nodes[child.index()], interval.as_ref(), octant, t_farthest);
        }
    }
}

/// The slab test of one child against all lanes.
#[inline(always)]
fn enter<R: Real>(node: &Node, slot: usize, ray: &PacketRay<R>) -> (R, R) {
    let plane = |k: usize, upper: usize| R::splat(node.planes[k][8 * upper + slot]);
    match ray.negative {
        Some(negative) => {
            let (near, far) = (axes(|k| plane(k, negative[k])), axes(|k| plane(k, 1 - negative[k])));
            slab(near, far, ray.setup.origin, ray.setup.inverse)
        }
        None => ray.setup.slab(axes(|k| plane(k, 0)), axes(|k| plane(k, 1))),
    }
}

/// The closest hits of `active` lanes in a tree, beside what `hit` has already.
#[inline(always)]
fn closest<B: Block, R: Real>(tree: &Tree<B>, ray: &PacketRay<R>, active: R::Mask, hit: &mut Hit<R>) {
    let t_max = hit.t;
    walk(tree, ray, active, t_max, |block, places, inside| {
        block.closest_packet(ray, places, inside, hit, t_max);
        (active, hit.t)
    });
}

/// The closest hits of packets, which go together through the tree of triangles if they can.
#[inline(never)]
fn closest_together<R: Real, const N: usize>(
    accel: &Accel,
    rays: &[Ray<R>; N],
    active: &[R::Mask; N],
    hits: &mut [Hit<R>; N],
) {
    let setups = from_fn(|p| RaySetup::new(&rays[p]));
    let active: [R::Mask; N] = from_fn(|p| active[p] & rays[p].usable());
    let group = Group::new(&setups, active);
    if let Some(group) = &group {
        let found = group.closest(&accel.triangle_tree, from_fn(|p| rays[p].t_max));
        for p in 0..N {
            hits[p] = Hit::miss(rays[p].t_max);
            hits[p].replace(active[p], found[p]);
        }
        if accel.sphere_tree.root == Child::NONE {
            return;
        }
    }
    for p in 0..N {
        let ray = PacketRay::new(&setups[p], active[p]);
        if group.is_none() {
            hits[p] = Hit::miss(rays[p].t_max);
            closest(&accel.triangle_tree, &ray, active[p], &mut hits[p]);
        }
        closest(&accel.sphere_tree, &ray, active[p], &mut hits[p]);
    }
}

/// The closest hits of packets, which go through the tree of triangles side by side.
#[inline(never)]
fn closest_side_by_side<R: Real, const N: usize>(
    accel: &Accel,
    rays: &[Ray<R>; N],
    active: &[R::Mask; N],
    hits: &mut [Hit<R>; N],
) {
    let setups: [RaySetup<R>; N] = from_fn(|p| RaySetup::new(&rays[p]));
    let active: [R::Mask; N] = from_fn(|p| active[p] & rays[p].usable());
    let groups: [Option<Group<R, 1>>; N] = from_fn(|p| Group::new(from_ref(&setups[p]), [active[p]]));
    let found = side_by_side(&groups, &accel.triangle_tree, from_fn(|p| rays[p].t_max));
    for p in 0..N {
        let ray = PacketRay::new(&setups[p], active[p]);
        hits[p] = Hit::miss(rays[p].t_max);
        match groups[p] {
            Some(_) => hits[p].replace(active[p], found[p]),
            None => closest(&accel.triangle_tree, &ray, active[p], &mut hits[p]),
        }
        closest(&accel.sphere_tree, &ray, active[p], &mut hits[p]);
    }
}

/// The lanes of `open` that hit nothing of a tree before `t_max`.
#[inline(always)]
fn unhidden<B: Block, R: Real>(tree: &Tree<B>, ray: &PacketRay<R>, t_max: R, mut open: R::Mask) -> R::Mask {
    walk(tree, ray, open, t_max, |block, places, inside| {
        open = open & !block.any_packet(ray, places, t_max, inside & open);
        (open, t_max)
    });
    open
}

impl Mode for Packet {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        if R::WIDTH == 1 {
            return Single::closest(accel, setup, active, hit);
        }
        let mut hits = [*hit];
        closest_together(accel, &[setup.ray(hit.t)], &[active], &mut hits);
        [*hit] = hits;
    }

    #[inline(always)]
    fn closest_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
        if R::WIDTH == 1 {
            return Single::closest_many(accel, rays, active, hits);
        }
        // Of a far tree's small triangles each packet meets others.
        let tree = &accel.triangle_tree;
        let packets = if tree.far && !tree.in_memory { 0 } else { rays.len() / PACKETS * PACKETS };
        let (rays, rays_left) = rays.split_at(packets);
        let (active, active_left) = active.split_at(packets);
        let (hits, hits_left) = hits.split_at_mut(packets);
        let groups = rays.as_chunks::<PACKETS>().0.iter().zip(active.as_chunks::<PACKETS>().0);
        for ((rays, active), hits) in groups.zip(hits.as_chunks_mut::<PACKETS>().0) {
            if tree.in_memory {
                closest_side_by_side(accel, rays, active, hits);
            } else {
                closest_together(accel, rays, active, hits);
            }
        }
        for ((rays, active), hits) in rays_left.iter().zip(active_left).zip(hits_left) {
            closest_together(accel, from_ref(rays), from_ref(active), from_mut(hits));
        }
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        if R::WIDTH == 1 {
            return Single::any(accel, setup, t_max, active);
        }
        let ray = PacketRay::new(setup, active);
        let open = unhidden(&accel.triangle_tree, &ray, t_max, active);
        let open = unhidden(&accel.sphere_tree, &ray, t_max, open);
        active & !open
    }
}
