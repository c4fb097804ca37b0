//! Estimators that are wrong on average, and tempting: E\[Î\] = I + B. A study must see their B.

use super::method::{Claim, Method, Prepared, Shared, Single, mean_and_squares, with_values};
use super::points::Points;
use crate::kernel::Width;

/// Samples above `limit` are cut to it, as renderers do with fireflies: variance falls, and what was cut is missing.
pub fn clamped(integrand: Shared, limit: f64, width: Width) -> Method {
    from_values("clamped", integrand, width, move |values| {
        values.iter().map(|&v| v.min(limit)).sum::<f64>() / values.len() as f64
    })
}

/// Σf/Σg · ∫g with a control g whose integral is known: consistent, and biased by O(1/n) (Hájek 1971). `control` gives g
/// at the same points.
pub fn ratio(integrand: Shared, control: Shared, mean: f64, width: Width) -> Method {
    Method::new("ratio", Claim::Biased, move |n| {
        let plan = Points::Independent.plan(n, integrand.dimensions())?;
        let (integrand, control) = (integrand.clone(), control.clone());
        Some(Prepared::new(plan.len(), move |key, _| {
            let f: f64 = with_values(&plan, &*integrand, width, key, |values| values.iter().sum());
            let g: f64 = with_values(&plan, &*control, width, key, |values| values.iter().sum());
            Single { value: if g == 0.0 { 0.0 } else { f / g * mean }, standard_error: None }
        }))
    })
}

/// A pilot of a quarter of the samples decides whether the rest is worth while: where its values are all alike it is
/// taken for the answer, else everything is averaged, the pilot too (Kirk & Arvo 1991, "Unbiased Sampling Techniques for
/// Image Synthesis", show why that is biased).
pub fn pilot_reuse(integrand: Shared, width: Width) -> Method {
    from_values("pilot-reuse", integrand, width, |values| {
        let pilot = values.len().div_ceil(4);
        let (mean, squares) = mean_and_squares(&values[..pilot]);
        if squares == 0.0 { mean } else { mean_and_squares(values).0 }
    })
}

fn from_values(
    name: &str,
    integrand: Shared,
    width: Width,
    estimate: impl Fn(&[f64]) -> f64 + Copy + Send + Sync + 'static,
) -> Method {
    Method::new(name, Claim::Biased, move |n| {
        let plan = Points::Independent.plan(n, integrand.dimensions())?;
        let integrand = integrand.clone();
        Some(Prepared::new(plan.len(), move |key, _| {
            let value = with_values(&plan, &*integrand, width, key, estimate);
            Single { value, standard_error: None }
        }))
    })
}
