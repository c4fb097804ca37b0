//! The slab test (Kay & Kajiya 1986) and the boxes it is applied to.

use crate::lane::Real;

/// How far a primitive's own box exceeds the primitive on each side: 2⁻¹⁹.
///
/// It covers what the sheared vertex transform of [`triangle`](super::pass_edges) can move a vertex. With
/// coordinates below 2, |v − o| < 4 is rounded by 2⁻²³, so is S·(v − o)_z from S and from (v − o)_z (|S| ≤ 1), and the
/// fused result, below 8, by 2⁻²²: together less than 2⁻²⁰. So a ray through the transformed triangle passes the true
/// one within 2⁻²⁰, and the rest of the margin is left for the rounding of the bounds.
pub const BOX_MARGIN: f32 = 1.0 / 524_288.0;

/// 1 + 2γ₃ (Ize 2013): makes the far distance err outwards. Exactly 1 + 3·2⁻²³ after rounding.
pub const FAR_PAD: f32 = 1.0 + 3.0 * f32::EPSILON;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
}

impl Bounds {
    /// Contains nothing; the slab test rejects it for every ray with a finite origin and direction.
    pub const EMPTY: Self = Self { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// The own box of a triangle.
    #[inline]
    pub fn of_triangle([a, b, c]: [[f32; 3]; 3]) -> Self {
        Self {
            lo: crate::lane::array::from_fn(|k| own_lo(a[k], b[k], c[k])),
            hi: crate::lane::array::from_fn(|k| own_hi(a[k], b[k], c[k])),
        }
    }
    /// The own box of a sphere.
    #[inline]
    pub fn of_sphere(center: [f32; 3], radius: f32) -> Self {
        Self { lo: center.map(|c| sphere_lo(c, radius)), hi: center.map(|c| sphere_hi(c, radius)) }
    }
    /// The smallest box around both; exact.
    #[inline]
    pub fn union(&self, o: &Self) -> Self {
        Self {
            lo: crate::lane::array::from_fn(|k| self.lo[k].min(o.lo[k])),
            hi: crate::lane::array::from_fn(|k| self.hi[k].max(o.hi[k])),
        }
    }
    /// Half the surface area.
    #[inline]
    pub fn half_area(&self) -> f32 {
        let [x, y, z]: [f32; 3] = crate::lane::array::from_fn(|k| self.hi[k] - self.lo[k]);
        x * y + (y * z + z * x)
    }
}

/// Bounds of a triangle's own box on one axis, from its vertices; the same arithmetic at build and in every test.
#[inline(always)]
pub fn own_lo<R: Real>(a: R, b: R, c: R) -> R {
    a.min_or(b).min_or(c) - R::splat(BOX_MARGIN)
}
#[inline(always)]
pub fn own_hi<R: Real>(a: R, b: R, c: R) -> R {
    a.max_or(b).max_or(c) + R::splat(BOX_MARGIN)
}
#[inline(always)]
pub fn sphere_lo<R: Real>(center: R, radius: R) -> R {
    (center - radius) - R::splat(BOX_MARGIN)
}
#[inline(always)]
pub fn sphere_hi<R: Real>(center: R, radius: R) -> R {
    (center + radius) + R::splat(BOX_MARGIN)
}

/// Where a ray enters and leaves a box: (t_near, padded t_far), t_near ≥ 0. Entered if t_near ≤ t_far and
/// t_near ≤ t_best.
///
/// `near[k]` and `far[k]` are the planes that the sign bit of the direction makes near and far; `inverse` is 1/d, ±∞
/// for ±0. The running bound is the right operand and wins over the NaN of 0·∞ (origin in a plane of a slab the ray
/// runs along), which so does not restrict the ray.
#[inline(always)]
pub fn slab<R: Real>(near: [R; 3], far: [R; 3], origin: [R; 3], inverse: [R; 3]) -> (R, R) {
    let mut t_near = R::zero();
    let mut t_far = R::splat(f32::INFINITY);
    for k in 0..3 {
        t_near = ((near[k] - origin[k]) * inverse[k]).max_or(t_near);
        t_far = ((far[k] - origin[k]) * inverse[k]).min_or(t_far);
    }
    (t_near, t_far * R::splat(FAR_PAD))
}
