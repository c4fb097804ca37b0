//! Light of a program's own.

use crate::lane::{Real, Vec3};

/// What a light sends to a point.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<R: Real> {
    /// Unit, towards the light.
    pub wi: Vec3<R>,
    /// To the light, in the scene's unit, > 0; infinite where it comes from outside the scene. What the scene has nearer
    /// than this casts a shadow.
    pub distance: R,
    /// In W·sr⁻¹·m⁻². Of a `delta` sample the irradiance on a plane across `wi`, in W·m⁻².
    pub radiance: Vec3<R>,
    /// Of `wi`, in solid angle; of a `delta` sample, its probability. 0 where nothing arrives.
    pub pdf: R,
    /// `wi` is the only direction that could have been drawn: a point light or a sun without extent.
    pub delta: R::Mask,
}

/// A light beside the scene's: an analytic sky, a lamp with a measured distribution.
///
/// A light that is infinitely far away is seen by rays that leave the scene, too, and the two ways to find it are combined
/// by multiple importance sampling. One that is near is found by [`Light::sample`] alone: no ray meets it.
pub trait Light: Sync {
    /// False for [`Nothing`](super::Nothing) alone, whose code is left out.
    #[doc(hidden)]
    const SHINES: bool = true;

    /// A sample of what reaches the point `p` (in the scene's unit), what lies between not looked at; `u` in [0, 1).
    fn sample<R: Real>(&self, p: Vec3<R>, u: [R; 2]) -> Arrival<R>;

    /// Radiance that comes in along the unit direction `wi` from outside the scene, and the density with which
    /// [`Light::sample`] draws `wi` (from whatever point). Zeros by default.
    fn outside<R: Real>(&self, _wi: Vec3<R>) -> (Vec3<R>, R) {
        (Vec3::zero(), R::zero())
    }
}
