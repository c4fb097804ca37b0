//! What sampling a light gives.

use crate::lane::{Bits, Mask, Real, Vec3, array};

/// In [`LightSample::primitive`]: not a primitive but the environment (or no sample).
pub const NO_PRIMITIVE: u32 = u32::MAX;
/// In [`LightSample::primitive`]: a light without extent.
pub const DELTA_LIGHT: u32 = u32::MAX - 1;

/// One light sample per lane. A lane with `pdf` 0 holds none: its radiance is 0 and nothing else of it is meaningful.
#[derive(Clone, Copy, Debug)]
pub struct LightSample<R: Real> {
    /// Unit, towards the light.
    pub wi: Vec3<R>,
    /// The point on an area light, or a point light.
    pub target: Vec3<R>,
    /// How far each coordinate of `target` may be off the true surface.
    pub target_error: Vec3<R>,
    /// Unit normal at `target` on the emitting side.
    pub ng: Vec3<R>,
    /// To `target`; infinite for the environment and directional lights.
    pub distance: R,
    /// Radiance, times how much of the density `pdf` the sample makes up for: 1 but [along slopes](super::Lights::add_slopes).
    /// Of a light without extent, what arrives per unit of area across `wi`.
    pub radiance: Vec3<R>,
    /// In solid angle, the choice of light included, as hits are weighed by. Of a light without extent, the probability of the choice.
    pub pdf: R,
    /// Does `wi` lead out of the scene? To the environment or to a directional light.
    pub is_environment: R::Mask,
    /// The emitting primitive, [`DELTA_LIGHT`] or [`NO_PRIMITIVE`].
    pub primitive: R::Bits,
    /// Of the point on a triangle, the weights of vertices 1 and 2; on a sphere, the numbers it was sampled by.
    pub place: [R; 2],
}

/// A point on an area light as its shape produces it.
pub(super) struct LightPoint<R> {
    pub wi: Vec3<R>,
    pub target: Vec3<R>,
    pub target_error: Vec3<R>,
    pub ng: Vec3<R>,
    pub distance: R,
    pub pdf: R,
}

impl<R: Real> LightPoint<R> {
    #[inline(always)]
    pub(super) fn select(mask: R::Mask, a: Self, b: Self) -> Self {
        Self {
            wi: Vec3::select(mask, a.wi, b.wi),
            target: Vec3::select(mask, a.target, b.target),
            target_error: Vec3::select(mask, a.target_error, b.target_error),
            ng: Vec3::select(mask, a.ng, b.ng),
            distance: R::select(mask, a.distance, b.distance),
            pdf: R::select(mask, a.pdf, b.pdf),
        }
    }
}

impl<R: Real> LightSample<R> {
    /// Lights without extent, which nothing but their samples finds.
    #[inline(always)]
    pub fn is_delta(&self) -> R::Mask {
        self.primitive.eq(R::Bits::splat(DELTA_LIGHT))
    }

    #[inline(always)]
    pub(crate) fn none() -> Self {
        Self {
            wi: Vec3::zero(),
            target: Vec3::zero(),
            target_error: Vec3::zero(),
            ng: Vec3::zero(),
            distance: R::zero(),
            radiance: Vec3::zero(),
            pdf: R::zero(),
            is_environment: R::Mask::splat(false),
            primitive: R::Bits::splat(NO_PRIMITIVE),
            place: [R::zero(); 2],
        }
    }

    /// Without radiance and pdf where `active` does not hold or the pdf is 0.
    #[inline(always)]
    pub(crate) fn only(mut self, active: R::Mask) -> Self {
        let valid = active & self.pdf.gt(R::zero());
        self.pdf = self.pdf.masked(valid);
        self.radiance = self.radiance.masked(valid);
        self.is_environment = self.is_environment & valid;
        self.primitive = R::Bits::select(valid, self.primitive, R::Bits::splat(NO_PRIMITIVE));
        self
    }

    #[inline(always)]
    pub(crate) fn select(mask: R::Mask, a: Self, b: Self) -> Self {
        Self {
            wi: Vec3::select(mask, a.wi, b.wi),
            target: Vec3::select(mask, a.target, b.target),
            target_error: Vec3::select(mask, a.target_error, b.target_error),
            ng: Vec3::select(mask, a.ng, b.ng),
            distance: R::select(mask, a.distance, b.distance),
            radiance: Vec3::select(mask, a.radiance, b.radiance),
            pdf: R::select(mask, a.pdf, b.pdf),
            is_environment: (a.is_environment & mask) | (b.is_environment & !mask),
            primitive: R::Bits::select(mask, a.primitive, b.primitive),
            place: array::from_fn(|k| R::select(mask, a.place[k], b.place[k])),
        }
    }
}
