//! The GGX (Trowbridge–Reitz) distribution of microfacet normals, isotropic, with Smith masking.
//!
//! All of it is written with the length of the stretched direction, R(w) = |(αx, αy, z)| = √(cos² + α² sin²):
//! G1(w) = 2 cos/(cos + R). Walter et al. 2007; Heitz 2014, "Understanding the Masking-Shadowing Function".
//!
//! Everything here takes `wo` above the horizon and cosines as absolute values.

use crate::lane::{Real, Vec3, math};
use core::f32::consts::FRAC_1_PI;

/// Keeps quotients finite where both cosines are so small (below 1e-17) that products of them underflow.
const TINY: f32 = 1e-37;

/// A rough interface. `alpha` in [[`ALPHA_MIN`](super::ALPHA_MIN), 1].
#[derive(Clone, Copy, Debug)]
pub struct Ggx<R: Real> {
    /// In [[`ALPHA_MIN`](super::ALPHA_MIN), 1].
    pub alpha: R,
    /// Masking G1(wo)·G1(wi) in these lanes, height-correlated in the others.
    pub separable: R::Mask,
}

/// One direction as masking sees it.
#[derive(Clone, Copy, Debug)]
pub struct Projected<R> {
    /// |cosθ|.
    pub cos: R,
    /// R(w).
    pub stretched: R,
}

/// A normal drawn from those that `wo` sees.
#[derive(Clone, Copy, Debug)]
pub struct VisibleNormal<R> {
    /// Unit, above the horizon.
    pub h: Vec3<R>,
    /// D(h).
    pub density: R,
}

impl<R: Real> Ggx<R> {
    /// What Smith's terms need of a unit direction.
    #[inline(always)]
    pub fn project(&self, w: Vec3<R>) -> Projected<R> {
        let (ax, ay) = (self.alpha * w.x, self.alpha * w.y);
        Projected { cos: w.z.abs(), stretched: ax.mul_add(ax, ay.mul_add(ay, w.z * w.z)).sqrt() }
    }

    /// D(h) for an `h` of any length; `length_squared` = |h|².
    ///
    /// From tan² = (hx² + hy²)/hz², which keeps its digits where 1 − cos² has none (spec: 12 % off at α = 1e-3).
    #[inline(always)]
    pub fn density(&self, h: Vec3<R>, length_squared: R) -> R {
        let az = self.alpha * h.z;
        let below = h.x.mul_add(h.x, h.y.mul_add(h.y, az * az)).max_or(R::splat(TINY));
        let q = self.alpha * length_squared / below;
        q * q * R::splat(FRAC_1_PI)
    }

    /// G1(wo)/cosθo.
    #[inline(always)]
    pub fn g1_over_cos(&self, o: Projected<R>) -> R {
        R::splat(2.0) / (o.cos + o.stretched)
    }

    /// G2(wo, wi)/cosθo.
    #[inline(always)]
    pub fn g2_over_cos(&self, o: Projected<R>, i: Projected<R>) -> R {
        let correlated = o.cos.mul_add(i.stretched, i.cos * o.stretched).max_or(R::splat(TINY));
        let separable = R::splat(0.5) * (o.cos + o.stretched) * (i.cos + i.stretched);
        (i.cos + i.cos) / R::select(self.separable, separable, correlated)
    }

    /// G2(wo, wi)/G1(wo): the weight of a sample of the visible normals. At most 1.
    #[inline(always)]
    pub fn g2_over_g1(&self, o: Projected<R>, i: Projected<R>) -> R {
        let both = i.cos * (o.cos + o.stretched);
        let correlated = both / o.cos.mul_add(i.stretched, i.cos * o.stretched);
        let separable = (i.cos + i.cos) / (i.cos + i.stretched);
        R::select(self.separable, separable, correlated).min_or(R::one())
    }

    /// Draws a normal with density D(h)·G1(wo)·(wo·h)/cosθo: a spherical cap uniformly (Dupuy and Benyoub 2023,
    /// "Sampling Visible GGX Normals with Spherical Caps").
    #[inline(always)]
    pub fn sample_visible_normal(&self, wo: Vec3<R>, o: Projected<R>, u: [R; 2]) -> VisibleNormal<R> {
        let inv = o.stretched.recip();
        let a_inv = self.alpha * inv;
        let view = Vec3::new(wo.x * a_inv, wo.y * a_inv, o.cos * inv);

        // The cap reaches from −view.z to 1. Its point c and view are added to give the stretched normal; the height
        // of the sum and sin² of c are products, free of the cancellation in c.z + view.z and 1 − c.z².
        let one_plus = R::one() + view.z;
        let one_minus = view.x.mul_add(view.x, view.y * view.y) / one_plus;
        let height = (R::one() - u[0]) * one_plus;
        let sin = (u[0] * one_plus * (height + one_minus)).sqrt();
        let (sin_phi, cos_phi) = math::sincos_2pi(u[1]);
        let m = Vec3::new(sin.mul_add(cos_phi, view.x), sin.mul_add(sin_phi, view.y), height);

        let h = Vec3::new(self.alpha * m.x, self.alpha * m.y, m.z);
        let h2 = h.length_squared();
        // D of the stretched normal m is 1/(π α²)·(|h|²/|m|²)².
        let q = h2 / (self.alpha * m.length_squared());
        VisibleNormal { h: h * h2.sqrt().recip(), density: q * q * R::splat(FRAC_1_PI) }
    }
}
