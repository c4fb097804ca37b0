//! A Lambert base and a lobe about the mirror direction: the modified Phong model, on both sides.
//!
//! f = kd/π + ks (n + 2)/2π cosⁿα, α from the mirror direction of `wo` (Lafortune and Willems 1994, "Using the Modified
//! Phong Reflectance Model for Physically Based Rendering"): reciprocal, and with kd + ks ≤ 1 without gain of energy.

use super::{Eval, Model, Sample, mirrored_z};
use crate::lane::{Mask, Real, Vec3, math};
use crate::sampling::{Frame, warp};
use core::f32::consts::FRAC_1_PI;

/// Keeps 0/0 out where both densities underflow.
const TINY: f32 = 1e-37;

/// The largest exponent. Directions in f32 resolve the angle α to some 2⁻²³, here .05 % of the lobe's width √(2/n).
pub const EXPONENT_MAX: f32 = 1e7;

/// The modified Phong model.
#[derive(Clone, Copy, Debug)]
pub struct Phong<R> {
    /// kd, in [0, 1].
    pub diffuse: Vec3<R>,
    /// ks, in [0, 1 − kd].
    pub specular: Vec3<R>,
    /// n, in [0, [`EXPONENT_MAX`]].
    pub exponent: R,
}

impl<R: Real> Phong<R> {
    /// The probabilities of base and lobe: their parts of the reflectance at normal incidence, the mean over the channels.
    #[inline(always)]
    fn shares(&self) -> [R; 2] {
        let sum = |v: Vec3<R>| v.x + v.y + v.z;
        let (base, lobe) = (sum(self.diffuse), sum(self.specular));
        let total = base + lobe;
        let reflects = total.gt(R::zero());
        [(base / total).masked(reflects), (lobe / total).masked(reflects)]
    }

    /// cosⁿα of two directions above the horizon.
    #[inline(always)]
    fn lobe(&self, wo: Vec3<R>, wi: Vec3<R>) -> R {
        // From 1 − cosα = |wi − mirror|²/2, which keeps its digits in narrow lobes.
        let off = Vec3::new(wi.x + wo.x, wi.y + wo.y, wi.z - wo.z);
        let one_minus_cos = R::splat(0.5) * off.length_squared();
        let power = math::exp(self.exponent * math::ln_1p(-one_minus_cos));
        power.masked(one_minus_cos.lt(R::one()))
    }

    /// (kd + ks (n+2)/2 cosⁿα, π·pdf).
    #[inline(always)]
    fn parts(&self, cos_i: R, lobe: R) -> (Vec3<R>, R) {
        let half = R::splat(0.5) * lobe;
        let [base_share, lobe_share] = self.shares();
        let specular = (self.exponent + R::splat(2.0)) * half;
        let density = lobe_share * ((self.exponent + R::one()) * half);
        (self.specular.mul_add(specular, self.diffuse), base_share.mul_add(cos_i, density))
    }
}

impl<R: Real> Model<R> for Phong<R> {
    #[inline(always)]
    fn eval(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let (wi, above) = (mirrored_z(wi, wo.z), mirrored_z(wo, wo.z));
        let active = above.z.gt(R::zero()) & wi.z.gt(R::zero());
        let (f, density) = self.parts(wi.z, self.lobe(above, wi));
        let per_pi = R::splat(FRAC_1_PI);
        Eval { value: (f * (wi.z * per_pi)).masked(active), pdf: (density * per_pi).masked(active) }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R> {
        let above = mirrored_z(wo, wo.z);
        let to_lobe = u_lobe.lt(self.shares()[1]);
        // cosⁿ⁺¹α is uniform, and 1 − cosα is taken from it without cancellation.
        let log_cos = math::ln(R::one() - u[0]) / (self.exponent + R::one());
        let one_minus_cos = -math::exp_m1(log_cos);
        let sin = (one_minus_cos * (R::splat(2.0) - one_minus_cos)).safe_sqrt();
        let (sin_phi, cos_phi) = math::sincos_2pi(u[1]);
        let mirror = Frame::from_normal(Vec3::new(-above.x, -above.y, above.z));
        let about = mirror.to_world(Vec3::new(sin * cos_phi, sin * sin_phi, -one_minus_cos)) + mirror.normal;

        let wi = Vec3::select(to_lobe, about, warp::cosine_hemisphere(u));
        let lobe = R::select(to_lobe, math::exp(self.exponent * log_cos), self.lobe(above, wi));
        let valid = above.z.gt(R::zero()) & wi.z.gt(R::zero());
        let (f, density) = self.parts(wi.z, lobe);
        Sample {
            wi: mirrored_z(wi, wo.z),
            weight: (f * (wi.z / density.max_or(R::splat(TINY)))).masked(valid),
            pdf: (density * R::splat(FRAC_1_PI)).masked(valid),
            eta: R::one(),
            delta: R::Mask::splat(false),
            valid,
        }
    }
}
