//! A sphere that emits outwards, sampled uniformly in the cone it fills as seen from outside.

use super::sample::LightPoint;
use super::triangle::GAMMA_7;
use crate::lane::math::sincos_2pi;
use crate::lane::{Real, Vec3};
use crate::sampling::{Frame, warp};

/// The cone from a point to a sphere.
struct Cone<R: Real> {
    /// Unit, towards the centre.
    axis: Vec3<R>,
    /// To the centre.
    distance: R,
    /// Sine of the half-angle.
    sin_max: R,
    cos_squared_max: R,
    cos_max: R,
    /// 1 − cos of the half-angle in the form that does not cancel: s²/(1 + √(1 − s²)).
    one_minus_cos: R,
    /// Does the point lie outside the sphere?
    outside: R::Mask,
}

#[inline(always)]
fn cone<R: Real>(origin: Vec3<R>, center: Vec3<R>, radius: R) -> Cone<R> {
    let to_center = center - origin;
    let squared = to_center.length_squared();
    let distance = squared.sqrt();
    let sin_max = radius / distance;
    // (D − r)(D + r), not D² − r²: close to the surface the difference is all there is.
    let cos_squared_max = (distance - radius) * (distance + radius) / squared;
    let cos_max = cos_squared_max.safe_sqrt();
    Cone {
        axis: to_center * distance.recip(),
        distance,
        sin_max,
        cos_squared_max,
        cos_max,
        one_minus_cos: sin_max * sin_max / (R::one() + cos_max),
        outside: distance.gt(radius),
    }
}

#[inline(always)]
fn cone_pdf<R: Real>(row: R, cone: &Cone<R>) -> R {
    let pdf = row * warp::uniform_cone_pdf(cone.one_minus_cos);
    pdf.masked(cone.outside & pdf.is_finite())
}

/// The solid-angle density with which a sphere is sampled from `origin`: `row` (the light's choice probability) over
/// the cone's solid angle, the same for every direction inside; 0 from inside the sphere, where nothing emits.
#[inline(always)]
pub fn sphere_pdf<R: Real>(row: R, center: Vec3<R>, radius: R, origin: Vec3<R>) -> R {
    cone_pdf(row, &cone(origin, center, radius))
}

/// A direction uniform in the cone from `origin` and the near point of the sphere along it.
///
/// With s the sine of the half-angle and q = sin²θ/s², everything follows from the sine rule without a difference of
/// nearly equal numbers: the ray meets the sphere where θ + α has the sine √q, α being the angle at the centre. So a
/// sphere of any size at any distance gives a point on its surface to a few ulp, a limb point included.
#[inline(always)]
pub(super) fn sample<R: Real>(center: Vec3<R>, radius: R, row: R, origin: Vec3<R>, u: [R; 2]) -> LightPoint<R> {
    let cone = cone(origin, center, radius);
    let one_minus_cos = u[0] * cone.one_minus_cos;
    let cos_theta = R::one() - one_minus_cos;
    let q = (u[0] * (R::splat(2.0) - one_minus_cos) / (R::one() + cone.cos_max)).min_or(R::one());
    let sqrt_q = q.sqrt();
    let sqrt_rest = (R::one() - q).safe_sqrt();
    // D cosθ − r√(1 − q) as a quotient: the difference cancels near the surface.
    let relative_distance = cone.cos_squared_max / cone.sin_max.mul_add(sqrt_rest, cos_theta);
    let sin_alpha = sqrt_q * relative_distance;
    let cos_alpha = sqrt_rest.mul_add(cos_theta, q * cone.sin_max);

    let (sin_phi, cos_phi) = sincos_2pi(u[1]);
    let frame = Frame::from_normal(cone.axis);
    let across = frame.tangent.mul_add(cos_phi, frame.bitangent * sin_phi);
    let ng = across.mul_add(sin_alpha, cone.axis * -cos_alpha);
    let from_center = ng * radius;
    LightPoint {
        wi: across.mul_add(cone.sin_max * sqrt_q, cone.axis * cos_theta),
        target: center + from_center,
        target_error: (center.abs() + from_center.abs()) * R::splat(GAMMA_7),
        ng,
        distance: cone.distance * relative_distance,
        pdf: cone_pdf(row, &cone),
    }
}
