//! Every function of one argument over the f32 numbers: error against f64, and equal bits at widths 1, 8 and 16.

use super::lane_functions::*;
use super::ulp::{Worst, error, rounded_to_infinity};
use super::{Effort, Row};
use crate::lane::{Real, f32x8, f32x16};
use rayon::prelude::*;

const GROUP: &str = "lane maths";
/// Patterns a job takes.
const JOB: u64 = 1 << 18;

pub fn rows(effort: Effort) -> Vec<Row> {
    [
        sweep::<Sin2Pi>(effort),
        sweep::<Cos2Pi>(effort),
        sweep::<Atan>(effort),
        sweep::<Acot>(effort),
        sweep::<Exp>(effort),
        sweep::<Ln>(effort),
        sweep::<Ln1p>(effort),
        sweep::<ExpM1>(effort),
        sweep::<Sqrt>(effort),
        sweep::<Recip>(effort),
        sweep::<Round>(effort),
        sweep::<Floor>(effort),
    ]
    .concat()
}

/// What a sweep found.
#[derive(Clone, Copy, Default)]
struct Found {
    worst: Worst<f32>,
    count: u64,
    /// Arguments at which a width gives other bits than width 1.
    unequal: u64,
    /// Arguments outside the domain, below 2¹²⁶, with a result that is not finite.
    not_finite: u64,
    outside: u64,
}

impl Found {
    fn and(self, o: Self) -> Self {
        Self {
            worst: self.worst.or(o.worst),
            count: self.count + o.count,
            unequal: self.unequal + o.unequal,
            not_finite: self.not_finite + o.not_finite,
            outside: self.outside + o.outside,
        }
    }
}

fn sweep<F: Unary>(effort: Effort) -> Vec<Row> {
    // Prime strides, so that every bit of the mantissa takes part.
    let stride: u64 = effort.pick(1009, 31, 1);
    let patterns = (1u64 << 32).div_ceil(stride);
    let regular = (0..patterns.div_ceil(JOB)).into_par_iter().map(|job| {
        let end = patterns.min((job + 1) * JOB);
        run::<F>((job * JOB..end).map(|k| (k * stride) as u32))
    });
    let found = regular.reduce(Found::default, Found::and).and(run::<F>(near_exponents()));
    let (name, within) = (F::NAME, if found.outside > 0 { ", u in [0, 1]" } else { "" });
    let at = found.worst.at.map_or(String::new(), |x| format!("{x:e}"));
    let inside = found.count - found.outside;
    let mut rows = vec![
        Row::new(GROUP, format!("{name}{within}"), inside, found.worst.error, F::BOUND, "ulp").at(at),
        Row::never(GROUP, format!("{name}: widths 1, 8, 16 agree{within}"), inside, found.unequal, "arguments"),
    ];
    if found.outside > 0 {
        let case = format!("{name}: finite for |u| < 2¹²⁶");
        rows.push(Row::never(GROUP, case, found.outside, found.not_finite, "arguments"));
    }
    rows
}

/// The eight patterns to each side of every power of two, zero, infinity and the first NaN.
fn near_exponents() -> impl Iterator<Item = u32> {
    (0..512u32).flat_map(|e| (0..16u32).map(move |k| (e << 23).wrapping_add(k).wrapping_sub(8)))
}

fn run<F: Unary>(patterns: impl Iterator<Item = u32>) -> Found {
    let mut found = Found::default();
    let mut block = [0f32; 16];
    let mut filled = 0;
    for pattern in patterns {
        block[filled] = f32::from_bits(pattern);
        filled += 1;
        if filled == 16 {
            judge::<F>(&block, 16, &mut found);
            filled = 0;
        }
    }
    judge::<F>(&block, filled, &mut found);
    found
}

/// The first `count` of `block`.
#[inline(never)]
fn judge<F: Unary>(block: &[f32; 16], count: usize, found: &mut Found) {
    let (mut one, mut eight, mut sixteen) = ([0f32; 16], [0f32; 16], [0f32; 16]);
    for i in 0..16 {
        one[i] = F::call::<f32>(block[i]);
    }
    F::call(f32x8::load(&block[..8])).store(&mut eight[..8]);
    F::call(f32x8::load(&block[8..])).store(&mut eight[8..]);
    F::call(f32x16::load(block)).store(&mut sixteen);
    for i in 0..count {
        found.count += 1;
        let Some(exact) = F::exact(block[i]) else {
            let results = [one[i], eight[i], sixteen[i]];
            found.outside += 1;
            found.not_finite += u64::from(block[i].abs() < 2f32.powi(126) && !results.iter().all(|r| r.is_finite()));
            continue;
        };
        let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        found.unequal += u64::from(!same(one[i], eight[i]) || !same(one[i], sixteen[i]));
        let exact = rounded_to_infinity(exact);
        let wrong_zero = F::SIGNED_ZERO
            && sixteen[i] == 0.0
            && exact == 0.0
            && sixteen[i].is_sign_negative() != exact.is_sign_negative();
        found.worst.see(if wrong_zero { f64::INFINITY } else { error(sixteen[i], exact) }, block[i]);
    }
}
