//! Errors in units of the last place of the exact result.

/// The spacing of f32 around `exact`; the smallest subnormal where that is subnormal.
pub fn spacing(exact: f64) -> f64 {
    let exponent = (exact.abs().to_bits() >> 52) as i32 - 1023;
    // 2^(exponent − 23), built from its bits: powi costs more than the functions measured.
    f64::from_bits(((exponent.clamp(-126, 127) - 23 + 1023) as u64) << 52)
}

/// |got − exact| in ulp of `exact`; 0 where both are the same infinity, NaN or zero, infinite where only one is finite.
pub fn error(got: f32, exact: f64) -> f64 {
    if f64::from(got) == exact || (got.is_nan() && exact.is_nan()) {
        return 0.0;
    }
    let error = (f64::from(got) - exact).abs() / spacing(exact);
    if error.is_nan() { f64::INFINITY } else { error }
}

/// `exact`, or the infinity that it rounds to: from half a unit past the largest f32 on.
pub fn rounded_to_infinity(exact: f64) -> f64 {
    const HALF_PAST: f64 = 3.402_823_567_797_366e38;
    if exact.abs() >= HALF_PAST { f64::INFINITY.copysign(exact) } else { exact }
}

/// The largest error met, and where.
#[derive(Clone, Copy, Debug)]
pub struct Worst<A> {
    pub error: f64,
    pub at: Option<A>,
}

impl<A> Default for Worst<A> {
    fn default() -> Self {
        Self { error: 0.0, at: None }
    }
}

impl<A> Worst<A> {
    pub fn see(&mut self, error: f64, at: A) {
        if error > self.error {
            (self.error, self.at) = (error, Some(at));
        }
    }
    /// The worse of two; the first where they are equal.
    pub fn or(self, other: Self) -> Self {
        if other.error > self.error { other } else { self }
    }
}
