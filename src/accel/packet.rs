//! All lanes together through the tree.

use super::interval::Interval;
use super::node::{Child, Node};
use super::tree::{Block, PacketRay, STACK, Tree};
use super::{Accel, Mode, Packet, Single};
use crate::geometry::slab::slab;
use crate::geometry::{Hit, RaySetup};
use crate::lane::{Bits, Mask, Real, axes};

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
/// the distance up to which they are. `left` is offered the lanes that enter a child; where it takes them, the packet
/// goes no further there.
#[inline(always)]
pub fn walk<B: Block, R: Real>(
    tree: &Tree<B>,
    ray: &PacketRay<R>,
    active: R::Mask,
    t_max: R,
    mut left: impl FnMut(Child, R::Mask) -> bool,
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
        if left(child, inside) {
            continue;
        }
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

/// [`walk`] by the bounds of the packet alone, for closest hits: of rays so close that they share an octant nearly all
/// enter what their bounds enter, and a test of each lane costs more than it spares.
#[inline(always)]
fn walk_bounds<B: Block, R: Real>(
    tree: &Tree<B>,
    interval: &Interval<R::Eight>,
    active: R::Mask,
    t_max: R,
    mut leaf: impl FnMut(&B, u32) -> R,
) {
    let farthest = |t: R| R::select(active, t, R::zero()).highest();
    let mut t_best = farthest(t_max);
    let (mut t_nears, mut children) = ([0f32; STACK], [tree.root.0; STACK]);
    let mut len = usize::from(tree.root != Child::NONE && active.any());
    while let Some(last) = len.checked_sub(1) {
        len = last;
        let child = Child(children[len]);
        if t_nears[len] > t_best {
            continue;
        }
        if child.is_leaf() {
            let block = &tree.blocks[child.index()];
            let places = block.places(Some(interval), t_best);
            if places != 0 {
                t_best = farthest(leaf(block, places));
            }
        } else {
            let (bits, t_near, words) = interval.children(&tree.nodes[child.index()], t_best);
            t_near.compress(bits).store(&mut t_nears[len..]);
            <R::Eight as Real>::from_bits(words).compress(bits).to_bits().store(&mut children[len..]);
            len += bits.count_ones() as usize;
        }
    }
}

/// The slab test of one child against all lanes.
#[inline(always)]
fn enter<R: Real>(node: &Node, slot: usize, ray: &PacketRay<R>) -> (R, R) {
    let plane = |k: usize, upper: usize| R::splat(node.planes[2 * k + upper][slot]);
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
fn closest<B: Block, R: Real>(
    tree: &Tree<B>,
    ray: &PacketRay<R>,
    interval: Option<&Interval<R::Eight>>,
    active: R::Mask,
    hit: &mut Hit<R>,
) {
    let t_max = hit.t;
    match interval {
        Some(interval) => walk_bounds(tree, interval, active, t_max, |block, places| {
            block.closest_packet(ray, places, active, hit, t_max);
            hit.t
        }),
        None => walk(
            tree,
            ray,
            active,
            t_max,
            |_, _| false,
            |block, places, inside| {
                block.closest_packet(ray, places, inside, hit, t_max);
                (active, hit.t)
            },
        ),
    }
}

/// The lanes of `open` that hit nothing of a tree before `t_max`.
#[inline(always)]
fn unhidden<B: Block, R: Real>(tree: &Tree<B>, ray: &PacketRay<R>, t_max: R, mut open: R::Mask) -> R::Mask {
    walk(
        tree,
        ray,
        open,
        t_max,
        |_, _| false,
        |block, places, inside| {
            open = open & !block.any_packet(ray, places, t_max, inside & open);
            (open, t_max)
        },
    );
    open
}

impl Mode for Packet {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        if R::WIDTH == 1 {
            return Single::closest(accel, setup, active, hit);
        }
        let ray = PacketRay::new(setup, active);
        let interval = Interval::<R::Eight>::new(setup, ray.negative, active);
        closest(&accel.triangle_tree, &ray, interval.as_ref(), active, hit);
        closest(&accel.sphere_tree, &ray, interval.as_ref(), active, hit);
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
