//! Errors in units of the last place of the exact result.

/// The spacing of f32 around `exact`; the smallest subnormal where that is subnormal.
pub fn spacing(exact: f64) -> f64 {
    let exponent = (exact.abs().to_bits() >> 52) as i32 - 1023;
    2f64.powi(exponent.clamp(-126, 127) - 23)
}

/// |got − exact| in ulp of `exact`; 0 where both are the same infinity or zero, infinite where only one is finite.
pub fn error(got: f32, exact: f64) -> f64 {
    if f64::from(got) == exact || (got.is_nan() && exact.is_nan()) {
        return 0.0;
    }
    let error = (f64::from(got) - exact).abs() / spacing(exact);
    if error.is_nan() { f64::INFINITY } else { error }
}

/// The largest error met, and where.
#[derive(Debug)]
pub struct Worst<A> {
    pub error: f64,
    pub at: Option<A>,
}

impl<A> Worst<A> {
    pub fn new() -> Self {
        Self { error: 0.0, at: None }
    }
    pub fn see(&mut self, got: f32, exact: f64, at: A) {
        let error = error(got, exact);
        if error > self.error {
            self.error = error;
            self.at = Some(at);
        }
    }
}
