//! A metal: GGX microfacets that reflect, on both sides.

use super::fresnel;
use super::ggx::Ggx;
use super::{ALPHA_MIN, Eval, Model, Sample, mirrored, mirrored_z};
use crate::lane::{Mask, Real, Vec3};

/// A rough metal, or below [`ALPHA_MIN`] a mirror.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<R: Real> {
    /// In [0, 1].
    pub alpha: R,
    /// Smith masking G1(wo)·G1(wi) in these lanes, height-correlated in the others.
    pub separable: R::Mask,
    /// Reflectance by angle.
    pub fresnel: ConductorFresnel<R>,
}

/// How much a facet reflects; each lane is of its own kind.
#[derive(Clone, Copy, Debug)]
pub struct ConductorFresnel<R: Real> {
    /// Exact: eta. Schlick: f0. Neither: the constant reflectance.
    pub a: Vec3<R>,
    /// Exact: k. Else unused.
    pub b: Vec3<R>,
    /// Lanes of the exact formula.
    pub exact: R::Mask,
    /// Lanes of Schlick's approximation.
    pub schlick: R::Mask,
}

impl<R: Real> ConductorFresnel<R> {
    /// The exact reflectance of the complex index eta + ik in every lane.
    pub fn exact(eta: Vec3<R>, k: Vec3<R>) -> Self {
        Self { a: eta, b: k, exact: R::Mask::splat(true), schlick: R::Mask::splat(false) }
    }
    /// Schlick's approximation in every lane.
    pub fn schlick(f0: Vec3<R>) -> Self {
        Self { a: f0, b: Vec3::zero(), exact: R::Mask::splat(false), schlick: R::Mask::splat(true) }
    }
    /// A constant in every lane.
    pub fn constant(reflectance: Vec3<R>) -> Self {
        Self { a: reflectance, b: Vec3::zero(), exact: R::Mask::splat(false), schlick: R::Mask::splat(false) }
    }

    /// The reflectance at the cosine between `wo` and the facet's normal.
    #[inline(always)]
    pub fn reflectance(&self, cos: R) -> Vec3<R> {
        // A constant is Schlick's formula that does not grow.
        let grow = fresnel::schlick_weight(cos).masked(self.schlick);
        let Vec3 { x, y, z } = self.a;
        let f0 = |f0: R| (R::one() - f0).mul_add(grow, f0);
        let simple = Vec3::new(f0(x), f0(y), f0(z));
        if self.exact.none() {
            return simple;
        }
        let exact = Vec3::new(
            fresnel::conductor(cos, x, self.b.x),
            fresnel::conductor(cos, y, self.b.y),
            fresnel::conductor(cos, z, self.b.z),
        );
        Vec3::select(self.exact, exact, simple)
    }
}

impl<R: Real> Conductor<R> {
    /// Lanes that scatter in one direction alone.
    #[inline(always)]
    pub fn delta(&self) -> R::Mask {
        self.alpha.lt(R::splat(ALPHA_MIN))
    }
}

impl<R: Real> Model<R> for Conductor<R> {
    #[inline(always)]
    fn eval(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let ggx = Ggx { alpha: self.alpha, separable: self.separable };
        let (o, i) = (ggx.project(wo), ggx.project(wi));
        let cos_i = mirrored(wi.z, wo.z);
        let active = o.cos.gt(R::zero()) & cos_i.gt(R::zero()) & !self.delta();

        let h = Vec3::new(wo.x + wi.x, wo.y + wi.y, o.cos + i.cos);
        let h2 = h.length_squared();
        let quarter_density = R::splat(0.25) * ggx.density(h, h2);
        // |wo + wi| = 2 wo·h.
        let cos_d = R::splat(0.5) * h2.sqrt();
        let value = self.fresnel.reflectance(cos_d) * (quarter_density * ggx.g2_over_cos(o, i));
        Eval { value: value.masked(active), pdf: (quarter_density * ggx.g1_over_cos(o)).masked(active) }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3<R>, _u_lobe: R, u: [R; 2]) -> Sample<R> {
        let ggx = Ggx { alpha: self.alpha, separable: self.separable };
        let delta = self.delta();
        let above = mirrored_z(wo, wo.z);
        let o = ggx.project(above);
        let mut cos_d = above.z;
        let mut wi = Vec3::new(-above.x, -above.y, above.z);
        let mut shadowing = R::one();
        let mut pdf = R::zero();
        if !delta.all() {
            let facet = ggx.sample_visible_normal(above, o, u);
            let rough_cos = above.dot(facet.h);
            wi = Vec3::select(delta, wi, facet.h.mul_add(rough_cos + rough_cos, -above));
            cos_d = R::select(delta, cos_d, rough_cos);
            shadowing = R::select(delta, shadowing, ggx.g2_over_g1(o, ggx.project(wi)));
            pdf = R::splat(0.25) * facet.density * ggx.g1_over_cos(o);
        }
        let valid = o.cos.gt(R::zero()) & wi.z.gt(R::zero());
        Sample {
            wi: mirrored_z(wi, wo.z),
            weight: (self.fresnel.reflectance(cos_d) * shadowing).masked(valid),
            pdf: pdf.masked(valid & !delta),
            eta: R::one(),
            delta,
            valid,
        }
    }
}
