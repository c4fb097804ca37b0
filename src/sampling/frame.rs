//! A local frame around a normal.

use crate::lane::{Real, Vec3};

/// A right-handed orthonormal basis whose z axis is the normal: `tangent × bitangent = normal`.
#[derive(Clone, Copy, Debug)]
pub struct Frame<R> {
    /// The local x axis.
    pub tangent: Vec3<R>,
    /// The local y axis.
    pub bitangent: Vec3<R>,
    /// The local z axis.
    pub normal: Vec3<R>,
}

impl<R: Real> Frame<R> {
    /// Domain: a unit `normal`. Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    #[inline(always)]
    pub fn from_normal(normal: Vec3<R>) -> Self {
        let Vec3 { x, y, z } = normal;
        let sign = R::one().copysign(z);
        let a = -(sign + z).recip();
        let b = x * y * a;
        let sign_x = sign * x;
        Self {
            tangent: Vec3::new((sign_x * x).mul_add(a, R::one()), sign * b, -sign_x),
            bitangent: Vec3::new(b, (y * y).mul_add(a, sign), -y),
            normal,
        }
    }

    /// From the world into the frame.
    #[inline(always)]
    pub fn to_local(&self, v: Vec3<R>) -> Vec3<R> {
        Vec3::new(self.tangent.dot(v), self.bitangent.dot(v), self.normal.dot(v))
    }

    /// From the frame into the world.
    #[inline(always)]
    pub fn to_world(&self, v: Vec3<R>) -> Vec3<R> {
        self.tangent.mul_add(v.x, self.bitangent.mul_add(v.y, self.normal * v.z))
    }
}
