//! The point of a hit, how far off it may be, and where a new ray leaves it (Pharr, Jakob, Humphreys 2023, §6.8).

use super::{SphereAt, TriangleAt};
use crate::lane::{Bits, Real, Vec3};

/// A point on a surface and a bound on the error of each coordinate, which also covers the error that the test
/// against the same primitive makes for a ray leaving from there.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<R> {
    pub p: Vec3<R>,
    pub error: Vec3<R>,
}

/// γ(n) = nε/(1 − nε), ε = 2⁻²⁴ (Higham 2002, lemma 3.1), rounded up.
const fn gamma(n: i32) -> f32 {
    let ne = n as f64 / 16_777_216.0;
    (ne / (1.0 - ne) * (1.0 + 1e-6)) as f32
}

/// p0 + (u e1 + v e2), within 1.5 ulp.
///
/// The bound is γ(7)(|p0| + |e1| + |e2|), the largest of the three axes on each, rather than pbrt's γ(7)Σ|bᵢpᵢ| axis by
/// axis, which it exceeds: the test shears all axes into one another, so in a wall x = 0 it errs in x by its y and z;
/// and a ray that leaves at a low angle meets the plane far from the hit, where the error grows with the triangle.
#[inline(always)]
pub fn triangle_point<R: Real>(at: &TriangleAt<R>, u: R, v: R) -> SurfacePoint<R> {
    let (p0, e1, e2) = (at.p0, at.e1, at.e2);
    let along = |a: R, b: R| u.mul_add(a, v * b);
    let p = Vec3::new(p0.x + along(e1.x, e2.x), p0.y + along(e1.y, e2.y), p0.z + along(e1.z, e2.z));
    let bound = |p: R, a: R, b: R| (p.abs() + (a.abs() + b.abs())) * R::splat(gamma(7));
    let error = Vec3::new(bound(p0.x, e1.x, e2.x), bound(p0.y, e1.y, e2.y), bound(p0.z, e1.z, e2.z));
    SurfacePoint { p, error: Vec3::all(error.max_component()) }
}

/// A point near the sphere's surface moved onto it, and the unit normal there (outwards).
///
/// p = c + r·n: n is within γ(6) of unit length, p is rounded once more; the test then forms centre − origin and its square,
/// γ(5) more. Doubled: γ(14)(|c| + r).
#[inline(always)]
pub fn sphere_point<R: Real>(at: &SphereAt<R>, near: Vec3<R>) -> (SurfacePoint<R>, Vec3<R>) {
    let n = (near - at.center).normalize();
    let p = n.mul_add(at.radius, at.center);
    let bound = |c: R| (c.abs() + at.radius) * R::splat(gamma(14));
    let error = Vec3::new(bound(at.center.x), bound(at.center.y), bound(at.center.z));
    (SurfacePoint { p, error: Vec3::all(error.max_component()) }, n)
}

/// `p` moved off its surface along the unit normal `ng`, to the side that `w` points to, by the distance at which the
/// error box of `p` is behind it; each coordinate then rounded away.
#[inline(always)]
pub fn offset_origin<R: Real>(p: Vec3<R>, error: Vec3<R>, ng: Vec3<R>, w: Vec3<R>) -> Vec3<R> {
    let distance = ng.abs().dot(error);
    let offset = ng * R::select(w.dot(ng).lt(R::zero()), -distance, distance);
    let moved = p + offset;
    Vec3::new(away(moved.x, offset.x), away(moved.y, offset.y), away(moved.z, offset.z))
}

/// The next float after `x` in the direction of `toward`'s sign; `x` itself where `toward` is zero.
#[inline(always)]
fn away<R: Real>(x: R, toward: R) -> R {
    let zero = R::zero();
    let one = R::Bits::splat(1);
    // +0 and −0 both step to the smallest number of the wanted sign.
    let smallest = R::from_bits(one).copysign(toward);
    let bits = x.to_bits();
    let outward = x.gt(zero) & toward.gt(zero) | x.lt(zero) & toward.lt(zero);
    let stepped = R::from_bits(R::Bits::select(outward, bits + one, bits - one));
    R::select(toward.eq(zero), x, R::select(x.eq(zero), smallest, stepped))
}
