//! The functions of lanes of one argument, each with its f64 truth.

use crate::lane::{Real, math};
use std::f64::consts::{FRAC_PI_4, TAU};

/// A function of one argument as the sweep sees it.
pub trait Unary: Sync {
    const NAME: &'static str;
    /// In ulp, from where the function is written.
    const BOUND: f64;
    /// Do the signs of zeros count?
    const SIGNED_ZERO: bool = true;
    fn call<R: Real>(x: R) -> R;
    /// `None` outside the domain, where only a finite result is promised, and that for |x| below 2¹²⁶.
    fn exact(x: f32) -> Option<f64>;
}

/// Correct rounding is half a unit; the f64 truth itself is rounded.
const CORRECTLY_ROUNDED: f64 = 0.5 + 1e-6;

macro_rules! unary {
    ($name:ident, $shown:literal, $bound:expr, $call:expr, $exact:expr) => {
        pub struct $name;
        impl Unary for $name {
            const NAME: &'static str = $shown;
            const BOUND: f64 = $bound;
            #[inline(always)]
            fn call<R: Real>(x: R) -> R {
                let f: fn(R) -> R = $call;
                f(x)
            }
            fn exact(x: f32) -> Option<f64> {
                let f: fn(f64) -> f64 = $exact;
                Some(f(f64::from(x)))
            }
        }
    };
}

unary!(Exp, "exp", 1.1, math::exp::<R>, exp);
unary!(Ln, "ln", 1.0, math::ln::<R>, f64::ln);
unary!(Ln1p, "ln(1 + x)", 4.0, math::ln_1p::<R>, f64::ln_1p);
unary!(ExpM1, "exp(x) - 1", 4.0, math::exp_m1::<R>, f64::exp_m1);
unary!(Atan, "atan2(x, 1)", 2.0, |x| math::atan2(x, R::one()), f64::atan);
unary!(Acot, "atan2(1, x)", 2.0, |x| math::atan2(R::one(), x), |x| 1f64.atan2(x));
unary!(Sqrt, "sqrt", CORRECTLY_ROUNDED, R::sqrt, f64::sqrt);
unary!(Recip, "reciprocal", CORRECTLY_ROUNDED, R::recip, f64::recip);
unary!(Round, "round", 0.0, R::round, f64::round_ties_even);
unary!(Floor, "floor", 0.0, R::floor, f64::floor);

/// Most arguments over- or underflow: those need no library call.
fn exp(x: f64) -> f64 {
    if x > 100.0 {
        f64::INFINITY
    } else if x < -110.0 {
        0.0
    } else {
        x.exp()
    }
}

/// sin and cos of 2πu: the argument reduced exactly to [−1/8, 1/8] turns.
fn sincos_2pi(u: f32) -> Option<(f64, f64)> {
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let u = f64::from(u);
    let quadrant = (u * 4.0).round();
    let angle = TAU * (u - quadrant * 0.25);
    debug_assert!(angle.abs() <= FRAC_PI_4 * (1.0 + 1e-15));
    let (sin, cos) = angle.sin_cos();
    Some(match quadrant as u32 % 4 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    })
}

pub struct Sin2Pi;
impl Unary for Sin2Pi {
    const NAME: &'static str = "sin(2πu)";
    const BOUND: f64 = 1.0;
    const SIGNED_ZERO: bool = false;
    #[inline(always)]
    fn call<R: Real>(x: R) -> R {
        math::sincos_2pi(x).0
    }
    fn exact(x: f32) -> Option<f64> {
        sincos_2pi(x).map(|(sin, _)| sin)
    }
}

pub struct Cos2Pi;
impl Unary for Cos2Pi {
    const NAME: &'static str = "cos(2πu)";
    const BOUND: f64 = 1.0;
    const SIGNED_ZERO: bool = false;
    #[inline(always)]
    fn call<R: Real>(x: R) -> R {
        math::sincos_2pi(x).1
    }
    fn exact(x: f32) -> Option<f64> {
        sincos_2pi(x).map(|(_, cos)| cos)
    }
}
