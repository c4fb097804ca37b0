//! The ray–sphere test.

use crate::lane::{Real, axes};

/// Distance per lane to the first crossing with t > 0: the near one from outside, the far one from inside. NaN or
/// ≤ 0 where there is none.
///
/// The discriminant is r² − |f⊥|², f⊥ the component of centre − origin across the ray (Haines, Günther, Akenine-Möller
/// 2019, "Precision improvements for ray/sphere intersection"): |f|² − r² would cancel for far spheres. The roots are
/// c/q and q/a, whose signs are those of c: a ray that starts inside has exactly one root on each side.
#[inline(always)]
pub fn intersect_sphere<R: Real>(origin: [R; 3], direction: [R; 3], center: [R; 3], radius: R) -> R {
    let zero = R::zero();
    let dot = |a: [R; 3], b: [R; 3]| a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]));
    let f: [R; 3] = axes(|k| center[k] - origin[k]);
    let a = dot(direction, direction);
    let b = dot(f, direction);
    let along = b / a;
    let across: [R; 3] = axes(|k| along.neg_mul_add(direction[k], f[k]));
    let r2 = radius * radius;
    let c = dot(f, f) - r2;
    let inside = c.le(zero);
    let discriminant = r2 - dot(across, across);
    // From inside the discriminant is ≥ r² − |f|² ≥ 0: only rounding makes it negative.
    let discriminant = R::select(inside, discriminant.max_or(zero), discriminant);
    let root = (a * discriminant).sqrt();
    let q = b + root.copysign(b);
    let (t0, t1) = (c / q, q / a);
    let near = t0.min_or(t1);
    let far = t0.max_or(t1);
    R::select(near.gt(zero), near, far)
}
