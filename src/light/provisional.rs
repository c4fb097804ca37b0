//! Warps and frame until src/sampling has them.

use crate::lane::math::sincos_2pi;
use crate::lane::{Real, Vec3};

pub(super) mod warp {
    use super::*;

    #[inline(always)]
    pub fn uniform_triangle<R: Real>(u: [R; 2]) -> [R; 2] {
        let s = u[0].sqrt();
        [R::one() - s, u[1] * s]
    }

    #[inline(always)]
    pub fn uniform_sphere<R: Real>(u: [R; 2]) -> Vec3<R> {
        let rest = R::one() - u[0];
        let r = (u[0] * rest).sqrt() * R::splat(2.0);
        let (sin, cos) = sincos_2pi(u[1]);
        Vec3::new(r * cos, r * sin, rest - u[0])
    }
}

pub(super) struct Frame<R> {
    pub x: Vec3<R>,
    pub y: Vec3<R>,
}

impl<R: Real> Frame<R> {
    /// Duff et al. 2017.
    #[inline(always)]
    pub fn from_z(z: Vec3<R>) -> Self {
        let sign = R::one().copysign(z.z);
        let a = -(sign + z.z).recip();
        let b = z.x * z.y * a;
        Self {
            x: Vec3::new((sign * z.x * z.x).mul_add(a, R::one()), sign * b, -(sign * z.x)),
            y: Vec3::new(b, (z.y * z.y).mul_add(a, sign), -z.y),
        }
    }
}
