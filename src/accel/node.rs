//! A tree node of eight children.

use super::tree::OneRay;
use crate::geometry::Bounds;
use crate::geometry::slab::{FAR_PAD, slab};
use crate::lane::array::from_fn;
use crate::lane::{Bits, Real, axes};

/// What a node's child slot, or a tree's root, refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child(pub u32);

impl Child {
    pub const LEAF: u32 = 1 << 30;
    /// A root with nothing below it.
    pub const NONE: Self = Self(1 << 31);
    /// What a ray finds on its stack below all children.
    pub const DONE: Self = Self(3 << 30);

    pub fn node(index: usize) -> Self {
        Self(index as u32)
    }
    pub fn leaf(block: usize) -> Self {
        Self(block as u32 | Self::LEAF)
    }
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.kind() == 1
    }
    /// 0 for a node, 1 for a block, 2 for [`Child::NONE`], 3 for [`Child::DONE`].
    #[inline(always)]
    pub fn kind(self) -> u32 {
        self.0 >> 30
    }
    /// Index of the node or block.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & (Self::LEAF - 1)) as usize
    }
}

/// A ray as the test of a node's children takes it.
pub struct Crossing<E: Real> {
    pub origin: [E; 3],
    /// −1/d: planes are what is subtracted, so that their loads fold into the subtraction.
    pub against: [E; 3],
    /// By axis, 8 where the direction is negative, else 0: where the near planes are among its 16.
    pub near: [usize; 3],
    /// [`OneRay::octant`].
    pub octant: usize,
}

/// The bounds of eight boxes: by axis the lower ones, then the upper ones.
pub type Planes = [[f32; 16]; 3];

/// Four cache lines. Empty slots have [`Bounds::EMPTY`], which no usable ray enters.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Of the children.
    pub planes: Planes,
    /// [`Child`] words.
    pub children: [u32; 8],
    /// For each octant of directions (bit k set: component k negative) the children from the farthest to the nearest,
    /// three bits each, the first lowest; empty slots first. Bits 24 … 27 of every word: the number of children.
    pub order: [u32; 8],
}

impl Node {
    pub fn new(children: &[(Child, Bounds)]) -> Self {
        let mut node = Self { planes: [[0.0; 16]; 3], children: [0; 8], order: [0; 8] };
        for slot in 0..8 {
            let bounds = children.get(slot).map_or(Bounds::EMPTY, |c| c.1);
            for axis in 0..3 {
                node.planes[axis][slot] = bounds.lo[axis];
                node.planes[axis][8 + slot] = bounds.hi[axis];
            }
        }
        for (slot, (child, _)) in children.iter().enumerate() {
            node.children[slot] = child.0;
        }
        node.order = orders(children);
        node
    }

    /// Where a ray enters and leaves the children from `slot` on; see [`slab`].
    #[inline(always)]
    pub fn enter<E: Real>(&self, ray: &OneRay<E>, slot: usize) -> (E, E) {
        let plane = |k: usize, upper: usize| E::load(&self.planes[k][8 * upper + slot..]);
        let near = axes(|k| plane(k, ray.negative[k]));
        let far = axes(|k| plane(k, 1 - ray.negative[k]));
        slab(near, far, ray.setup.origin, ray.setup.inverse)
    }

    /// Where a ray enters and leaves the children, as [`slab`] computes it, but for the sign of zero and the padding; it
    /// leaves none after `t_best`.
    #[inline(always)]
    fn crossed<E: Real>(&self, ray: &Crossing<E>, t_best: E) -> (E, E) {
        let distance = |k: usize, near: usize| (ray.origin[k] - E::load(&self.planes[k][near..])) * ray.against[k];
        let (mut t_near, mut t_far) = (E::zero(), t_best);
        for k in 0..3 {
            t_near = distance(k, ray.near[k]).max_or(t_near);
            t_far = distance(k, ray.near[k] ^ 8).min_or(t_far);
        }
        (t_near, t_far)
    }

    /// The children that a ray enters before `t_best` (but for the padding), as bits in the octant's order (the nearest is the
    /// highest), where it enters them, and all the child words, in that order.
    #[inline(always)]
    pub fn entered<E: Real>(&self, ray: &Crossing<E>, t_best: E) -> (u32, E, E::Bits) {
        let order = E::Bits::unpack_octal(self.order[ray.octant]);
        let (t_near, t_far) = self.crossed(ray, t_best);
        let (t_near, t_far) = (t_near.permute(order), t_far.permute(order) * E::splat(FAR_PAD));
        let bits = t_near.le_bits(t_far);
        (bits, t_near, E::from_bits(E::Bits::load(&self.children)).permute(order).to_bits())
    }

    /// The children that a ray enters before `t_max` (but for the padding), as bits.
    #[inline(always)]
    pub fn met<E: Real>(&self, ray: &Crossing<E>, t_max: E) -> u32 {
        let (t_near, t_far) = self.crossed(ray, t_max);
        t_near.le_bits(t_far * E::splat(FAR_PAD))
    }

    #[inline(always)]
    pub fn count(&self) -> usize {
        (self.order[0] >> 24) as usize
    }
}

/// [`Node::order`]. A child's place is the number of those that are farther, of equals those before it: no branch on it.
fn orders(children: &[(Child, Bounds)]) -> [u32; 8] {
    let count = children.len();
    let mut middles = [[0.0; 3]; 8];
    for (middle, (_, bounds)) in middles.iter_mut().zip(children) {
        *middle = axes(|k| 0.5 * bounds.lo[k] + 0.5 * bounds.hi[k]);
    }
    let empty = (count..8).enumerate().fold(0, |word, (i, slot)| word | (slot as u32) << (3 * i));
    let mut orders = [empty | (count as u32) << 24; 8];
    for octant in 0..4 {
        let nearness: [f32; 8] = from_fn(|slot| {
            let [x, y, z] = axes(|k| if octant >> k & 1 != 0 { middles[slot][k] } else { -middles[slot][k] });
            x + y + z
        });
        for slot in 0..count {
            let below =
                |other: usize| nearness[other] < nearness[slot] || nearness[other] == nearness[slot] && other < slot;
            let place: usize = (0..count).map(|other| usize::from(below(other))).sum();
            orders[octant] |= (slot as u32) << (3 * (8 - count + place));
            // The other way everything is the other way round.
            orders[7 - octant] |= (slot as u32) << (3 * (7 - place));
        }
    }
    orders
}
