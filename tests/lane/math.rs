//! Lane maths against f64: dense sweeps, special values, equal bits at every width.

use super::ulp::{Worst, error, spacing};
use super::widths::{LaneFunction, assert_same_bits};
use octolux::lane::{Real, f32x16, math};
use std::f64::consts::{PI, TAU};

/// sin and cos of 2πu in f64, the reduction exact.
fn exact_sincos(u: f64) -> (f64, f64) {
    let quadrant = (u * 4.0).round();
    let (sin, cos) = (TAU * (u - quadrant * 0.25)).sin_cos();
    match quadrant as u32 % 4 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Applies `f` to 16 arguments at a time.
fn sweep(arguments: impl Iterator<Item = f32>, mut f: impl FnMut([f32; 16])) {
    let mut block = [0.0; 16];
    let mut filled = 0;
    for x in arguments {
        block[filled] = x;
        filled += 1;
        if filled == 16 {
            f(block);
            filled = 0;
        }
    }
    let first = block[0];
    block[filled..].fill(first);
    f(block);
}

#[test]
fn sincos_2pi_over_its_whole_domain() {
    // Every value the generator can make, then every exponent down to the subnormals.
    let drawn = (0..1u32 << 24).map(|k| k as f32 * 2f32.powi(-24));
    let patterns =
        (0..0x3f80_0000u32).step_by(61).map(f32::from_bits).chain([1.0, 0.5f32.next_down(), 1f32.next_down()]);
    let (mut sin_worst, mut cos_worst, mut norm) = (Worst::new(), Worst::new(), 0.0f64);
    sweep(drawn.chain(patterns), |block| {
        let (sin, cos) = math::sincos_2pi(f32x16::load(&block));
        for (i, &u) in block.iter().enumerate() {
            let (s, c) = exact_sincos(u.into());
            sin_worst.see(sin.lane(i), s, u);
            cos_worst.see(cos.lane(i), c, u);
            let (s, c) = (f64::from(sin.lane(i)), f64::from(cos.lane(i)));
            norm = norm.max((s * s + c * c - 1.0).abs());
        }
    });
    println!("sincos_2pi: sin {sin_worst:?}, cos {cos_worst:?}, |s² + c² − 1| {norm:e}");
    assert!(sin_worst.error <= 1.0 && cos_worst.error <= 1.0);
}

#[test]
fn sincos_2pi_is_exact_on_the_axes() {
    for (u, expected) in
        [(0.0, (0.0, 1.0)), (0.25, (1.0, 0.0)), (0.5, (0.0, -1.0)), (0.75, (-1.0, 0.0)), (1.0, (0.0, 1.0))]
    {
        assert_eq!(math::sincos_2pi(u), expected, "u = {u}");
    }
}

#[test]
fn atan2_over_ratios_and_quadrants() {
    let mut worst = Worst::new();
    // Ratios: every pattern of [0, 1] at a stride, in all eight octants.
    sweep((0..=0x3f80_0000u32).step_by(97).map(f32::from_bits), |block| {
        let (a, one) = (f32x16::load(&block), f32x16::one());
        for (y, x) in [(a, one), (one, a), (one, -a), (a, -one), (-a, -one), (-one, -a), (-one, a), (-a, one)] {
            let angle = math::atan2(y, x);
            for i in 0..16 {
                let at = (y.lane(i), x.lane(i));
                worst.see(angle.lane(i), f64::from(at.0).atan2(at.1.into()), at);
            }
        }
    });
    // Pairs of any magnitude, a pattern each from a Weyl sequence.
    let mut pattern = 0u32;
    for _ in 0..4_000_000 {
        pattern = pattern.wrapping_add(0x9e37_79b9);
        let (y, x) = (f32::from_bits(pattern), f32::from_bits(pattern.wrapping_mul(0x85eb_ca6b).rotate_left(13)));
        if y.is_finite() && x.is_finite() {
            worst.see(math::atan2(y, x), f64::from(y).atan2(x.into()), (y, x));
        }
    }
    println!("atan2: {worst:?}");
    assert!(worst.error <= 2.0);
}

#[test]
fn atan2_of_zeros_infinities_and_nans() {
    let specials = [0.0, 1e-45, f32::MIN_POSITIVE, 1.0, f32::MAX, f32::INFINITY];
    for y in specials.iter().flat_map(|&v| [v, -v]) {
        for x in specials.iter().flat_map(|&v| [v, -v]) {
            let (got, exact) = (math::atan2(y, x), f64::from(y).atan2(x.into()));
            assert!(error(got, exact) <= 2.0, "atan2({y:e}, {x:e}) = {got:e}, not {exact:e}");
            assert_eq!(got.is_sign_negative(), exact.is_sign_negative(), "atan2({y:e}, {x:e}) = {got:e}");
        }
        assert!(math::atan2(y, f32::NAN).is_nan() && math::atan2(f32::NAN, y).is_nan(), "{y}");
    }
    assert!(math::atan2(f32::NAN, f32::NAN).is_nan());
    assert_eq!(math::atan2(0.0, -1.0), PI as f32);
}

#[test]
fn exp_over_all_patterns() {
    let mut worst = Worst::new();
    sweep((0..u32::MAX).step_by(401).map(f32::from_bits), |block| {
        let got = math::exp(f32x16::load(&block));
        for (i, &x) in block.iter().enumerate() {
            let exact = f64::from(x).exp();
            // Past the largest f32 by half a unit the correctly rounded result is infinite.
            let overflows = exact >= f64::from(f32::MAX) + 0.5 * spacing(f32::MAX.into());
            worst.see(got.lane(i), if overflows { f64::INFINITY } else { exact }, x);
        }
    });
    // The interesting range densely.
    sweep((-104_000_000..89_000_000i32).step_by(13).map(|k| k as f32 * 1e-6), |block| {
        let got = math::exp(f32x16::load(&block));
        for (i, &x) in block.iter().enumerate() {
            let exact = f64::from(x).exp();
            if exact < f32::MAX.into() {
                worst.see(got.lane(i), exact, x);
            }
        }
    });
    println!("exp: {worst:?}");
    // Halves of: the sum with 1, the reduced argument and its tail (a quarter unit each); plus the polynomial.
    assert!(worst.error <= 1.1);
    assert_eq!(math::exp(0.0f32), 1.0);
    assert_eq!(math::exp(-0.0f32), 1.0);
    assert_eq!(math::exp(f32::INFINITY), f32::INFINITY);
    assert_eq!(math::exp(f32::NEG_INFINITY), 0.0);
    assert!(math::exp(f32::NAN).is_nan());
}

#[test]
fn ln_over_all_patterns() {
    let mut worst = Worst::new();
    let near_one = (0x3f00_0000..0x4000_0000u32).step_by(7);
    sweep((0..0x7f80_0000u32).step_by(211).chain(near_one).map(f32::from_bits), |block| {
        let got = math::ln(f32x16::load(&block));
        for (i, &x) in block.iter().enumerate() {
            worst.see(got.lane(i), f64::from(x).ln(), x);
        }
    });
    println!("ln: {worst:?}");
    assert!(worst.error <= 1.0);
    assert_eq!(math::ln(1.0f32), 0.0);
    assert_eq!(math::ln(0.0f32), f32::NEG_INFINITY);
    assert_eq!(math::ln(-0.0f32), f32::NEG_INFINITY);
    assert_eq!(math::ln(f32::INFINITY), f32::INFINITY);
    for x in [-1.0, -1e-45, f32::NEG_INFINITY, f32::NAN] {
        assert!(math::ln(x).is_nan(), "ln({x})");
    }
}

#[test]
fn the_same_bits_at_every_width() {
    struct All;
    impl LaneFunction for All {
        fn call<R: Real>(&self, input: &[R]) -> Vec<R> {
            let [a, b, u] = [input[0], input[1], input[2]];
            let (sin, cos) = math::sincos_2pi(u);
            vec![sin, cos, math::atan2(a, b), math::exp(a), math::ln(a)]
        }
    }
    let specials = [0.0, -0.0, 1e-45, 1.0, -1.0, 88.0, -104.0, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let mut rows: Vec<Vec<f32>> = Vec::new();
    rows.extend(specials.iter().flat_map(|&a| specials.map(|b| vec![a, b, 0.25])));
    let mut pattern = 1u32;
    rows.extend((0..200_000u32).map(|k| {
        pattern = pattern.wrapping_mul(0x0019_660d).wrapping_add(0x3c6e_f35f);
        let a = f32::from_bits(pattern);
        vec![a, f32::from_bits(pattern.rotate_left(11) ^ k), (pattern >> 8) as f32 * 2f32.powi(-24)]
    }));
    assert_same_bits(&All, &rows);
}
