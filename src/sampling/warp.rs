//! Uniform numbers bent into directions and points, each with its density.
//!
//! Numbers are in [0, 1); directions are unit vectors about +z; densities are per solid angle, and zero outside what
//! the warp reaches.

use crate::lane::{Real, Vec3, math};
use core::f32::consts::{FRAC_1_PI, TAU};

/// The direction at polar angle θ and azimuth 2πu.
#[inline(always)]
fn spherical<R: Real>(cos_theta: R, sin_theta: R, u: R) -> Vec3<R> {
    let (sin_phi, cos_phi) = math::sincos_2pi(u);
    Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// The unit disk.
#[inline(always)]
pub fn uniform_disk<R: Real>(u: [R; 2]) -> [R; 2] {
    let (sin_phi, cos_phi) = math::sincos_2pi(u[1]);
    let r = u[0].sqrt();
    [r * cos_phi, r * sin_phi]
}

/// The upper hemisphere by cosine: the uniform disk, lifted (Malley). z ≥ 2⁻¹² for `u` in multiples of 2⁻²⁴.
#[inline(always)]
pub fn cosine_hemisphere<R: Real>(u: [R; 2]) -> Vec3<R> {
    spherical((R::one() - u[0]).safe_sqrt(), u[0].sqrt(), u[1])
}

/// cosθ/π above the horizon.
#[inline(always)]
pub fn cosine_hemisphere_pdf<R: Real>(cos_theta: R) -> R {
    cos_theta.max_or(R::zero()) * R::splat(FRAC_1_PI)
}

/// The upper hemisphere.
#[inline(always)]
pub fn uniform_hemisphere<R: Real>(u: [R; 2]) -> Vec3<R> {
    // With c = 1 − u: 1 − c² = u(2 − u), which keeps its digits at both ends.
    let sin_theta = (u[0] * (R::splat(2.0) - u[0])).safe_sqrt();
    spherical(R::one() - u[0], sin_theta, u[1])
}

/// 1/2π above the horizon.
#[inline(always)]
pub fn uniform_hemisphere_pdf<R: Real>(cos_theta: R) -> R {
    R::splat(1.0 / TAU).masked(cos_theta.ge(R::zero()))
}

/// The whole sphere.
#[inline(always)]
pub fn uniform_sphere<R: Real>(u: [R; 2]) -> Vec3<R> {
    // With c = 1 − 2u: 1 − c² = 4u(1 − u).
    let sin_theta = R::splat(2.0) * (u[0] * (R::one() - u[0])).safe_sqrt();
    spherical(u[0].mul_add(R::splat(-2.0), R::one()), sin_theta, u[1])
}

/// 1/4π everywhere.
#[inline(always)]
pub fn uniform_sphere_pdf<R: Real>() -> R {
    R::splat(0.5 / TAU)
}

/// 1 − cosθ from sin²θ for θ in [0, π/2], without the cancellation that makes narrow cones 0.
#[inline(always)]
pub fn one_minus_cos<R: Real>(sin2_theta: R) -> R {
    sin2_theta / (R::one() + (R::one() - sin2_theta).safe_sqrt())
}

/// The cone about +z of half-angle θ_max, given as 1 − cosθ_max in (0, 2] (see [`one_minus_cos`]).
#[inline(always)]
pub fn uniform_cone<R: Real>(u: [R; 2], one_minus_cos_max: R) -> Vec3<R> {
    let t = u[0] * one_minus_cos_max;
    spherical(R::one() - t, (t * (R::splat(2.0) - t)).safe_sqrt(), u[1])
}

/// 1/(2π(1 − cosθ_max)): the density inside the cone. Whether a direction is inside is the caller's to know.
#[inline(always)]
pub fn uniform_cone_pdf<R: Real>(one_minus_cos_max: R) -> R {
    (R::splat(TAU) * one_minus_cos_max).recip()
}

/// The barycentric coordinates (b₁, b₂) of a point of a triangle, b₀ = 1 − b₁ − b₂ ≥ 0: the square folded along its
/// diagonal without mirroring it, so that near numbers stay near (Heitz 2019, "A Low-Distortion Map Between Triangle
/// and Square").
#[inline(always)]
pub fn uniform_triangle<R: Real>(u: [R; 2]) -> [R; 2] {
    let half = R::splat(0.5);
    let upper = u[1].gt(u[0]);
    let smaller = half * R::select(upper, u[0], u[1]);
    let b1 = R::select(upper, smaller, u[0] - smaller);
    let b2 = R::select(upper, u[1] - smaller, smaller);
    [b1, b2]
}

/// 1/area: per unit of area, not of solid angle.
#[inline(always)]
pub fn uniform_triangle_pdf_area<R: Real>(area: R) -> R {
    area.recip()
}
