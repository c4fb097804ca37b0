//! The point of a hit, how far off it may be, and where a new ray leaves it (Pharr, Jakob, Humphreys 2023, §6.8).

use super::{Ray, SphereAt, TriangleAt};
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

/// p0 + (u e1 + v e2): at most 2 ulp of the largest of p0, e1, e2 and p off, 1.5 as measured.
///
/// The bound is γ(7)|p0| + γ(16)L with L the extent of the triangle on its longest axis, rather than pbrt's
/// γ(7)Σ|bᵢpᵢ| per axis, which covers the point but not the test: that one finds the plane to γ(4 + 5)L (the four roundings
/// of n·(v0 − o); 1.5 ulp of each component of n, and the roundings of the edges it is made of) wherever in the triangle
/// the ray comes through. The rest keeps a ray that leaves at no angle from meeting the plane within the triangle.
#[inline(always)]
pub fn triangle_point<R: Real>(at: &TriangleAt<R>, u: R, v: R) -> SurfacePoint<R> {
    let (p0, e1, e2) = (at.p0, at.e1, at.e2);
    let along = |a: R, b: R| u.mul_add(a, v * b);
    let p = Vec3::new(p0.x + along(e1.x, e2.x), p0.y + along(e1.y, e2.y), p0.z + along(e1.z, e2.z));
    let extent = (e1.abs() + e2.abs()).max_component() * R::splat(gamma(16));
    let bound = |p: R| p.abs().mul_add(R::splat(gamma(7)), extent);
    SurfacePoint { p, error: Vec3::new(bound(p0.x), bound(p0.y), bound(p0.z)) }
}

/// Weights of vertices 1 and 2, none of the three below γ(7)|p0|/L (at most a third): what a path goes on from lies further inside
/// the triangle than its coordinates round.
///
/// Otherwise a point that rounding puts on, or behind, a wall that shares the edge sees out of a closed room: once in 10⁵
/// bounces in a box a hundred of its sizes from the origin. The bound takes heights to be near L, so slivers keep less.
#[inline(always)]
pub fn inner_weights<R: Real>(at: &TriangleAt<R>, u: R, v: R) -> (R, R) {
    let extent = (at.e1.abs() + at.e2.abs()).max_component();
    let least = (at.p0.abs().max_component() * R::splat(gamma(7)) / extent).min_or(R::splat(1.0 / 3.0));
    let (u, v) = (u.max_or(least), v.max_or(least));
    let (sum, most) = (u + v, R::one() - least);
    let scale = R::select(sum.gt(most), most / sum, R::one());
    (u * scale, v * scale)
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
    (SurfacePoint { p, error }, n)
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

/// The segment from `origin` (moved off its own surface by [`offset_origin`]) to `light`, a point on a surface with unit
/// normal `ng`: direction = target − origin, unnormalised, 0 < t < 1.
///
/// The target is moved off the light to the origin's side. Its error bound serves rays that start there; seen from
/// afar, the test rounds v0 − o, so by the distance, and γ(16) of that is added: the light's own surface then lies at
/// t > 1 at any angle, where a fixed margin in t fails at low ones (t is off by ε/cos θ). Occluders are missed only within
/// that offset of the light, 10⁻⁶ of the distance.
#[inline(always)]
pub fn shadow_ray<R: Real>(origin: Vec3<R>, light: &SurfacePoint<R>, ng: Vec3<R>) -> Ray<R> {
    let way = light.p - origin;
    let far = way.abs().max_component() * R::splat(gamma(16));
    let error = light.error + Vec3::all(far);
    point_shadow_ray(origin, offset_origin(light.p, error, ng, -way))
}

/// The segment to a point that lies on no surface (a point light): direction = target − origin, 0 < t < 1.
#[inline(always)]
pub fn point_shadow_ray<R: Real>(origin: Vec3<R>, target: Vec3<R>) -> Ray<R> {
    Ray::new(origin, target - origin, R::one())
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
