//! Affine placement of a mesh, in double precision until the result is rounded once.

use glam::{DMat3, DVec3};

/// An invertible affine map.
pub(super) struct Transform {
    linear: DMat3,
    translation: DVec3,
    /// A positive multiple of the inverse transpose of `linear`.
    normal: DMat3,
    mirrors: bool,
}

impl Transform {
    /// From 16 finite numbers, row major, acting on column vectors. The error is what is wrong and what to do.
    pub fn from_rows(m: [f64; 16]) -> Result<Self, (&'static str, &'static str)> {
        if m[12..] != [0.0, 0.0, 0.0, 1.0] {
            return Err((
                "`transform` is not affine",
                "make its last row 0, 0, 0, 1 (translation is elements 4, 8, 12)",
            ));
        }
        let linear = DMat3::from_cols_array(&[m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]]);
        let translation = DVec3::new(m[3], m[7], m[11]);
        // Dividing by the largest element keeps the cofactors inside the range of a double.
        let largest = linear.to_cols_array().iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear * (1.0 / largest);
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let determinant = x.dot(cofactors.x_axis);
        // The rounding error of a 3×3 determinant is below 6 ε times Hadamard's bound: a smaller one is not known to
        // differ from 0. Written so that a NaN (largest = 0) fails, too.
        let is_regular = determinant.abs() > 6.0 * f64::EPSILON * x.length() * y.length() * z.length();
        if !is_regular {
            return Err(("`transform` is singular", "give it three independent axes of non-zero length"));
        }
        Ok(Self { linear, translation, normal: cofactors * determinant.signum(), mirrors: determinant < 0.0 })
    }

    /// Does it turn a counter-clockwise triangle into a clockwise one?
    pub fn mirrors(&self) -> bool {
        self.mirrors
    }

    /// The image of a point; `None` where it overflows single precision.
    pub fn point(&self, p: [f32; 3]) -> Option<[f32; 3]> {
        super::domain::FINITE.admit3((self.linear * DVec3::from(p.map(f64::from)) + self.translation).to_array())
    }

    /// The image of a surface normal, not normalised.
    pub fn normal(&self, n: DVec3) -> DVec3 {
        self.normal * n
    }
}

/// `n` at unit length; `None` where it has no direction (zero, infinite or NaN).
pub(super) fn unit(n: DVec3) -> Option<[f32; 3]> {
    let n = n.try_normalize()?;
    super::domain::FINITE.admit3(n.to_array())
}
