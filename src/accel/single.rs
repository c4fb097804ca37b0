//! One ray at a time through the tree, against eight boxes or primitives at once.

use super::lanes::Lanes;
use super::leaf::EdgeValues;
use super::node::{Child, Node};
use super::tree::{Block, OneHit, OneRay, STACK, Tree};
use super::{Accel, Mode, Single};
use crate::geometry::{Hit, MISS, RaySetup};
use crate::lane::{Bits, Mask, Real};

/// Children still to visit, with where the ray enters them.
pub struct Stack {
    t_near: [f32; STACK],
    child: [u32; STACK],
    len: usize,
}

impl Stack {
    #[inline(always)]
    pub fn new() -> Self {
        Self { t_near: [0.0; STACK], child: [0; STACK], len: 0 }
    }
    #[inline(always)]
    fn pop(&mut self) -> Option<(f32, Child)> {
        self.len = self.len.checked_sub(1)?;
        Some((self.t_near[self.len], Child(self.child[self.len])))
    }

    /// Pushes the children of `node` that the ray enters before `t_best`, the nearest last.
    #[inline(always)]
    fn push_children<E: Real>(&mut self, node: &Node, ray: &OneRay<E>, t_best: f32) {
        let order = node.order[ray.octant];
        if E::WIDTH == 1 {
            for i in 8 - node.count()..8 {
                let slot = (order >> (3 * i)) as usize & 7;
                let (t_near, t_far) = node.enter(ray, slot);
                if (t_near.le(t_far) & t_near.le(E::splat(t_best))).any() {
                    self.t_near[self.len] = t_near.lane(0);
                    self.child[self.len] = node.children[slot];
                    self.len += 1;
                }
            }
        } else {
            let (t_near, t_far) = node.enter(ray, 0);
            let order = E::Bits::unpack_octal(order);
            let t_far = t_far.min_or(E::splat(t_best));
            // Permute first, compare after: the mask is wanted in the new order.
            let (t_near, t_far) = (t_near.permute(order), t_far.permute(order));
            let children = E::from_bits(E::Bits::load(&node.children)).permute(order);
            let bits = t_near.le(t_far).bits();
            t_near.compress(bits).store(&mut self.t_near[self.len..]);
            children.compress(bits).to_bits().store(&mut self.child[self.len..]);
            self.len += bits.count_ones() as usize;
        }
    }
}

#[inline(always)]
fn closest<B: Block, E: Real>(
    tree: &Tree<B>,
    ray: &OneRay<E>,
    one: &OneRay<f32>,
    stack: &mut Stack,
    best: &mut OneHit,
) {
    let mut edges = EdgeValues::ZERO;
    let mut next = Some((0.0, tree.root));
    while let Some((t_near, child)) = next {
        if t_near <= best.t {
            if child.is_leaf() {
                let block = &tree.blocks[child.index()];
                block.closest_of(block.passed(ray, &mut edges), one, &edges, best);
            } else {
                stack.push_children(&tree.nodes[child.index()], ray, best.t);
            }
        }
        next = stack.pop();
    }
}

#[inline(always)]
fn any<B: Block, E: Real>(tree: &Tree<B>, ray: &OneRay<E>, one: &OneRay<f32>, stack: &mut Stack) -> bool {
    let mut edges = EdgeValues::ZERO;
    let mut next = Some((0.0, tree.root));
    while let Some((_, child)) = next {
        if child.is_leaf() {
            let block = &tree.blocks[child.index()];
            if block.any_of(block.passed(ray, &mut edges), one, &edges) {
                stack.len = 0;
                return true;
            }
        } else {
            stack.push_children(&tree.nodes[child.index()], ray, ray.t_max);
        }
        next = stack.pop();
    }
    false
}

impl Mode for Single {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        let (lanes, mut stack) = (Lanes::new(setup, hit.t), Stack::new());
        let (mut t, mut u, mut v, mut primitive) = (lanes.t_max, [0.0; 16], [0.0; 16], [MISS; 16]);
        let mut bits = active.bits();
        while bits != 0 {
            let i = bits.trailing_zeros() as usize & 15;
            bits &= bits - 1;
            let (ray, one) = (lanes.ray::<R::Eight>(i), lanes.ray::<f32>(i));
            let mut best = OneHit { t: ray.t_max, primitive: MISS, u: 0.0, v: 0.0 };
            if accel.triangle_tree.root != Child::NONE {
                closest(&accel.triangle_tree, &ray, &one, &mut stack, &mut best);
            }
            if accel.sphere_tree.root != Child::NONE {
                closest(&accel.sphere_tree, &ray, &one, &mut stack, &mut best);
            }
            (t[i], u[i], v[i], primitive[i]) = (best.t, best.u, best.v, best.primitive);
        }
        *hit = Hit { t: R::load(&t), primitive: R::Bits::load(&primitive), u: R::load(&u), v: R::load(&v) };
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        let (lanes, mut stack) = (Lanes::new(setup, t_max), Stack::new());
        let (mut bits, mut found) = (active.bits(), 0);
        while bits != 0 {
            let i = bits.trailing_zeros() as usize & 15;
            bits &= bits - 1;
            let (ray, one) = (lanes.ray::<R::Eight>(i), lanes.ray::<f32>(i));
            let hit = accel.triangle_tree.root != Child::NONE && any(&accel.triangle_tree, &ray, &one, &mut stack)
                || accel.sphere_tree.root != Child::NONE && any(&accel.sphere_tree, &ray, &one, &mut stack);
            found |= u32::from(hit) << i;
        }
        R::Mask::from_bits(found)
    }
}
