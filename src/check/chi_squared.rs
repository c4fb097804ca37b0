//! Pearson's χ² test of counts.

/// Cells expected to hold fewer are pooled (Cochran 1952).
const LEAST_EXPECTED: f64 = 5.0;

/// What counts say against expectations.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquared {
    /// Σ (observed − expected)²/expected over cells and pools.
    pub statistic: f64,
    /// Degrees of freedom.
    pub dof: u32,
    /// Probability of counts at least this far off if the expectations are right; 0 where they are NaN.
    pub p_value: f64,
}

/// Tests counts against expectations of the same sum. Small cells are pooled, smallest first; a remainder that no pool takes
/// joins the last. Counts where as good as nothing is expected (fewer than 10⁻⁶ in all) fail by themselves.
pub(super) fn test(observed: &[u32], expected: &[f64]) -> ChiSquared {
    let mut cells: Vec<(f64, f64)> = expected.iter().copied().zip(observed.iter().map(|&n| f64::from(n))).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut pools, mut open, mut forbidden) = (Vec::new(), (0.0, 0.0), false);
    for (e, n) in cells {
        open = (open.0 + e, open.1 + n);
        forbidden |= open.0 < 1e-6 && open.1 > 0.0;
        if open.0 >= LEAST_EXPECTED {
            pools.push(std::mem::take(&mut open));
        }
    }
    match pools.last_mut() {
        Some(last) => *last = (last.0 + open.0, last.1 + open.1),
        None => pools.push(open),
    }
    let statistic: f64 = pools.iter().map(|(e, n)| (n - e).powi(2) / e).sum();
    let dof = pools.len() as u32 - 1;
    let right = !forbidden && expected.iter().all(|e| e.is_finite());
    let tail = if dof == 0 { 1.0 } else { upper_gamma(0.5 * f64::from(dof), 0.5 * statistic) };
    ChiSquared { statistic, dof, p_value: if right { tail } else { 0.0 } }
}

/// Γ(a, x)/Γ(a), for a > 0, x ≥ 0: the series of the lower one below a + 1 (Abramowitz & Stegun 6.5.29), the continued
/// fraction above (6.5.31, by Lentz's method).
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > 1e-16 * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (1.0 - scale * sum).max(0.0);
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::MAX, 1.0 / b);
    let mut fraction = d;
    for i in 1..10_000 {
        let i = f64::from(i);
        let numerator = i * (a - i);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    scale * fraction
}

/// ln Γ(x) for x > 0: Stirling's series (Abramowitz & Stegun 6.1.41) from 10 on, reached by Γ(x + 1) = x Γ(x).
fn ln_gamma(mut x: f64) -> f64 {
    let mut product = 1.0;
    while x < 10.0 {
        product *= x;
        x += 1.0;
    }
    let squared = x * x;
    let series = (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - 1.0 / (1680.0 * squared)) / squared) / squared) / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - f64::ln(product)
}
