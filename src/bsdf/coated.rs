//! A Lambert base under a dielectric coat of GGX microfacets, on both sides.
//!
//! f = (1 − F(wo)) (1 − F(wi)) ρ/π + F D G/(4 cosθo cosθi): light enters and leaves the coat once (Shirley et al. 1997,
//! "A Practitioners' Assessment of Light Reflection Models", without what is reflected back into the base).
//!
//! A smooth coat is a delta lobe above a base that is none: samples are delta or not by the lobe that was chosen, `eval`
//! holds the base alone, with its own share of the density.

use super::fresnel::RelativeIor;
use super::ggx::Ggx;
use super::{ALPHA_MIN, Eval, Model, Sample, mirrored, mirrored_z};
use crate::lane::{Mask, Real, Vec3};
use crate::sampling::warp;
use core::f32::consts::FRAC_1_PI;

/// Keeps 0/0 out where both densities underflow.
const TINY: f32 = 1e-37;

/// A coated surface, its coat smooth (a delta lobe) where alpha is below [`ALPHA_MIN`].
#[derive(Clone, Copy, Debug)]
pub struct Coated<R: Real> {
    /// ρ of the base, in [0, 1].
    pub reflectance: Vec3<R>,
    /// Of the coat, in [0, 1].
    pub alpha: R,
    /// Smith masking G1(wo)·G1(wi) in these lanes, height-correlated in the others.
    pub separable: R::Mask,
    /// Index of the coat, > 0; outside is 1 on both sides.
    pub ior: R,
}

/// What is known once `wo` is.
struct Seen<R: Real> {
    coat: RelativeIor<R>,
    /// F(wo), and 1 − F(wo).
    reflected: R,
    enters: R,
    /// Probabilities of the coat's lobe and of the base.
    coat_share: R,
    base_share: R,
}

/// The coat's lobe: F D G/(4 cosθo), its own density.
struct Lobe<R> {
    value: R,
    pdf: R,
}

impl<R: Real> Coated<R> {
    /// Lanes whose coat reflects in one direction alone.
    #[inline(always)]
    pub fn delta(&self) -> R::Mask {
        self.alpha.lt(R::splat(ALPHA_MIN))
    }

    #[inline(always)]
    fn seen(&self, cos_o: R) -> Seen<R> {
        let coat = RelativeIor::new(self.ior, R::Mask::splat(true));
        let (f, _) = coat.fresnel(cos_o);
        let enters = coat.transmittance(cos_o);
        let base = enters * (self.reflectance.x + self.reflectance.y + self.reflectance.z) * R::splat(1.0 / 3.0);
        let total = base + f;
        let lit = total.gt(R::zero());
        Seen { coat, reflected: f, enters, coat_share: (f / total).masked(lit), base_share: (base / total).masked(lit) }
    }

    /// (f·cosθi, pdf) of both lobes together.
    #[inline(always)]
    fn both(&self, seen: &Seen<R>, cos_i: R, lobe: Lobe<R>) -> (Vec3<R>, R) {
        let leaves = seen.coat.transmittance(cos_i);
        let lambert = cos_i * R::splat(FRAC_1_PI);
        let base = self.reflectance * (seen.enters * leaves * lambert);
        (base + Vec3::all(lobe.value), seen.coat_share.mul_add(lobe.pdf, seen.base_share * lambert))
    }
}

impl<R: Real> Model<R> for Coated<R> {
    #[inline(always)]
    fn eval(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let ggx = Ggx { alpha: self.alpha, separable: self.separable };
        let (o, i) = (ggx.project(wo), ggx.project(wi));
        let active = o.cos.gt(R::zero()) & mirrored(wi.z, wo.z).gt(R::zero());
        let seen = self.seen(o.cos);

        let h = Vec3::new(wo.x + wi.x, wo.y + wi.y, o.cos + i.cos);
        let h2 = h.length_squared();
        let quarter_density = R::splat(0.25) * ggx.density(h, h2);
        let (f, _) = seen.coat.fresnel(R::splat(0.5) * h2.sqrt());
        let rough = !self.delta();
        let lobe = Lobe {
            value: (f * (quarter_density * ggx.g2_over_cos(o, i))).masked(rough),
            pdf: (quarter_density * ggx.g1_over_cos(o)).masked(rough),
        };
        let (value, pdf) = self.both(&seen, i.cos, lobe);
        Eval { value: value.masked(active), pdf: pdf.masked(active) }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R> {
        let ggx = Ggx { alpha: self.alpha, separable: self.separable };
        let smooth = self.delta();
        let above = mirrored_z(wo, wo.z);
        let o = ggx.project(above);
        let seen = self.seen(o.cos);
        let to_coat = u_lobe.lt(seen.coat_share);
        let delta = to_coat & smooth;

        let mut wi = Vec3::select(to_coat, Vec3::new(-above.x, -above.y, above.z), warp::cosine_hemisphere(u));
        let mut lobe = Lobe { value: R::zero(), pdf: R::zero() };
        if !smooth.all() {
            let facet = ggx.sample_visible_normal(above, o, u);
            let facet_cos = above.dot(facet.h);
            let reflected = facet.h.mul_add(facet_cos + facet_cos, -above);
            wi = Vec3::select(to_coat & !smooth, reflected, wi);
            let i = ggx.project(wi);
            let h = above + wi;
            let h2 = h.length_squared();
            // The facet's own density is exact where a rebuilt one would not be.
            let density = R::select(to_coat, facet.density, ggx.density(h, h2));
            let (f, _) = seen.coat.fresnel(R::select(to_coat, facet_cos, R::splat(0.5) * h2.sqrt()));
            let quarter_density = R::splat(0.25) * density;
            lobe.value = (f * (quarter_density * ggx.g2_over_cos(o, i))).masked(!smooth);
            lobe.pdf = (quarter_density * ggx.g1_over_cos(o)).masked(!smooth);
        }
        let (value, pdf) = self.both(&seen, wi.z, lobe);
        // F over its share, F/(F + base).
        let mirror = seen.reflected / seen.coat_share.max_or(R::splat(TINY));
        let weight = Vec3::select(delta, Vec3::all(mirror), value * pdf.max_or(R::splat(TINY)).recip());
        let valid = o.cos.gt(R::zero()) & wi.z.gt(R::zero());
        Sample {
            wi: mirrored_z(wi, wo.z),
            weight: weight.masked(valid),
            pdf: pdf.masked(valid & !delta),
            eta: R::one(),
            delta,
            valid,
        }
    }
}
