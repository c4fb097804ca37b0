//! Glass: an interface that reflects and refracts, smooth or of GGX microfacets.
//!
//! Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces". Radiance is transported: what is
//! transmitted is scaled by 1/η², η = η(side of wi)/η(side of wo).

use super::fresnel::RelativeIor;
use super::ggx::Ggx;
use super::{ALPHA_MIN, Eval, Model, Sample, mirrored, mirrored_z};
use crate::lane::{Mask, Real, Vec3};

/// A rough dielectric, or a smooth one (delta lobes) where alpha is below [`ALPHA_MIN`] or alpha·|ior − 1| below
/// [`LOBE_MIN`].
#[derive(Clone, Copy, Debug)]
pub struct Dielectric<R: Real> {
    /// In [0, 1].
    pub alpha: R,
    /// Smith masking G1(wo)·G1(wi) in these lanes, height-correlated in the others.
    pub separable: R::Mask,
    /// Index of the side the normal points away from, > 0; the other side is 1.
    pub ior: R,
}

/// Refraction bends by about |η − 1|·α: a matched rough interface is a smooth one. Directions in f32 resolve 2⁻²⁴ of
/// that angle, so a half vector rebuilt from them is off by up to 1 % of the lobe's width here.
pub const LOBE_MIN: f32 = ALPHA_MIN / 16.0;

impl<R: Real> Dielectric<R> {
    /// Lanes that scatter in one direction alone (of a dielectric: two).
    #[inline(always)]
    pub fn delta(&self) -> R::Mask {
        let bend = self.alpha * (self.ior - R::one()).abs();
        self.alpha.lt(R::splat(ALPHA_MIN)) | bend.lt(R::splat(LOBE_MIN))
    }
}

impl<R: Real> Model<R> for Dielectric<R> {
    #[inline(always)]
    fn eval(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let ggx = Ggx { alpha: self.alpha, separable: self.separable };
        let side = RelativeIor::new(self.ior, wo.z.gt(R::zero()));
        let wi = mirrored_z(wi, wo.z);
        let wo = mirrored_z(wo, wo.z);
        let (o, i) = (ggx.project(wo), ggx.project(wi));
        let reflects = wi.z.gt(R::zero());

        // The normal, up to length and sign, is wo + wi or wo + η·wi. Up is where its z is positive.
        let h = wi.mul_add(R::select(reflects, R::one(), side.eta), wo);
        let h2 = h.length_squared();
        let length = h2.sqrt();
        let inv = mirrored(length.recip(), h.z);
        // |wo + wi| = 2 wo·h, which does not cancel at grazing angles as the product does.
        let half_length = R::splat(0.5) * length;
        let cos_o = R::select(reflects, half_length, wo.dot(h) * inv);
        let cos_i = R::select(reflects, half_length, -(wi.dot(h) * inv));
        let visible = o.cos.gt(R::zero()) & i.cos.gt(R::zero()) & cos_o.gt(R::zero()) & cos_i.gt(R::zero());
        let active = visible & !self.delta();

        let (f, _) = side.fresnel(cos_o);
        let probability = R::select(reflects, f, R::one() - f);
        // |dh/dwi|·(wo·h) is this: without η² for radiance, times η² for the pdf where transmitted.
        let jacobian = cos_o * cos_i / h2;
        let common = probability * ggx.density(h, h2) * jacobian;
        let eta2 = R::select(reflects, R::one(), side.eta * side.eta);
        Eval {
            value: Vec3::all((common * ggx.g2_over_cos(o, i)).masked(active)),
            pdf: (common * ggx.g1_over_cos(o) * eta2).masked(active),
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R> {
        let ggx = Ggx { alpha: self.alpha, separable: self.separable };
        let side = RelativeIor::new(self.ior, wo.z.gt(R::zero()));
        let delta = self.delta();
        let above = mirrored_z(wo, wo.z);
        let o = ggx.project(above);
        let smooth = delta.all();
        let mut h = Vec3::splat([0.0, 0.0, 1.0]);
        let mut density = R::zero();
        if !smooth {
            let facet = ggx.sample_visible_normal(above, o, u);
            h = Vec3::select(delta, h, facet.h);
            density = facet.density;
        }

        let cos_o = above.dot(h);
        let (f, eta_cos_t) = side.fresnel(cos_o);
        let reflects = u_lobe.lt(f);
        let mirror = h.mul_add(cos_o + cos_o, -above);
        // Snell: the tangential part of wo over η, and cosθt along the normal; in this form exactly −wo for η = 1.
        let tangential = h.mul_add(-cos_o, above);
        let refracted = -(h.mul_add(eta_cos_t, tangential) * side.inv_eta);
        let wi = Vec3::select(reflects, mirror, refracted);

        let same_side = wi.z.gt(R::zero());
        let other_side = wi.z.lt(R::zero());
        let on_its_side = (reflects & same_side) | (!reflects & other_side);
        let valid = o.cos.gt(R::zero()) & cos_o.gt(R::zero()) & on_its_side;
        let mut weight = R::select(reflects, R::one(), side.inv_eta * side.inv_eta);
        let mut pdf = R::zero();
        if !smooth {
            weight = weight * R::select(delta, R::one(), ggx.g2_over_g1(o, ggx.project(wi)));
            // |wo + η·wi| = |η² − 1|/(cosθo + η cosθt), so this does not cancel as eval's must.
            let bend = (cos_o + eta_cos_t) / side.eta2_minus_1;
            let transmitted = cos_o * eta_cos_t * side.eta * bend * bend;
            let probability = R::select(reflects, f, R::one() - f);
            pdf = probability * density * ggx.g1_over_cos(o) * R::select(reflects, R::splat(0.25), transmitted);
        }
        Sample {
            wi: mirrored_z(wi, wo.z),
            weight: Vec3::all(weight.masked(valid)),
            pdf: pdf.masked(valid & !delta),
            eta: R::select(reflects, R::one(), side.eta),
            delta,
            valid,
        }
    }
}
