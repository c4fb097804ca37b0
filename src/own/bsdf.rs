//! Scattering of a program's own.

use crate::bsdf::{Eval, Sample};
use crate::lane::{Real, Vec3};

/// How a surface scatters. `weight · pdf` of a sample is `value` of its direction; `value` may be anything ≥ 0, but energy
/// is kept only if it integrates to at most 1 over `wi`.
///
/// ```
/// use octolux::{bsdf::{Eval, Sample}, lane::{Mask, Real, Vec3}, own::Bsdf, sampling::warp};
///
/// /// f = ρ/π on the side of the normal alone.
/// struct OneSided { reflectance: [f32; 3] }
///
/// impl Bsdf for OneSided {
///     fn eval<R: Real>(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
///         let pdf = warp::cosine_hemisphere_pdf(wi.z).masked(wo.z.gt(R::zero()));
///         Eval { value: Vec3::splat(self.reflectance) * pdf, pdf }
///     }
///     fn sample<R: Real>(&self, wo: Vec3<R>, _u_lobe: R, u: [R; 2]) -> Sample<R> {
///         let (wi, valid) = (warp::cosine_hemisphere(u), wo.z.gt(R::zero()));
///         let (weight, pdf) = (Vec3::splat(self.reflectance).masked(valid), warp::cosine_hemisphere_pdf(wi.z).masked(valid));
///         Sample { wi, weight, pdf, eta: R::one(), delta: R::Mask::splat(false), valid }
///     }
/// }
/// let report = octolux::check::DirectionTest::default().bsdf(&OneSided { reflectance: [0.5; 3] }, [0.6, 0.0, 0.8]);
/// assert!(report.accepts(), "{report}");
/// ```
pub trait Bsdf: Sync {
    /// f·|cosθi| and the density, per solid angle, with which [`Bsdf::sample`] draws `wi`. Finite for any unit directions;
    /// `wo.z` < 0 is a viewer below the surface.
    fn eval<R: Real>(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R>;

    /// A direction with weight f·|cosθi|/pdf. `u_lobe` chooses among lobes, `u` the direction; each in [0, 1).
    fn sample<R: Real>(&self, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R>;
}
