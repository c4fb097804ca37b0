//! Pearson's chi-square test of counts against expectations, small cells pooled.

use super::special::{chi2_tail, poisson_tail};

/// Cells expected to hold fewer samples are pooled: below about 5 the statistic no longer follows chi-square
/// (Cochran 1952).
const MIN_EXPECTED: f64 = 5.0;

#[derive(Clone, Copy, Debug)]
pub struct Chi2Outcome {
    pub statistic: f64,
    pub dof: f64,
    /// Probability of counts at least this far off if the expectations are right. NaN expectations give 0.
    pub p_value: f64,
}

/// Cells that together should hold fewer samples than this are forbidden: one sample there is a failure.
const FORBIDDEN: f64 = 1e-6;

/// Tests `observed` counts against `expected` ones, whose sums must agree (the last cell may be "everything else").
///
/// Cells below 5 are pooled, smallest first, into pools of at least 5. Two pools are not: the forbidden region (below
/// 1e-6 in all) and what is left of the small cells (below 5 in all). Each is held to its Poisson tail, and the smallest
/// of the three p-values counts, corrected for having been chosen.
pub fn chi2_test(observed: &[u64], expected: &[f64]) -> Chi2Outcome {
    assert_eq!(observed.len(), expected.len());
    let mut cells: Vec<(f64, u64)> = expected.iter().copied().zip(observed.iter().copied()).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut cells = cells.into_iter().peekable();

    let mut forbidden = (0.0, 0);
    while let Some(cell) = cells.next_if(|cell| forbidden.0 + cell.0 < FORBIDDEN) {
        forbidden = (forbidden.0 + cell.0, forbidden.1 + cell.1);
    }
    let (mut statistic, mut terms) = (0.0, 0u32);
    let (mut pool, mut rest) = ((0.0, 0), (0.0, 0));
    for cell in cells {
        if pool.0 > 0.0 && cell.0 >= MIN_EXPECTED {
            (rest, pool) = (pool, (0.0, 0)); // happens once: from here on every cell is large enough
        }
        pool = (pool.0 + cell.0, pool.1 + cell.1);
        if pool.0 >= MIN_EXPECTED {
            statistic += (pool.1 as f64 - pool.0).powi(2) / pool.0;
            terms += 1;
            pool = (0.0, 0);
        }
    }
    if pool.0 > 0.0 {
        rest = pool;
    }

    let dof = f64::from(terms.saturating_sub(1));
    let p_cells = if dof > 0.0 { chi2_tail(dof, statistic) } else { 1.0 };
    let p = p_cells.min(poisson_tail(forbidden.0, forbidden.1)).min(poisson_tail(rest.0, rest.1));
    let nan = expected.iter().any(|e| e.is_nan());
    let p_value = if nan { 0.0 } else { -f64::exp_m1(3.0 * f64::ln_1p(-p)) }; // 1 − (1 − p)³
    Chi2Outcome { statistic, dof, p_value }
}
