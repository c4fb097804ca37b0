//! Lane maths, written once for every width.
//!
//! Each function is a range reduction that is exact (or exact to a stated bound) and a polynomial. The polynomials
//! are minimax in relative error of the whole function (Remez exchange in 50-digit arithmetic; then the coefficients
//! are rounded to f32 lowest degree first, the others fitted again after each). The errors given bound
//! the sweeps in `tests/lane/math.rs`, which print what they find.

use super::{Bits, Real};

/// `c[0] + c[1]·x + c[2]·x² + …` by Horner's rule, fused.
#[inline(always)]
fn polynomial<R: Real, const N: usize>(x: R, c: [f32; N]) -> R {
    let mut sum = R::splat(c[N - 1]);
    for k in (0..N - 1).rev() {
        sum = sum.mul_add(x, R::splat(c[k]));
    }
    sum
}

/// Sine and cosine of 2πu: ≤ 1 ulp each. Domain: `u` in [0, 1]; outside it unspecified, finite while |u| < 2¹²⁶.
///
/// Exact at the multiples of 1/4 (a zero may carry either sign).
#[inline(always)]
pub fn sincos_2pi<R: Real>(u: R) -> (R, R) {
    // 2π = HI + LO: the fused HI·r keeps the leading term free of the error of 2π.
    const HI: f32 = core::f32::consts::TAU;
    const LO: f32 = -1.748_455_5e-7;
    const SIN: [f32; 3] = [-41.341_67, 81.593_43, -75.427_54];
    const COS: [f32; 4] = [-19.739_208, 64.939_15, -85.424_52, 58.621_06];

    // r in [−1/8, 1/8] is exact: both operands are multiples of the last bit of u, and the difference is no longer.
    let quadrant = (u * R::splat(4.0)).round();
    let r = quadrant.mul_add(R::splat(-0.25), u);
    let r2 = r * r;
    let sin_tail = r * polynomial(r2, SIN).mul_add(r2, R::splat(LO));
    let sin_r = r.mul_add(R::splat(HI), sin_tail);
    let cos_r = polynomial(r2, COS).mul_add(r2, R::one());

    let q = quadrant.to_int();
    let one = R::Bits::splat(1);
    let two = R::Bits::splat(2);
    let odd = (q & one).eq(one);
    let sin_sign = (q & two).shl::<30>();
    let cos_sign = ((q + one) & two).shl::<30>();
    let sin = R::from_bits(R::select(odd, cos_r, sin_r).to_bits() ^ sin_sign);
    let cos = R::from_bits(R::select(odd, sin_r, cos_r).to_bits() ^ cos_sign);
    (sin, cos)
}

/// The angle of (x, y) in [−π, π]: ≤ 2 ulp (where the result is subnormal, 1 unit of the smallest subnormal).
///
/// Zeros and infinities as in IEEE 754: (±0, +0) → ±0, (±0, −0) → ±π, (±∞, +∞) → ±π/4, (±∞, −∞) → ±3π/4;
/// a NaN in either gives NaN.
#[inline(always)]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    const ATAN: [f32; 9] = [
        -3.333_33e-1,
        1.999_853e-1,
        -1.426_401_6e-1,
        1.095_088_1e-1,
        -8.399_308_5e-2,
        5.788_116_5e-2,
        -3.109_610_6e-2,
        1.086_762_7e-2,
        -1.782_402_7e-3,
    ];
    let (ax, ay) = (x.abs(), y.abs());
    // False for a NaN in either place, which then passes through the quotient.
    let steep = ay.gt(ax);
    let small = R::select(steep, ax, ay);
    let large = R::select(steep, ay, ax);
    let quotient = small / large;
    // ∞/∞ is a diagonal, 0/0 an axis.
    let diagonal = R::one().masked(large.gt(R::zero()));
    let a = R::select(small.eq(large), diagonal, quotient);

    let a2 = a * a;
    let atan = (a * a2).mul_add(polynomial(a2, ATAN), a);
    // π and π/2 as the nearest f32 and what is missing.
    let (pi, pi_rest) = (R::splat(core::f32::consts::PI), R::splat(-8.742_278e-8));
    let (half_pi, half_pi_rest) = (R::splat(core::f32::consts::FRAC_PI_2), R::splat(-4.371_139e-8));
    let angle = R::select(steep, half_pi - (atan - half_pi_rest), atan);
    let left = R::one().copysign(x).lt(R::zero());
    let angle = R::select(left, pi - (angle - pi_rest), angle);
    angle.copysign(y)
}

/// e^x: ≤ 1.1 ulp, subnormal results within 1 unit. −∞ → 0, +∞ → +∞, above 88.72284 → +∞, below −103.98 → 0,
/// NaN → NaN.
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    const EXP: [f32; 5] = [4.999_999_4e-1, 1.666_651_7e-1, 4.166_810_2e-2, 8.369_193e-3, 1.383_892_7e-3];
    const LN2_HI: f32 = 0.693_145_75; // 14 bits short, so that n·LN2_HI is exact.
    const LN2_LO: f32 = 1.428_606_8e-6;

    // NaN survives on the right of min_or and max_or.
    let x = R::splat(-104.0).max_or(R::splat(89.0).min_or(x));
    let n = (x * R::splat(core::f32::consts::LOG2_E)).round();
    let r = n.mul_add(R::splat(-LN2_LO), n.mul_add(R::splat(-LN2_HI), x));
    let p = (r * r).mul_add(polynomial(r, EXP), r) + R::one();
    // 2^n in two factors: n reaches −150 and 128, beyond the exponents of one normal number.
    let shifted = (n + R::splat(152.0)).to_int();
    let half = shifted.shr::<1>();
    let bias = R::Bits::splat(127 - 76);
    let first = R::from_bits((half + bias).shl::<23>());
    let second = R::from_bits((shifted - half + bias).shl::<23>());
    p * first * second
}

/// Natural logarithm: ≤ 1 ulp. ±0 → −∞, +∞ → +∞, below zero or NaN → NaN; subnormals as any other number.
#[inline(always)]
pub fn ln<R: Real>(x: R) -> R {
    const LN: [f32; 8] = [
        3.333_321_5e-1,
        -2.499_979_7e-1,
        2.001_040_6e-1,
        -1.668_049e-1,
        1.400_587e-1,
        -1.218_422_8e-1,
        1.398_443_3e-1,
        -1.289_182_5e-1,
    ];
    const TWO_THIRDS: u32 = 0x3f2a_aaab;
    const LN2_HI: f32 = core::f32::consts::LN_2;
    const LN2_LO: f32 = -1.904_654_2e-9;

    let subnormal = x.lt(R::splat(f32::MIN_POSITIVE));
    let scaled = R::select(subnormal, x * R::splat((1u32 << 25) as f32), x);
    // scaled = 2^e·m with m in [2/3, 4/3).
    let shifted = scaled.to_bits() + R::Bits::splat(0x3f80_0000 - TWO_THIRDS);
    let bias = R::select(subnormal, R::splat(127.0 + 25.0), R::splat(127.0));
    let e = R::from_int(shifted.shr::<23>()) - bias;
    let m = R::from_bits((shifted & R::Bits::splat(0x007f_ffff)) + R::Bits::splat(TWO_THIRDS));

    let f = m - R::one();
    let f2 = f * f;
    let tail = (f * f2).mul_add(polynomial(f, LN), f2 * R::splat(-0.5));
    let result = e.mul_add(R::splat(LN2_HI), f + e.mul_add(R::splat(LN2_LO), tail));

    let positive = x.gt(R::zero());
    let result = R::select(positive & x.is_finite(), result, R::splat(f32::INFINITY));
    let result = R::select(x.eq(R::zero()), R::splat(f32::NEG_INFINITY), result);
    // x ≥ 0 is false for a NaN too.
    R::select(x.ge(R::zero()), result, R::splat(f32::NAN))
}

/// ln(1 + x): ≤ 4 ulp, also where 1 + x rounds to 1 (Kahan; Higham 2002, § 1.14.1). −1 → −∞, below it or NaN → NaN.
#[inline(always)]
pub fn ln_1p<R: Real>(x: R) -> R {
    let sum = R::one() + x;
    let rounded = sum - R::one();
    // What ln gains by the rounding of the sum, the quotient takes back; for large x there is nothing to take back.
    let ln_sum = ln(sum);
    let corrected = R::select(x.gt(R::splat(1e9)), ln_sum, ln_sum * (x / rounded));
    R::select(rounded.eq(R::zero()), x, corrected)
}

/// e^x − 1: ≤ 4 ulp, also where e^x rounds to 1 (Kahan; Higham 2002, § 1.14.1).
#[inline(always)]
pub fn exp_m1<R: Real>(x: R) -> R {
    let power = exp(x);
    let rounded = power - R::one();
    // Far from 0 the difference does not cancel.
    let corrected = R::select(x.abs().gt(R::one()), rounded, rounded * (x / ln(power)));
    R::select(rounded.eq(R::zero()), x, corrected)
}
