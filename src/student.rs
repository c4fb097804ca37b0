//! Student's t: how far a mean of few values may be from what it estimates.

use std::f64::consts::FRAC_2_PI;

/// Confidence of every interval that octolux gives unless it says otherwise.
pub const CONFIDENCE: f64 = 0.95;

/// P(|T| ≤ t) of Student's t with `dof` ≥ 1 degrees of freedom, t ≥ 0: the finite sums of Abramowitz & Stegun 26.7.3
/// and 26.7.4, exact up to rounding (about 1e-15 absolute).
pub fn student_central(dof: u32, t: f64) -> f64 {
    let angle = (t / f64::from(dof).sqrt()).atan();
    let (sine, cosine) = angle.sin_cos();
    // Terms of the series; each is the one before times cos² (k − 1)/k, k stepping by two.
    let series = |first: f64, from: u32| {
        let (mut term, mut sum, mut k) = (first, 0.0, from);
        while k <= dof {
            sum += term;
            term *= cosine * cosine * f64::from(k - 1) / f64::from(k);
            k += 2;
        }
        sum
    };
    let probability =
        if dof.is_multiple_of(2) { sine * series(1.0, 2) } else { FRAC_2_PI * (angle + sine * series(cosine, 3)) };
    probability.clamp(0.0, 1.0)
}

/// The t with P(|T| ≤ t) = `confidence` in (0, 1); 0 degrees of freedom give ∞. To 1e-12 relative.
pub fn student_quantile(dof: u32, confidence: f64) -> f64 {
    if dof == 0 {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while student_central(dof, high) < confidence && high < 1e12 {
        high *= 2.0;
    }
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        if student_central(dof, middle) < confidence { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
