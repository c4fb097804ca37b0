//! The error function.

use std::f64::consts::PI;

/// erf(x) = 2/√π ∫₀ˣ e^−t² dt, to 1e-15: its Taylor series times e^−x² below 3, else Laplace's continued fraction
/// (Abramowitz & Stegun 7.1.6 and 7.1.14).
pub fn erf(x: f64) -> f64 {
    let a = x.abs();
    if a >= 6.0 {
        return 1.0f64.copysign(x);
    }
    let value = if a < 3.0 {
        let (mut term, mut sum) = (a, a);
        for n in 1..100 {
            term *= 2.0 * a * a / f64::from(2 * n + 1);
            sum += term;
        }
        2.0 / PI.sqrt() * (-a * a).exp() * sum
    } else {
        let fraction = (1..=60).rev().fold(a, |below, k| a + 0.5 * f64::from(k) / below);
        1.0 - (-a * a).exp() / (PI.sqrt() * fraction)
    };
    value.copysign(x)
}
