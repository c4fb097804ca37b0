//! Functions of more than one argument, on stratified pairs.

use super::ulp::{Worst, error};
use super::{Effort, Row};
use crate::lane::{Real, difference_of_products, f32x8, f32x16, math};
use rayon::prelude::*;

const GROUP: &str = "two arguments";

pub fn rows(effort: Effort) -> Vec<Row> {
    [atan2_patterns(effort), atan2_ratios(effort), products(effort)].concat()
}

#[derive(Clone, Copy, Default)]
struct Found {
    worst: Worst<[f32; 4]>,
    count: u64,
    unequal: u64,
}

impl Found {
    fn and(self, o: Self) -> Self {
        Self { worst: self.worst.or(o.worst), count: self.count + o.count, unequal: self.unequal + o.unequal }
    }
}

/// A function of up to four arguments in lanes, and its truth (`None`: not judged).
trait Function: Sync {
    fn call<R: Real>(arguments: [R; 4]) -> R;
    fn exact(arguments: [f32; 4]) -> Option<f64>;
}

/// Judges 16 argument tuples a step, `jobs` × `steps` of them; `arguments(k)` is the k-th tuple.
fn sweep<F: Function>(tuples: u64, arguments: impl Fn(u64) -> [f32; 4] + Sync) -> Found {
    const JOB: u64 = 1 << 16;
    let job = |job: u64| {
        let mut found = Found::default();
        for first in (job * JOB..tuples.min((job + 1) * JOB)).step_by(16) {
            judge::<F>(&core::array::from_fn(|i| arguments(first + i as u64)), &mut found);
        }
        found
    };
    (0..tuples.div_ceil(JOB)).into_par_iter().map(job).reduce(Found::default, Found::and)
}

#[inline(never)]
fn judge<F: Function>(tuples: &[[f32; 4]; 16], found: &mut Found) {
    let sixteen = F::call::<f32x16>(core::array::from_fn(|k| Real::from_fn(|i| tuples[i][k])));
    let low = F::call::<f32x8>(core::array::from_fn(|k| Real::from_fn(|i| tuples[i][k])));
    let high = F::call::<f32x8>(core::array::from_fn(|k| Real::from_fn(|i| tuples[i + 8][k])));
    for (i, &tuple) in tuples.iter().enumerate() {
        let one = F::call::<f32>(tuple);
        let eight = if i < 8 { low.lane(i) } else { high.lane(i - 8) };
        let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        found.count += 1;
        found.unequal += u64::from(!same(one, eight) || !same(one, sixteen.lane(i)));
        if let Some(exact) = F::exact(tuple) {
            let wrong_zero = one == 0.0 && exact == 0.0 && one.is_sign_negative() != exact.is_sign_negative();
            found.worst.see(if wrong_zero { f64::INFINITY } else { error(one, exact) }, tuple);
        }
    }
}

fn table(case: &str, found: &Found, bound: f64, arguments: usize) -> Vec<Row> {
    let at = found
        .worst
        .at
        .map_or(String::new(), |a| a[..arguments].iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(" "));
    vec![
        Row::new(GROUP, case, found.count, found.worst.error, bound, "ulp").at(at),
        Row::never(GROUP, format!("{case}: widths 1, 8, 16 agree"), found.count, found.unequal, "tuples"),
    ]
}

/// Well mixed bits of an index (MurmurHash3's finaliser, Appleby 2011).
fn hash(k: u64) -> u64 {
    let z = (k ^ k >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd);
    let z = (z ^ z >> 33).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    z ^ z >> 33
}

struct Atan2;
impl Function for Atan2 {
    #[inline(always)]
    fn call<R: Real>([y, x, ..]: [R; 4]) -> R {
        math::atan2(y, x)
    }
    fn exact([y, x, ..]: [f32; 4]) -> Option<f64> {
        Some(f64::from(y).atan2(f64::from(x)))
    }
}

/// Sign, exponent and leading bits of both arguments on a grid (NaN and infinities included), the rest hashed.
fn atan2_patterns(effort: Effort) -> Vec<Row> {
    let bits: u32 = effort.pick(9, 12, 15);
    let found = sweep::<Atan2>(1 << (2 * bits), |k| {
        let rest = hash(k);
        let pattern = |leading: u64, rest: u32| f32::from_bits((leading as u32) << (32 - bits) | rest >> bits);
        [pattern(k >> bits, rest as u32), pattern(k & ((1 << bits) - 1), (rest >> 32) as u32), 0.0, 0.0]
    });
    table("atan2, pairs of any magnitude", &found, 2.0, 2)
}

/// Ratios between 2⁻³² and 2³² on a grid of patterns, where the angle is neither an axis nor a tiny quotient.
fn atan2_ratios(effort: Effort) -> Vec<Row> {
    let pairs: u64 = effort.pick(1 << 18, 1 << 24, 1 << 28);
    let (low, high) = (2f32.powi(-32).to_bits(), 2f32.powi(32).to_bits());
    let found = sweep::<Atan2>(pairs, |k| {
        let ratio = f32::from_bits(low + (u64::from(high - low) * k / pairs) as u32);
        let signs = hash(k);
        let x = f32::from_bits((signs as u32 & 0x807f_ffff) | 0x3f80_0000);
        let y = ratio * x.abs();
        [if signs >> 40 & 1 == 0 { y } else { -y }, x, 0.0, 0.0]
    });
    table("atan2, ratios 2⁻³² … 2³²", &found, 2.0, 2)
}

struct DifferenceOfProducts;
impl Function for DifferenceOfProducts {
    #[inline(always)]
    fn call<R: Real>([a, b, c, d]: [R; 4]) -> R {
        difference_of_products(a, b, c, d)
    }
    /// Both products are exact in f64.
    fn exact(a: [f32; 4]) -> Option<f64> {
        let [a, b, c, d] = a.map(f64::from);
        Some(a * b - c * d)
    }
}

/// a·b − c·d with the products within a few ulp of each other, where plain arithmetic has no digit left, and apart.
fn products(effort: Effort) -> Vec<Row> {
    let found = sweep::<DifferenceOfProducts>(effort.pick(1 << 18, 1 << 24, 1 << 28), |k| {
        let (h, g) = (hash(k), hash(!k));
        let unit = |bits: u64| f32::from_bits((bits as u32 & 0x807f_ffff) | 0x3f80_0000);
        let (a, b) = (unit(h), unit(h >> 32));
        // Within 2⁻²⁴ … 1 of a and b.
        let near = |x: f32, bits: u64| {
            f32::from_bits(x.to_bits().wrapping_add((bits as u32 & 0x7f_ffff) >> (bits >> 24 & 31).min(23)))
        };
        [a, b, near(b, g), near(a, g >> 32)]
    });
    table("a·b − c·d, cancelling", &found, 1.5, 4)
}
