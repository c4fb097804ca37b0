//! Lane maths where one value says it all: axes, zeros, infinities, NaN; equal bits at every width. The errors over
//! all arguments are the catalogue's (`octolux check --numerics`, run by `tests/numerics`).

use super::widths::{LaneFunction, assert_same_bits};
use octolux::check::numerics::ulp::error;
use octolux::lane::{Real, f32x16, math};
use std::f64::consts::PI;

/// Every value the generator can make.
#[test]
fn sincos_2pi_is_a_unit_vector() {
    let mut norm = 0.0f64;
    for k in (0..1u32 << 24).step_by(16) {
        let (sin, cos) = math::sincos_2pi(f32x16::from_fn(|i| (k + i as u32) as f32 * 2f32.powi(-24)));
        for i in 0..16 {
            let (s, c) = (f64::from(sin.lane(i)), f64::from(cos.lane(i)));
            norm = norm.max((s * s + c * c - 1.0).abs());
        }
    }
    println!("|s² + c² − 1| ≤ {norm:e}");
    // An ulp of each, 2⁻²⁴ at most for values below 1, times twice the value: |s| + |c| ≤ √2.
    assert!(norm <= 2.0 * 2f64.sqrt() * 2f64.powi(-24));
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
fn exp_of_zeros_infinities_and_nan() {
    assert_eq!([0.0, -0.0].map(math::exp::<f32>), [1.0; 2]);
    assert_eq!([f32::INFINITY, f32::NEG_INFINITY].map(math::exp::<f32>), [f32::INFINITY, 0.0]);
    assert!(math::exp(f32::NAN).is_nan());
}

#[test]
fn ln_of_zeros_infinities_and_nan() {
    assert_eq!(math::ln(1.0f32), 0.0);
    assert_eq!([0.0, -0.0].map(math::ln::<f32>), [f32::NEG_INFINITY; 2]);
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
