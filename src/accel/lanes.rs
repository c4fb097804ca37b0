//! Rays laid out by value, to be taken one at a time.

use super::node::Crossing;
use super::tree::OneRay;
use crate::geometry::{Ray, RaySetup, Shear};
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3, axes};

/// `N` rays: a packet, or all that are in flight together.
pub struct Lanes<const N: usize> {
    origin: [[f32; N]; 3],
    direction: [[f32; N]; 3],
    inverse: [[f32; N]; 3],
    /// See [`Crossing::against`] and [`Crossing::near`].
    against: [[f32; N]; 3],
    near: [[u32; N]; 3],
    /// See [`OneRay::octant`].
    octant: [u32; N],
    order: [[u32; N]; 3],
    shear_origin: [[f32; N]; 3],
    shear_scale: [[f32; N]; 3],
    pub t_max: [f32; N],
}

/// Writes a register to places `first` …
#[inline(always)]
fn put<R: Real>(x: R, to: &mut [f32], first: usize) {
    x.store(&mut to[first..first + R::WIDTH]);
}

impl<const N: usize> Lanes<N> {
    pub const ZERO: Self = Self {
        origin: [[0.0; N]; 3],
        direction: [[0.0; N]; 3],
        inverse: [[0.0; N]; 3],
        against: [[0.0; N]; 3],
        near: [[0; N]; 3],
        octant: [0; N],
        order: [[0; N]; 3],
        shear_origin: [[0.0; N]; 3],
        shear_scale: [[0.0; N]; 3],
        t_max: [0.0; N],
    };

    /// A packet goes to places `first` …
    #[inline(always)]
    pub fn set<R: Real>(&mut self, first: usize, setup: &RaySetup<R>, t_max: R) {
        for k in 0..3 {
            put(setup.origin[k], &mut self.origin[k], first);
            put(setup.direction[k], &mut self.direction[k], first);
            put(setup.inverse[k], &mut self.inverse[k], first);
            put(-setup.inverse[k], &mut self.against[k], first);
            put(setup.shear.origin[k], &mut self.shear_origin[k], first);
            put(setup.shear.scale[k], &mut self.shear_scale[k], first);
            setup.order[k].store(&mut self.order[k][first..first + R::WIDTH]);
            let near = R::Bits::select(setup.negative[k], R::Bits::splat(8), R::Bits::splat(0));
            near.store(&mut self.near[k][first..first + R::WIDTH]);
        }
        let bit = |k: usize| R::Bits::select(setup.negative[k], R::Bits::splat(1 << k), R::Bits::splat(0));
        (bit(0) | bit(1) | bit(2)).store(&mut self.octant[first..first + R::WIDTH]);
        put(t_max, &mut self.t_max, first);
    }
    /// Ray `i` for nodes.
    #[inline(always)]
    pub fn crossing<E: Real>(&self, i: usize) -> Crossing<E> {
        let splat = |v: &[[f32; N]; 3]| axes(|k| E::splat(v[k][i]));
        Crossing {
            origin: splat(&self.origin),
            against: splat(&self.against),
            near: axes(|k| self.near[k][i] as usize & 8),
            octant: self.octant[i] as usize & 7,
        }
    }
    /// The rays `i`, a lane each.
    #[inline(always)]
    pub fn gather<E: Real>(&self, i: [usize; 8]) -> Ray<E> {
        let of = |column: &[f32; N]| E::from_fn(|l| column[i[l]]);
        let vector = |v: &[[f32; N]; 3]| Vec3::new(of(&v[0]), of(&v[1]), of(&v[2]));
        Ray::new(vector(&self.origin), vector(&self.direction), of(&self.t_max))
    }
    #[inline(always)]
    pub fn ray<E: Real>(&self, i: usize) -> OneRay<E> {
        let splat = |v: &[[f32; N]; 3]| axes(|k| E::splat(v[k][i]));
        let order = axes(|k| self.order[k][i]);
        let octant = self.octant[i] as usize & 7;
        let negative = axes(|k| octant >> k & 1);
        OneRay {
            setup: RaySetup {
                origin: splat(&self.origin),
                direction: splat(&self.direction),
                inverse: splat(&self.inverse),
                negative: axes(|k| E::Mask::splat(negative[k] != 0)),
                order: axes(|k| E::Bits::splat(order[k])),
                shear: Shear { origin: splat(&self.shear_origin), scale: splat(&self.shear_scale) },
            },
            order: axes(|k| (order[k] as usize).min(2)),
            negative,
            octant,
            t_max: self.t_max[i],
        }
    }
}

impl Lanes<MAX_WIDTH> {
    /// One packet.
    #[inline(always)]
    pub fn new<R: Real>(setup: &RaySetup<R>, t_max: R) -> Self {
        let mut lanes = Self::ZERO;
        lanes.set(0, setup, t_max);
        lanes
    }
}

/// The places of the bits that are set, from the lowest on.
pub fn ones(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let place = bits.trailing_zeros() as usize;
        let some = bits != 0;
        bits &= bits.wrapping_sub(1);
        some.then_some(place)
    })
}
