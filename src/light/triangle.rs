//! A triangle that emits from its counter-clockwise side, sampled uniformly in area.

use super::sample::LightPoint;
use crate::lane::{Real, Vec3};

/// Bound of the rounding error of a point on a primitive, relative to the magnitudes it was summed from:
/// γ(7) = 7u/(1 − 7u) with u = 2⁻²⁴ (Pharr, Jakob, Humphreys 2023, §6.8.5).
pub(super) const GAMMA_7: f32 = 4.172_327e-7;

/// The solid-angle density at distance `t` of a light sampled uniformly in area. `row` is the light's choice
/// probability over its area ([`Lights::emitter_pdf_row`](super::Lights::emitter_pdf_row)), `cos` the cosine between
/// the light's front normal and the direction back. 0 on the back side, and where the density overflows: `sample`
/// drops those points, so they are left to the other technique.
#[inline(always)]
pub fn triangle_pdf<R: Real>(row: R, t: R, cos: R) -> R {
    let pdf = row * (t * t) / cos;
    pdf.masked(cos.gt(R::zero()) & pdf.is_finite())
}

/// A triangle per lane, with its unit front normal.
pub(super) struct Triangle<R> {
    pub p0: Vec3<R>,
    pub e1: Vec3<R>,
    pub e2: Vec3<R>,
    pub ng: Vec3<R>,
}

/// The point with weights `b1` and `b2` of vertices 1 and 2, sampled uniformly in area, as seen from `origin`: the density
/// in solid angle is `row`·t²/cos.
#[inline(always)]
pub(super) fn at<R: Real>(light: &Triangle<R>, row: R, origin: Vec3<R>, [b1, b2]: [R; 2]) -> LightPoint<R> {
    let along = light.e1 * b1;
    let target = light.p0 + light.e2.mul_add(b2, along);
    let error = (light.p0.abs() + along.abs() + (light.e2 * b2).abs()) * R::splat(GAMMA_7);
    let to_light = target - origin;
    let distance = to_light.length();
    let wi = to_light * distance.recip();
    let pdf = triangle_pdf(row, distance, -wi.dot(light.ng));
    LightPoint { wi, target, target_error: error, ng: light.ng, distance, pdf }
}
