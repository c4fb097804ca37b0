//! The coated base against f64, its own density, and itself; a smooth coat is a delta lobe above a base that is none.

use super::chi2::chi2;
use super::{at, coat, dot, reference, to_f64};
use crate::oracle::{Albedo, bsdf_eval, directional_albedo};
use crate::sampling::draw::one_by_one;
use crate::stats::{Moments, Rng, assert_mean};
use octolux::bsdf::{ALPHA_MIN, Model};
use octolux::lane::{Real, f32x8};
use octolux::scene::{Bsdf, Masking};
use std::f64::consts::PI;

const ULP: f64 = 1.0 / (1u32 << 24) as f64;
/// Means tested in this file, rounded up.
const TESTS: usize = 64;

#[test]
fn samples_follow_the_density() {
    for alpha in [0.15, 0.6] {
        for mu in [1.0, 0.5, 0.05, -0.6] {
            let (lanes, scalar) = (coat::<f32x8>(0.6, alpha, false, 1.5), coat::<f32>(0.6, alpha, false, 1.5));
            chi2(format!("coat {alpha}, cosine {mu}"), &lanes, &scalar, mu, |test| test.cells(16, 32));
        }
    }
    // What is not delta follows the base's share of the density.
    for mu in [1.0, 0.1, -0.6] {
        let (lanes, scalar) = (coat::<f32x8>(0.6, 0.0, false, 1.5), coat::<f32>(0.6, 0.0, false, 1.5));
        chi2(format!("smooth coat, cosine {mu}"), &lanes, &scalar, mu, |test| test);
    }
    let (lanes, scalar) = (coat::<f32x8>(0.0, 0.3, true, 1.5), coat::<f32>(0.0, 0.3, true, 1.5));
    chi2("coat on black".into(), &lanes, &scalar, 0.4, |test| test.cells(16, 32));
}

/// What rounding may do: to half vectors (as with a conductor), and to F of the facet and of both directions.
fn tolerance(alpha: f32, half_length: f64, units: f64) -> f64 {
    let roughness = if alpha < ALPHA_MIN { f64::INFINITY } else { alpha.into() };
    96.0 * ULP + units * ULP / half_length * (4.0 + 2.0 / roughness)
}

#[test]
fn eval_and_weights_are_the_formula() {
    let mut rng = Rng::new(95);
    let mut judged = [0u32; 3];
    for _ in 0..200_000 {
        let separable = rng.f64() < 0.5;
        let alpha = if rng.f64() < 0.2 { 0.0 } else { (10f64.powf(rng.range(-4.0, 0.0)) as f32).max(ALPHA_MIN) };
        let (rho, ior) = (rng.f32(), 1.1 + rng.f32());
        let model = coat::<f32>(rho, alpha, separable, ior);
        let masking = if separable { Masking::Separable } else { Masking::Correlated };
        let bsdf = Bsdf::Coated { reflectance: [rho; 3], alpha, masking, ior };
        let mu = 10f64.powf(rng.range(-3.0, 0.0)).copysign(rng.f64() - 0.5);
        let wo = at(mu, rng.range(0.0, 7.0));
        let s = model.sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
        let any = at(10f64.powf(rng.range(-3.0, 0.0)).copysign(mu), rng.range(0.0, 7.0));
        if s.delta && s.valid {
            assert_eq!(s.wi.lane(0), [-wo.x, -wo.y, wo.z]);
            assert!(alpha < ALPHA_MIN && s.pdf == 0.0);
            judged[2] += 1;
        }
        for (k, wi) in [s.wi, any].into_iter().enumerate() {
            if k == 0 && (!s.valid || s.delta) {
                continue;
            }
            let (o, i) = (to_f64(wo.lane(0)), to_f64(wi.lane(0)));
            let h: [f64; 3] = std::array::from_fn(|a| o[a] + i[a]);
            let half_length = dot(h, h).sqrt();
            let unit = |w: [f64; 3]| w.map(|x| x / dot(w, w).sqrt());
            let exact = bsdf_eval(&bsdf, unit(o), unit(i))[0];
            let allowed = tolerance(alpha, half_length, 6.0);
            let eval = model.eval(wo, wi);
            if allowed < 0.1 {
                let value = f64::from(eval.value.x);
                assert!(
                    (value - exact).abs() <= allowed * exact,
                    "{bsdf:?}: {value:e} for {exact:e} ± {allowed:e}, {wo:?} {wi:?}"
                );
                judged[k] += 1;
            }
            let allowed = tolerance(alpha, half_length, 24.0);
            if k == 0 && allowed < 0.1 {
                let product = f64::from(s.weight.x) * f64::from(s.pdf);
                assert!(
                    (product - exact).abs() <= allowed * exact,
                    "{bsdf:?}: weight · pdf {product:e} for {exact:e}, {wo:?} {s:?}"
                );
                let (found, claimed) = (f64::from(s.pdf), f64::from(eval.pdf));
                assert!((found - claimed).abs() <= allowed * claimed, "{bsdf:?}: pdf {found:e} for {claimed:e}");
            }
        }
    }
    println!("judged {judged:?}");
    assert!(judged[0] > 80_000 && judged[1] > 100_000 && judged[2] > 5_000, "{judged:?}");
}

#[test]
fn reciprocity() {
    let mut rng = Rng::new(96);
    for _ in 0..100_000 {
        let alpha = (10f64.powf(rng.range(-4.0, 0.0)) as f32).max(ALPHA_MIN);
        let model = coat::<f32>(0.7, alpha, rng.f64() < 0.5, 1.5);
        let direction = |rng: &mut Rng| at::<f32>(10f64.powf(rng.range(-3.0, 0.0)), rng.range(0.0, 7.0));
        let (wo, wi) = (direction(&mut rng), direction(&mut rng));
        let there = f64::from(model.eval(wo, wi).value.x) / f64::from(wi.z);
        let back = f64::from(model.eval(wi, wo).value.x) / f64::from(wo.z);
        let allowed = 48.0 * ULP;
        assert!((there - back).abs() <= allowed * there, "{there:e} and {back:e} ± {allowed:e}");
    }
}

/// Albedo by quadrature: at most 1 on a white base, and what sampling finds.
#[test]
fn no_more_leaves_than_arrives() {
    for alpha in [0.0f32, 0.1, 0.4, 1.0] {
        for mu in [1.0, 0.7, 0.2, 0.02] {
            let bsdf = Bsdf::Coated { reflectance: [1.0, 0.5, 0.0], alpha, masking: Masking::Correlated, ior: 1.5 };
            let Albedo { reflected, .. } = directional_albedo(&bsdf, to_f64(at::<f32>(mu, 0.3).lane(0)));
            assert!(reflected.iter().all(|&a| a <= 1.0), "alpha {alpha}, {mu}: {reflected:?}");
            for (c, rho) in [1.0, 0.5, 0.0].into_iter().enumerate() {
                let model = coat::<f32x8>(rho, alpha, false, 1.5);
                let mut next = one_by_one(97, |rng| {
                    let s = model.sample(at(mu, 0.3), rng.next_unit(), [rng.next_unit(), rng.next_unit()]);
                    std::array::from_fn(|i| f64::from(s.weight.x.lane(i)))
                });
                let weights: Moments = (0..100_000).map(|_| next()).collect();
                assert_mean(&format!("coat {alpha} on {rho}, {mu}"), &weights, reflected[c], 1e-6, TESTS);
            }
        }
    }
}

/// A delta lobe and a density side by side: the mirror's weight over its probability, the base by its cosine.
#[test]
fn a_smooth_coat_is_both() {
    let mut rng = Rng::new(98);
    for mu in [1.0, 0.5, 0.1, -0.3] {
        let (wo, rho) = (at::<f32>(mu, 0.4), 0.6);
        let model = coat::<f32>(rho as f32, 0.0, false, 1.5);
        let f = reference::dielectric_f(f64::from(wo.z.abs()), 1.5);
        let share = f / (f + (1.0 - f) * rho);
        let mut chosen = Moments::new();
        for _ in 0..100_000 {
            let s = model.sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
            chosen.push(f64::from(u8::from(s.delta)));
            if s.delta {
                assert!((f64::from(s.weight.x) * share - f).abs() < 16.0 * ULP, "{s:?}");
            } else {
                let expected = (1.0 - share) * f64::from(s.wi.z.abs()) / PI;
                assert!((f64::from(s.pdf) - expected).abs() < 16.0 * ULP * expected.max(share), "{} {expected}", s.pdf);
            }
        }
        assert_mean(&format!("cosine {mu}"), &chosen, share, 64.0 * ULP, TESTS);
        // Light samples in the mirror direction see the base alone.
        let eval = model.eval(wo, octolux::lane::Vec3::new(-wo.x, -wo.y, wo.z));
        let base = (1.0 - f).powi(2) * rho / PI * mu.abs();
        assert!((f64::from(eval.value.x) - base).abs() < 32.0 * ULP * base, "{eval:?} for {base}");
    }
}
