//! Lambert: f = ρ/π on both sides.

use super::{Eval, Model, Sample, mirrored, mirrored_z};
use crate::lane::{Mask, Real, Vec3};
use crate::sampling::warp;

/// A Lambertian surface.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse<R> {
    /// In [0, 1].
    pub reflectance: Vec3<R>,
}

impl<R: Real> Model<R> for Diffuse<R> {
    #[inline(always)]
    fn eval(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let pdf = warp::cosine_hemisphere_pdf(mirrored(wi.z, wo.z)).masked(wo.z.abs().gt(R::zero()));
        Eval { value: self.reflectance * pdf, pdf }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3<R>, _u_lobe: R, u: [R; 2]) -> Sample<R> {
        let wi = warp::cosine_hemisphere(u);
        let valid = wo.z.abs().gt(R::zero());
        Sample {
            wi: mirrored_z(wi, wo.z),
            weight: self.reflectance.masked(valid),
            pdf: warp::cosine_hemisphere_pdf(wi.z).masked(valid),
            eta: R::one(),
            delta: R::Mask::splat(false),
            valid,
        }
    }
}
