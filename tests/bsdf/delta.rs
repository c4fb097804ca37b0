//! Mirrors, smooth glass and matched interfaces: directions, weights and probabilities of delta lobes.

use super::{at, glass, reference, to_f64, white_metal};
use crate::stats::{Moments, Rng, assert_mean};
use octolux::bsdf::{ALPHA_MIN, Conductor, ConductorFresnel, Model};
use octolux::lane::Vec3;

const ULP: f64 = 1.0 / (1u32 << 24) as f64;
const ANGLES: [f64; 7] = [1.0, 0.9, 0.5, 0.1, 1e-3, 1e-6, -0.7];

#[test]
fn a_mirror_reflects_exactly() {
    for mu in ANGLES {
        let wo = at::<f32>(mu, 0.4);
        for alpha in [0.0, ALPHA_MIN.next_down()] {
            let s = white_metal::<f32>(alpha, false).sample(wo, 0.5, [0.3, 0.9]);
            assert!(s.valid && s.delta && s.pdf == 0.0 && s.eta == 1.0);
            assert_eq!(s.wi.lane(0), [-wo.x, -wo.y, wo.z]);
            assert_eq!(s.weight.lane(0), [1.0; 3]);
            let eval = white_metal::<f32>(alpha, false).eval(wo, s.wi);
            assert!(eval.pdf == 0.0 && eval.value.lane(0) == [0.0; 3]);
        }
    }
    assert!(!white_metal::<f32>(ALPHA_MIN, false).sample(at(0.5, 0.4), 0.5, [0.3, 0.9]).delta);
}

#[test]
fn a_mirror_has_its_fresnel() {
    let (eta, k) = (Vec3::<f32>::splat([0.143, 0.375, 1.442]), Vec3::splat([3.98, 2.39, 1.6]));
    for mu in [1.0, 0.5, 0.1, -0.3] {
        let sample = |fresnel| Conductor { alpha: 0.0, separable: false, fresnel }.sample(at(mu, 0.4), 0.5, [0.3, 0.9]);
        let exact = sample(ConductorFresnel::exact(eta, k)).weight.lane(0);
        for (c, got) in exact.into_iter().enumerate() {
            let f = reference::conductor_f(mu.abs(), eta.lane(0)[c].into(), k.lane(0)[c].into());
            assert!((f64::from(got) - f).abs() < 32.0 * ULP, "{mu}: {got} for {f}");
        }
        let schlick = sample(ConductorFresnel::schlick(Vec3::splat([0.2; 3]))).weight.x;
        let f = 0.2 + 0.8 * (1.0 - mu.abs()).powi(5);
        assert!((f64::from(schlick) - f).abs() < 8.0 * ULP);
        assert_eq!(sample(ConductorFresnel::constant(Vec3::splat([0.3, 0.2, 0.1]))).weight.lane(0), [0.3, 0.2, 0.1]);
    }
}

#[test]
fn smooth_glass_refracts_by_snell() {
    for mu in ANGLES {
        for ior in [1.5f32, 1.1, 0.8, 2.4] {
            let wo = at::<f32>(mu, 0.4);
            let s = glass::<f32>(0.0, false, ior).sample(wo, 1.0 - 2f32.powi(-24), [0.3, 0.9]);
            if s.eta == 1.0 {
                continue; // total internal reflection, or F within 2⁻²⁴ of 1
            }
            assert!(s.valid && s.delta && s.pdf == 0.0 && (s.wi.z < 0.0) == (wo.z > 0.0));
            let eta = if mu > 0.0 { f64::from(ior) } else { 1.0 / f64::from(ior) };
            assert!((f64::from(s.eta) - eta).abs() <= ULP * eta);
            let (o, i) = (to_f64(wo.lane(0)), to_f64(s.wi.lane(0)));
            for axis in 0..2 {
                assert!((o[axis] + eta * i[axis]).abs() <= 4.0 * ULP * o[axis].abs(), "{wo:?} {s:?}");
            }
            // cos²θt is a difference of numbers up to 1; its root near 0 has half the digits.
            let cos2 = 1.0 - (o[0] * o[0] + o[1] * o[1]) / (eta * eta);
            assert!((i[2] * i[2] - cos2).abs() < 8.0 * ULP * (1.0 + 1.0 / (eta * eta)), "{wo:?} {s:?}");
            assert!((f64::from(s.weight.x) * eta * eta - 1.0).abs() < 4.0 * ULP);
        }
    }
}

#[test]
fn smooth_glass_reflects_as_often_as_fresnel_says() {
    let mut rng = Rng::new(61);
    for mu in [1.0, 0.5, 0.1, -0.9, -0.78, -0.5] {
        let wo = at::<f32>(mu, 0.4);
        let reflected: Moments = (0..400_000)
            .map(|_| {
                let s = glass::<f32>(0.0, false, 1.5).sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
                assert!(s.valid);
                f64::from(u8::from(s.wi.z * wo.z > 0.0))
            })
            .collect();
        let eta = if mu > 0.0 { 1.5 } else { 1.0 / 1.5 };
        // The drawn number has steps of 2⁻²⁴; F some ulp.
        assert_mean(&format!("cosine {mu}"), &reflected, reference::dielectric_f(mu.abs(), eta), 64.0 * ULP, 6);
    }
}

#[test]
fn total_internal_reflection_never_transmits() {
    for mu in [-0.7f64, -0.3, -1e-4] {
        let wo = at::<f32>(mu, 0.4);
        for u in [0.0, 0.5, 1.0 - 2f32.powi(-24)] {
            let s = glass::<f32>(0.0, false, 1.5).sample(wo, u, [0.3, 0.9]);
            assert_eq!(s.wi.lane(0), [-wo.x, -wo.y, wo.z]);
            assert!(s.valid && s.weight.x == 1.0 && s.eta == 1.0);
        }
    }
}

#[test]
fn a_matched_interface_is_not_there() {
    for mu in ANGLES {
        let wo = at::<f32>(mu, 0.4);
        for alpha in [0.0, 0.1, 1.0] {
            for u in [0.0, 0.5] {
                let s = glass::<f32>(alpha, false, 1.0).sample(wo, u, [0.3, 0.9]);
                assert!(s.valid && s.delta && s.eta == 1.0 && s.weight.lane(0) == [1.0; 3], "{s:?}");
                assert_eq!(s.wi.lane(0), [-wo.x, -wo.y, -wo.z]);
            }
        }
    }
}
