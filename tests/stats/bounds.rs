//! How far a statistic may stray when many are tested: Šidák's correction at a family-wise error of 1 %.

use super::special::{normal_two_sided, quantile, student_two_sided};

/// The probability that a family of correct tests shows even one failure (over the choice of seeds).
pub const FAMILY_ALPHA: f64 = 0.01;

/// The error each of `tests` independent tests may have: 1 − (1 − 0.01)^(1/tests) (Šidák 1967).
pub fn sidak_alpha(tests: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-FAMILY_ALPHA) / tests as f64)
}

/// Two-sided bound on |z| for each of `tests` normal statistics.
pub fn z_bound(tests: usize) -> f64 {
    quantile(sidak_alpha(tests), normal_two_sided)
}

/// Two-sided bound on |t| for each of `tests` means whose variance is estimated with `dof` degrees of freedom.
pub fn t_bound(tests: usize, dof: f64) -> f64 {
    if dof > 1e5 {
        // Cornish–Fisher in 1/dof; the next term is below 1e-8 here.
        let z = z_bound(tests);
        return z + (z.powi(3) + z) / (4.0 * dof);
    }
    quantile(sidak_alpha(tests), |t| student_two_sided(dof, t))
}
