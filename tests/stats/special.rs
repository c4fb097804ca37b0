//! Special functions behind the tests' p-values. Relative error about 1e-12 over the ranges tests use.

use std::f64::consts::{PI, TAU};

/// Stirling's remainder δ(a): Γ(a) = √(2π/a) (a/e)^a e^δ. For a ≥ 15, error below 1e-17 (Abramowitz & Stegun 6.1.41).
fn stirling_remainder(a: f64) -> f64 {
    let i = 1.0 / (a * a);
    (1.0 / 12.0 - i * (1.0 / 360.0 - i * (1.0 / 1260.0 - i * (1.0 / 1680.0 - i / 1188.0)))) / a
}

/// ln Γ(a), a > 0.
pub fn ln_gamma(a: f64) -> f64 {
    let (mut product, mut x) = (1.0, a);
    while x < 15.0 {
        product *= x;
        x += 1.0;
    }
    0.5 * (TAU / x).ln() + x * (x.ln() - 1.0) + stirling_remainder(x) - f64::ln(product)
}

/// x^a e^−x / Γ(a); at large `a` through Stirling, where the plain logarithms would cancel.
fn gamma_front(a: f64, x: f64) -> f64 {
    if a < 15.0 {
        return (a * x.ln() - x - ln_gamma(a)).exp();
    }
    let t = (x - a) / a;
    (a / TAU).sqrt() * (-a * (t - t.ln_1p()) - stirling_remainder(a)).exp()
}

/// Regularised incomplete gamma functions (P(a, x), Q(a, x)), each with full relative precision where it is the small
/// one. a > 0, x ≥ 0. Series below a + 1, else Lentz's continued fraction (Press et al. 2007, § 6.2).
pub fn gamma_pq(a: f64, x: f64) -> (f64, f64) {
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    let front = gamma_front(a, x);
    if x < a + 1.0 {
        let (mut n, mut term) = (a, 1.0 / a);
        let mut sum = term;
        while term > sum * 1e-17 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        let p = front * sum;
        return (p, 1.0 - p);
    }
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..100_000 {
        let an = -(i as f64) * (i as f64 - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-16 {
            break;
        }
    }
    let q = front * h;
    (1.0 - q, q)
}

/// P(X ≥ x) of a chi-square variable with `dof` degrees of freedom.
pub fn chi2_tail(dof: f64, x: f64) -> f64 {
    gamma_pq(0.5 * dof, 0.5 * x).1
}

/// P(X ≥ k) of a Poisson variable with the given mean ≥ 0.
pub fn poisson_tail(mean: f64, k: u64) -> f64 {
    if k == 0 { 1.0 } else { gamma_pq(k as f64, mean).0 }
}

/// P(|Z| ≥ z) of a standard normal variable, z ≥ 0.
pub fn normal_two_sided(z: f64) -> f64 {
    gamma_pq(0.5, 0.5 * z * z).1
}

/// P(|T| ≥ t) of Student's t with `dof` degrees of freedom, t ≥ 0.
pub fn student_two_sided(dof: f64, t: f64) -> f64 {
    beta_inc(0.5 * dof, 0.5, dof / (dof + t * t))
}

/// Regularised incomplete beta I_x(a, b), a, b > 0, x in [0, 1] (Press et al. 2007, § 6.4).
pub fn beta_inc(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p()).exp();
    if x < (a + 1.0) / (a + b + 2.0) {
        front * beta_fraction(a, b, x) / a
    } else {
        1.0 - front * beta_fraction(b, a, 1.0 - x) / b
    }
}

fn beta_fraction(a: f64, b: f64, x: f64) -> f64 {
    let step = |d: &mut f64, c: &mut f64, numerator: f64| {
        *d = 1.0 / (1.0 + numerator * *d);
        *c = 1.0 + numerator / *c;
        *d * *c
    };
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut h = d;
    for m in 1..100_000 {
        let m = m as f64;
        h *= step(&mut d, &mut c, m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)));
        let last = step(&mut d, &mut c, -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)));
        h *= last;
        if (last - 1.0).abs() < 1e-16 {
            break;
        }
    }
    h
}

/// The x ≥ 0 where a decreasing `tail` falls to `p`, by bisection to the last bits. `tail(0)` > p.
pub fn quantile(p: f64, tail: impl Fn(f64) -> f64) -> f64 {
    let (mut lo, mut hi) = (0.0, 1.0);
    while tail(hi) > p {
        (lo, hi) = (hi, 2.0 * hi);
    }
    for _ in 0..80 {
        let mid = 0.5 * (lo + hi);
        if tail(mid) > p { lo = mid } else { hi = mid }
    }
    0.5 * (lo + hi)
}

/// The normal density, for power calculations.
pub fn normal_density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / (2.0 * PI).sqrt()
}
