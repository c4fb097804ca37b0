//! One ray against a block in two steps: all eight places by what is cheap, then one at a time those that passed.
//!
//! A ray passes between the edges of one triangle in a block, seldom of two. That one is met in scalar arithmetic, which
//! needs neither to look for the least of eight distances nor to wait for the lanes that cannot win.

use super::tree::{OneHit, OneRay};
use crate::geometry::slab::slab;
use crate::geometry::{Edges, RaySetup};
use crate::lane::{Real, axes};
use core::hint::select_unpredictable;

/// What the edge test of eight triangles computed, by place.
#[repr(C, align(32))]
#[derive(Clone, Copy)]
pub struct EdgeValues {
    /// See [`Edges::weights`].
    weights: [[f32; 8]; 2],
    sum: [f32; 8],
}

impl EdgeValues {
    pub const ZERO: Self = Self { weights: [[0.0; 8]; 2], sum: [0.0; 8] };

    /// Of places from `i` on.
    #[inline(always)]
    pub fn put<E: Real>(&mut self, i: usize, edges: &Edges<E>) {
        edges.weights[0].store(&mut self.weights[0][i..]);
        edges.weights[1].store(&mut self.weights[1][i..]);
        edges.sum.store(&mut self.sum[i..]);
    }

    /// Of one triangle that the ray passes.
    #[inline(always)]
    pub fn at(&self, place: usize, depths: [f32; 3]) -> Edges<f32> {
        Edges::passed([self.weights[0][place], self.weights[1][place]], self.sum[place], depths)
    }
}

/// Eight primitives of any blocks.
pub struct Found<'a, B> {
    pub blocks: [&'a B; 8],
    pub places: [usize; 8],
    /// What their edge tests computed.
    pub edges: [&'a EdgeValues; 8],
}

impl<B> Found<'_, B> {
    /// Of each, by block and place.
    #[inline(always)]
    pub fn gather<E: Real>(&self, value: impl Fn(&B, usize) -> f32) -> E {
        E::from_fn(|l| value(self.blocks[l], self.places[l]))
    }
    /// Of triangles whose vertices have these `depths`.
    #[inline(always)]
    pub fn edges<E: Real>(&self, depths: [E; 3]) -> Edges<E> {
        let value = |of: fn(&EdgeValues) -> &[f32; 8]| E::from_fn(|l| of(self.edges[l])[self.places[l]]);
        Edges::passed([value(|e| &e.weights[0]), value(|e| &e.weights[1])], value(|e| &e.sum), depths)
    }
}

/// Up to eight primitives side by side, as one ray meets them.
pub trait Leaf: Sized {
    /// Cheaply, the places that one ray can hit, as bits: all others it does not. What `meet` and `meet_one` need of the
    /// work goes to `edges`. `E` is the width that the eight are taken in.
    fn passed<E: Real>(&self, ray: &OneRay<E>, edges: &mut EdgeValues) -> u32;

    /// Number of the primitive at a place.
    fn id(&self, place: usize) -> u32;

    /// Eight rays, a lane each, against the primitives at places of eight blocks that were [passed](Leaf::passed): which are
    /// hit, where and with what weights. Hits at or beyond a ray's `t_max` are among them.
    fn meet<E: Real>(found: &Found<'_, Self>, ray: &RaySetup<E>) -> (E::Mask, E, E, E);

    /// One ray against the primitive at a place that was [passed](Leaf::passed): whether it is hit before the ray's `t_max`,
    /// and how.
    fn meet_one(&self, place: usize, ray: &OneRay<f32>, edges: &EdgeValues) -> (bool, OneHit);

    /// The best of the places of `bits`.
    #[inline(always)]
    fn closest_of(&self, mut bits: u32, ray: &OneRay<f32>, edges: &EdgeValues, best: &mut OneHit) {
        while bits != 0 {
            let (hit, found) = self.meet_one(bits.trailing_zeros() as usize % 8, ray, edges);
            best.keep(OneHit { t: select_unpredictable(hit, found.t, OneHit::NEVER), ..found });
            bits &= bits - 1;
        }
    }

    /// Is any of the places of `bits` hit?
    #[inline(always)]
    fn any_of(&self, mut bits: u32, ray: &OneRay<f32>, edges: &EdgeValues) -> bool {
        let mut hit = false;
        while bits != 0 {
            hit |= self.meet_one(bits.trailing_zeros() as usize % 8, ray, edges).0;
            bits &= bits - 1;
        }
        hit
    }
}

impl OneHit {
    /// Takes `found` if it is better.
    #[inline(always)]
    pub fn keep(&mut self, found: Self) {
        let wins = found.key() < self.key();
        self.t = select_unpredictable(wins, found.t, self.t);
        self.primitive = select_unpredictable(wins, found.primitive, self.primitive);
        self.u = select_unpredictable(wins, found.u, self.u);
        self.v = select_unpredictable(wins, found.v, self.v);
    }
}

impl OneRay<f32> {
    /// [`RaySetup::slab`](crate::geometry::RaySetup::slab) of a box, without branches on the signs of the direction.
    #[inline(always)]
    pub fn slab(&self, lo: [f32; 3], hi: [f32; 3]) -> (f32, f32) {
        let pick = |k: usize, a: f32, b: f32| select_unpredictable(self.negative[k] != 0, a, b);
        let near = axes(|k| pick(k, hi[k], lo[k]));
        let far = axes(|k| pick(k, lo[k], hi[k]));
        slab(near, far, self.setup.origin, self.setup.inverse)
    }
}
