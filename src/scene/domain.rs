//! The sets that numbers in input files must lie in.

use crate::bsdf::EXPONENT_MAX;

/// A set of numbers with the words an error message uses for it.
pub(super) struct Domain {
    pub contains: fn(f32) -> bool,
    pub words: &'static str,
}

pub(super) const FINITE: Domain = Domain { contains: f32::is_finite, words: "finite in single precision" };
pub(super) const POSITIVE: Domain = Domain { contains: |x| x.is_finite() && x > 0.0, words: "finite and > 0" };
pub(super) const NON_NEGATIVE: Domain = Domain { contains: |x| x.is_finite() && x >= 0.0, words: "finite and >= 0" };
pub(super) const UNIT: Domain = Domain { contains: |x| (0.0..=1.0).contains(&x), words: "in [0, 1]" };
/// Of a metal: powers of it must fit into single precision.
pub(super) const METAL_INDEX: Domain = Domain { contains: |x| x > 0.0 && x < 1e9, words: "> 0 and < 1e9" };
pub(super) const EXTINCTION: Domain = Domain { contains: |x| (0.0..1e9).contains(&x), words: ">= 0 and < 1e9" };
pub(super) const EXPONENT: Domain = Domain {
    contains: |x| (0.0..=EXPONENT_MAX).contains(&x),
    words: "in [0, 1e7] (a mirror is a conductor of alpha 0)",
};
pub(super) const HALF_ANGLE: Domain =
    Domain { contains: |x| x > 0.0 && x <= 180.0, words: "an angle in degrees, > 0 and <= 180" };
pub(super) const FIELD_OF_VIEW: Domain =
    Domain { contains: |x| x > 0.0 && x < 180.0, words: "an angle in degrees, > 0 and < 180" };

impl Domain {
    /// `value` rounded to single precision, where that lies in the domain.
    pub fn admit(&self, value: f64) -> Option<f32> {
        let rounded = value as f32;
        (self.contains)(rounded).then_some(rounded)
    }

    /// All three rounded to single precision, where all lie in the domain.
    pub fn admit3(&self, [x, y, z]: [f64; 3]) -> Option<[f32; 3]> {
        Some([self.admit(x)?, self.admit(y)?, self.admit(z)?])
    }
}
