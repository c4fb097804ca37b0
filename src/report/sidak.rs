//! How large |z| may be among many independent tests.

use crate::student::student_quantile;

/// Family-wise probability of a false alarm that the house tests at.
pub const FAMILY_WISE: f64 = 0.01;

/// The |z| that the largest of `tests` independent standard normal values exceeds with probability [`FAMILY_WISE`]
/// (Šidák 1967): the two-sided tail of each is 1 − (1 − 0.01)^(1/tests). `tests` of 0 counts as 1. Good to 1e-9.
pub fn sidak_bound(tests: u64) -> f64 {
    // expm1 and ln_1p keep the tail exact where 1 − (…)^(1/tests) would cancel.
    let tail = -f64::exp_m1(f64::ln_1p(-FAMILY_WISE) / tests.max(1) as f64);
    let (mut low, mut high) = (2.0, 40.0);
    while high - low > 1e-10 {
        let middle = 0.5 * (low + high);
        if two_sided_tail(middle) > tail { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// From here on Student's t is the normal distribution to 4e-4 of the bound.
const NORMAL_FROM: u32 = 10_000;

/// The same of Student's t with `dof` degrees of freedom, which a mean over its own standard error has: few values have tails
/// that are no news. ∞ for none.
pub fn sidak_student(tests: u64, dof: u32) -> f64 {
    let confidence = (f64::ln_1p(-FAMILY_WISE) / tests.max(1) as f64).exp();
    student_quantile(dof.min(NORMAL_FROM), confidence)
}

/// P(|Z| > z) for z ≥ 2, by Laplace's continued fraction of Mills' ratio, 1/(z + 1/(z + 2/(z + 3/(z + …)))).
/// The remainder after `TERMS` is below exp(−2 z √(2·TERMS)) of the value: 1e-36 at z = 2.
fn two_sided_tail(z: f64) -> f64 {
    const TERMS: u32 = 220;
    let fraction = (1..=TERMS).rev().fold(z, |below, k| z + f64::from(k) / below);
    let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    2.0 * density / fraction
}
