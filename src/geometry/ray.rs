//! A ray per lane, and what it hit.

use crate::lane::{Bits, Real, Vec3};

/// [`Hit::primitive`] where nothing was hit.
pub const MISS: u32 = u32::MAX;

/// The points `origin + t·direction` with 0 < t < `t_max`. The direction need not be unit: t counts in its lengths.
/// A lane whose origin or direction is not finite, whose direction is zero or whose `t_max` is NaN hits nothing.
#[derive(Clone, Copy, Debug)]
pub struct Ray<R> {
    pub origin: Vec3<R>,
    pub direction: Vec3<R>,
    pub t_max: R,
}

/// The closest hit per lane. Triangles are numbered in file order, then spheres.
#[derive(Clone, Copy, Debug)]
pub struct Hit<R: Real> {
    /// In units of the ray's direction; the ray's `t_max` on a miss.
    pub t: R,
    /// [`MISS`], or which primitive.
    pub primitive: R::Bits,
    /// Weight of vertex 1; 0 on spheres and misses.
    pub u: R,
    /// Weight of vertex 2; 0 on spheres and misses.
    pub v: R,
}

impl<R: Real> Hit<R> {
    /// Nothing hit before `t_max`.
    #[inline(always)]
    pub fn miss(t_max: R) -> Self {
        Self { t: t_max, primitive: R::Bits::splat(MISS), u: R::zero(), v: R::zero() }
    }
    /// Lanes that hit something.
    #[inline(always)]
    pub fn valid(&self) -> R::Mask {
        !self.primitive.eq(R::Bits::splat(MISS))
    }
    /// Lanes of `other` where `mask` holds.
    #[inline(always)]
    pub fn replace(&mut self, mask: R::Mask, other: Self) {
        self.t = R::select(mask, other.t, self.t);
        self.primitive = R::Bits::select(mask, other.primitive, self.primitive);
        self.u = R::select(mask, other.u, self.u);
        self.v = R::select(mask, other.v, self.v);
    }
}

impl<R: Real> Ray<R> {
    #[inline(always)]
    pub fn new(origin: Vec3<R>, direction: Vec3<R>, t_max: R) -> Self {
        Self { origin, direction, t_max }
    }
    #[inline(always)]
    pub fn at(&self, t: R) -> Vec3<R> {
        self.direction.mul_add(t, self.origin)
    }
    /// Lanes that can hit something: finite, a direction that is not zero, `t_max` > 0.
    #[inline(always)]
    pub fn usable(&self) -> R::Mask {
        let (o, d) = (self.origin.abs(), self.direction.abs());
        // A sum of magnitudes below infinity needs each finite; halves keep finite ones from overflowing.
        let half = |v: Vec3<R>| (v * R::splat(0.25)).x + ((v * R::splat(0.25)).y + (v * R::splat(0.25)).z);
        let infinity = R::splat(f32::INFINITY);
        half(o).lt(infinity)
            & half(d).lt(infinity)
            & (d.x.gt(R::zero()) | d.y.gt(R::zero()) | d.z.gt(R::zero()))
            & self.t_max.gt(R::zero())
    }
}
