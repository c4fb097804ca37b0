//! All lanes together through the tree.

use super::node::{Child, Node};
use super::tree::{Block, PacketRay, STACK, Tree};
use super::{Accel, Mode, Packet, Single};
use crate::geometry::slab::{FAR_PAD, slab};
use crate::geometry::{Hit, RaySetup};
use crate::lane::{Bits, Mask, Real, axes};

/// Bounds of what the rays of a packet do, for testing eight boxes against all of them at once.
///
/// Every lane's distance to a plane is fl(fl(plane − o)·inverse) with o and inverse between the bounds here; rounding is
/// monotone, so the extremes over the four corners bound it as computed: a child this drops no lane enters.
struct Interval<E: Real> {
    /// The origin bound that makes planes near early and planes far late.
    near_origin: [E; 3],
    far_origin: [E; 3],
    lowest: [E; 3],
    highest: [E; 3],
    /// 1 where the directions are negative.
    negative: [usize; 3],
}

impl<E: Real> Interval<E> {
    /// `None` where the lanes' signs differ or a component of a direction is so small that its inverse is infinite.
    #[inline(always)]
    fn new<R: Real>(ray: &PacketRay<R>, active: R::Mask) -> Option<Self> {
        let negative = ray.negative?;
        let infinity = R::splat(f32::INFINITY);
        let lowest = axes(|k| R::select(active, ray.setup.inverse[k], infinity).lowest());
        let highest = axes(|k| R::select(active, ray.setup.inverse[k], -infinity).highest());
        if lowest.iter().chain(&highest).any(|x| !x.is_finite()) {
            return None;
        }
        let o_lowest = axes(|k| R::select(active, ray.setup.origin[k], infinity).lowest());
        let o_highest = axes(|k| R::select(active, ray.setup.origin[k], -infinity).highest());
        Some(Self {
            near_origin: axes(|k| E::splat(if negative[k] != 0 { o_lowest[k] } else { o_highest[k] })),
            far_origin: axes(|k| E::splat(if negative[k] != 0 { o_highest[k] } else { o_lowest[k] })),
            lowest: axes(|k| E::splat(lowest[k])),
            highest: axes(|k| E::splat(highest[k])),
            negative,
        })
    }

    /// Slots of the children that some lane may enter before `t_best`, as bits in the node's own order.
    #[inline(always)]
    fn children(&self, node: &Node, t_best: f32) -> (u32, E::Bits) {
        let octant = self.negative[0] | self.negative[1] << 1 | self.negative[2] << 2;
        let (mut t_near, mut t_far) = (E::zero(), E::splat(f32::INFINITY));
        for k in 0..3 {
            let near = E::load(&node.planes[2 * k + self.negative[k]]) - self.near_origin[k];
            let far = E::load(&node.planes[2 * k + 1 - self.negative[k]]) - self.far_origin[k];
            t_near = (near * self.lowest[k]).min_or(near * self.highest[k]).max_or(t_near);
            t_far = (far * self.lowest[k]).max_or(far * self.highest[k]).min_or(t_far);
        }
        let t_far = (t_far * E::splat(FAR_PAD)).min_or(E::splat(t_best));
        let order = E::Bits::unpack_octal(node.order[octant]);
        (t_near.permute(order).le(t_far.permute(order)).bits(), order)
    }
}

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
                let (bits, order) = interval.children(node, t_best);
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

/// Walks the tree; `leaf` tests a block against the lanes that enter it, and returns the lanes still wanted with
/// the distance up to which they are. `left` is offered the lanes that enter a child; where it takes them, the packet
/// goes no further there.
#[inline(always)]
pub fn walk<B: Block, R: Real>(
    tree: &Tree<B>,
    ray: &PacketRay<R>,
    active: R::Mask,
    t_max: R,
    mut left: impl FnMut(Child, R::Mask) -> bool,
    mut leaf: impl FnMut(&B, R::Mask) -> (R::Mask, R),
) {
    if tree.root == Child::NONE || active.none() {
        return;
    }
    if tree.root.is_leaf() {
        leaf(&tree.blocks[tree.root.index()], active);
        return;
    }
    let interval = Interval::<R::Eight>::new(ray, active);
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
            (active, t_best) = leaf(&tree.blocks[child.index()], inside);
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
    let plane = |k: usize, upper: usize| R::splat(node.planes[2 * k + upper][slot]);
    match ray.negative {
        Some(negative) => {
            let (near, far) = (axes(|k| plane(k, negative[k])), axes(|k| plane(k, 1 - negative[k])));
            slab(near, far, ray.setup.origin, ray.setup.inverse)
        }
        None => ray.setup.slab(axes(|k| plane(k, 0)), axes(|k| plane(k, 1))),
    }
}

impl Mode for Packet {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        if R::WIDTH == 1 {
            return Single::closest(accel, setup, active, hit);
        }
        let (ray, t_max) = (PacketRay::new(setup, active), hit.t);
        walk(
            &accel.triangle_tree,
            &ray,
            active,
            hit.t,
            |_, _| false,
            |block, inside| {
                block.closest_packet(&ray, inside, hit, t_max);
                (active, hit.t)
            },
        );
        walk(
            &accel.sphere_tree,
            &ray,
            active,
            hit.t,
            |_, _| false,
            |block, inside| {
                block.closest_packet(&ray, inside, hit, t_max);
                (active, hit.t)
            },
        );
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        if R::WIDTH == 1 {
            return Single::any(accel, setup, t_max, active);
        }
        let (ray, mut open) = (PacketRay::new(setup, active), active);
        walk(
            &accel.triangle_tree,
            &ray,
            active,
            t_max,
            |_, _| false,
            |block, inside| {
                open = open & !block.any_packet(&ray, t_max, inside & open);
                (open, t_max)
            },
        );
        walk(
            &accel.sphere_tree,
            &ray,
            open,
            t_max,
            |_, _| false,
            |block, inside| {
                open = open & !block.any_packet(&ray, t_max, inside & open);
                (open, t_max)
            },
        );
        active & !open
    }
}
