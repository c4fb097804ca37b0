//! sample against eval, eval against f64, reciprocity, energy.

use super::{dot, glass, reference, to_f64, to_lane, white_metal};
use crate::stats::Rng;
use octolux::bsdf::{ALPHA_MIN, Diffuse, Model};
use octolux::lane::{Mask, Real};
use octolux::lane::{Vec3, f32x8};

const ULP: f64 = 1.0 / (1u32 << 24) as f64;

fn random_alpha(rng: &mut Rng) -> f32 {
    (10f64.powf(rng.range(-4.0, 0.0)) as f32).max(ALPHA_MIN)
}

/// A direction on either side, grazing ones as often as steep ones.
fn random_direction(rng: &mut Rng) -> Vec3<f32> {
    let mu = 10f64.powf(rng.range(-4.0, 0.0)).copysign(rng.f64() - 0.5);
    super::at(mu, rng.range(0.0, 7.0))
}

/// |wo + s·wi|, s = 1 for reflection, else the relative index: the length of what the half vector is normalised from.
fn half_length(wo: Vec3<f32>, wi: Vec3<f32>, ior: f64) -> f64 {
    let (wo, wi) = (to_f64(wo.lane(0)), to_f64(wi.lane(0)));
    let s = if wo[2] * wi[2] > 0.0 { 1.0 } else { ior.powf(wo[2].signum()) };
    let h: [f64; 3] = std::array::from_fn(|k| wo[k] + s * wi[k]);
    dot(h, h).sqrt()
}

/// What a direction's rounding does to D: its slope is off by `units`·2⁻²⁴/|h|, and d ln D/d slope ≤ 2/α; everything
/// else is a few dozen roundings.
fn tolerance(units: f64, half_length: f64, alpha: f32) -> f64 {
    48.0 * ULP + units * ULP / half_length * (4.0 + 2.0 / f64::from(alpha))
}

/// Draws until `n` valid samples of `model` were seen by `check(wo, sample weight, pdf, wi)`.
fn weight_times_pdf_is_value(
    name: &str,
    model: &impl Model<f32>,
    wo: Vec3<f32>,
    rng: &mut Rng,
    tolerance: impl Fn(Vec3<f32>) -> f64,
) -> bool {
    let s = model.sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
    if !s.valid {
        assert!(s.weight.x == 0.0 && s.pdf == 0.0, "{name}: {s:?}");
        return false;
    }
    let eval = model.eval(wo, s.wi);
    let product = f64::from(s.weight.x) * f64::from(s.pdf);
    let allowed = tolerance(s.wi);
    if allowed > 0.1 {
        return false;
    }
    let (value, pdf) = (f64::from(eval.value.x), f64::from(eval.pdf));
    assert!(
        (product - value).abs() <= allowed * value,
        "{name}: {product:e} for {value:e} ± {allowed:e}, {wo:?} {s:?}"
    );
    assert!((f64::from(s.pdf) - pdf).abs() <= allowed * pdf, "{name}: pdf {} for {pdf:e} ± {allowed:e}", s.pdf);
    true
}

#[test]
fn weight_times_pdf_is_the_value() {
    let mut rng = Rng::new(51);
    let mut judged = [0u32; 3];
    for _ in 0..200_000 {
        let (alpha, separable) = (random_alpha(&mut rng), rng.f64() < 0.5);
        let ior = 2f64.powf(rng.range(-1.0, 1.0)) as f32;
        let wo = random_direction(&mut rng);
        let diffuse = Diffuse { reflectance: Vec3::splat([0.3, 0.6, 0.9]) };
        judged[0] += u32::from(weight_times_pdf_is_value("diffuse", &diffuse, wo, &mut rng, |_| 4.0 * ULP));
        // wi is off by a few units of 2⁻²⁴ from the h that was drawn: h's own length (3), the product (2), the sum (1).
        let bound = |wi| tolerance(8.0, half_length(wo, wi, f64::from(ior)), alpha);
        let metal = white_metal::<f32>(alpha, separable);
        judged[1] += u32::from(weight_times_pdf_is_value("conductor", &metal, wo, &mut rng, bound));
        let name = format!("dielectric {alpha} {ior}");
        let glass = glass::<f32>(alpha, separable, ior);
        let facet = |wi: Vec3<f32>| bound(wi) + facet_tolerance(wo, wi, ior);
        if !glass.sample(wo, 0.0, [0.0; 2]).delta {
            judged[2] += u32::from(weight_times_pdf_is_value(&name, &glass, wo, &mut rng, facet));
        }
    }
    println!("judged {judged:?} of 200000 each");
    assert!(judged[0] == 200_000 && judged[1] > 100_000 && judged[2] > 50_000);
}

/// What the rounding of directions and of 1/ior does to a dielectric beyond [`tolerance`]: the cosines to the facet,
/// |wo·h| and |wi·h|, are off by some 2⁻²⁴/|h|, and with them F or 1 − F, without bound at the critical angle.
fn facet_tolerance(wo: Vec3<f32>, wi: Vec3<f32>, ior: f32) -> f64 {
    let length = half_length(wo, wi, ior.into());
    let (o, i) = (to_f64(wo.lane(0)), to_f64(wi.lane(0)));
    let eta = f64::from(ior).powf(o[2].signum());
    let reflects = o[2] * i[2] > 0.0;
    let s = if reflects { 1.0 } else { eta };
    let h: [f64; 3] = std::array::from_fn(|k| (o[k] + s * i[k]) / length);
    let (cos_o, cos_i) = (dot(o, h).abs(), dot(i, h).abs());
    let off = 8.0 * ULP / length;
    let probability = |cos: f64, eta: f64| {
        let f = reference::dielectric_f(cos.clamp(0.0, 1.0), eta);
        if reflects { f } else { 1.0 - f }
    };
    let nearby = [(off, 0.0), (-off, 0.0), (0.0, 4.0 * ULP), (0.0, -4.0 * ULP)];
    let exact = probability(cos_o, eta);
    let spread: f64 = nearby.iter().map(|&(dc, de)| (probability(cos_o + dc, eta * (1.0 + de)) - exact).abs()).sum();
    spread / exact + off / cos_o.min(cos_i)
}

#[test]
fn eval_is_the_papers_formula() {
    let mut rng = Rng::new(52);
    let (mut judged, mut worst) = ([0u32; 2], 0.0f64);
    for _ in 0..400_000 {
        let (alpha, separable) = (random_alpha(&mut rng), rng.f64() < 0.5);
        let ior = 2f64.powf(rng.range(-1.0, 1.0)) as f32;
        let wo = random_direction(&mut rng);
        let glass = glass::<f32>(alpha, separable, ior);
        // Half the directions from the lobe, half from anywhere.
        let drawn = glass.sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
        let wi = if rng.f64() < 0.5 && drawn.valid { drawn.wi } else { random_direction(&mut rng) };
        let (o, i) = (to_f64(wo.lane(0)), to_f64(wi.lane(0)));
        // Unit length holds to 4 ulp in a sampled wi: as in the comparison with sample.
        let allowed = tolerance(6.0, half_length(wo, wi, ior.into()), alpha);

        let metal = white_metal::<f32>(alpha, separable).eval(wo, wi);
        if o[2] * i[2] < 0.0 {
            assert!(metal.value.x == 0.0 && metal.pdf == 0.0);
        } else if allowed < 0.1 {
            let up = |w: [f64; 3]| [w[0], w[1], w[2].abs()];
            let exact = reference::conductor(up(o), up(i), alpha.into(), separable);
            for (got, exact) in [metal.value.x, metal.pdf].into_iter().zip(exact) {
                worst = worst.max((f64::from(got) / exact - 1.0).abs() / allowed);
                assert!((f64::from(got) - exact).abs() <= allowed * exact, "conductor {alpha}: {got:e} for {exact:e}");
            }
            judged[0] += 1;
        }
        let allowed = allowed + facet_tolerance(wo, wi, ior);
        if allowed < 0.1 && !drawn.delta {
            let eval = glass.eval(wo, wi);
            let exact = reference::dielectric(o, i, alpha.into(), separable, ior.into());
            for (got, exact) in [eval.value.x, eval.pdf].into_iter().zip(exact) {
                let close = (f64::from(got) - exact).abs() <= allowed * exact;
                assert!(close, "dielectric {alpha} {ior}: {got:e} for {exact:e} ± {allowed:e}, {wo:?} {wi:?}");
            }
            judged[1] += u32::from(exact[0] > 0.0);
        }
    }
    println!("judged {judged:?}, worst {worst} of what is allowed");
    assert!(judged[0] > 50_000 && judged[1] > 50_000);
}

#[test]
fn reciprocity() {
    let mut rng = Rng::new(53);
    let mut judged = 0;
    for _ in 0..200_000 {
        let (alpha, separable) = (random_alpha(&mut rng), rng.f64() < 0.5);
        let ior = 2f64.powf(rng.range(-1.0, 1.0)) as f32;
        let wo = random_direction(&mut rng);
        let glass = glass::<f32>(alpha, separable, ior);
        let s = glass.sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
        if !s.valid || s.delta {
            continue;
        }
        let (co, ci) = (f64::from(wo.z.abs()), f64::from(s.wi.z.abs()));
        // f is value/cosine; transmission gains η² one way and loses it the other.
        let there = f64::from(glass.eval(wo, s.wi).value.x) * co * f64::from(s.eta).powi(2);
        let back = f64::from(glass.eval(s.wi, wo).value.x) * ci;
        let length = half_length(wo, s.wi, ior.into()).min(half_length(s.wi, wo, ior.into()));
        let facets = facet_tolerance(wo, s.wi, ior) + facet_tolerance(s.wi, wo, ior);
        let allowed = 2.0 * tolerance(6.0, length, alpha) + facets;
        if allowed < 0.1 {
            assert!(
                (there - back).abs() <= allowed * there,
                "{there:e} and {back:e} ± {allowed:e}, {alpha} {ior} {wo:?} {s:?}"
            );
            judged += 1;
        }

        let metal = white_metal::<f32>(alpha, separable);
        let wi = random_direction(&mut rng);
        let (there, back) = (metal.eval(wo, wi).value.x, metal.eval(wi, wo).value.x);
        let (there, back) = (f64::from(there) * co, f64::from(back) * f64::from(wi.z.abs()));
        // The same sums, only G2 is put together differently.
        assert!((there - back).abs() <= 24.0 * ULP * there, "{there:e} and {back:e}");
    }
    assert!(judged > 50_000, "{judged}");
}

#[test]
fn no_sample_gains_energy() {
    let mut rng = Rng::new(54);
    let limit = 1.0 + 2.0 * f32::EPSILON;
    for _ in 0..300_000 {
        let (alpha, separable) = (if rng.f64() < 0.1 { 0.0 } else { random_alpha(&mut rng) }, rng.f64() < 0.5);
        let wo = random_direction(&mut rng);
        let metal = white_metal::<f32>(alpha, separable).sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
        assert!((0.0..=limit).contains(&metal.weight.x), "{metal:?}");
        let glass = glass::<f32>(alpha, separable, 1.5).sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
        let flux = glass.weight.x * glass.eta * glass.eta;
        assert!((0.0..=limit).contains(&flux), "{glass:?}");
        // Radiance is scaled, and eta says by how much.
        let crossed = glass.valid && (glass.wi.z > 0.0) != (wo.z > 0.0);
        let expected = if !crossed {
            1.0
        } else if wo.z > 0.0 {
            1.5
        } else {
            1.0 / 1.5
        };
        assert!(!glass.valid || glass.eta == expected, "{glass:?}");
    }
}

#[test]
fn diffuse_is_lambert_on_both_sides() {
    let reflectance = Vec3::<f32>::splat([0.25, 0.5, 1.0]);
    let model = Diffuse { reflectance };
    let mut rng = Rng::new(55);
    for _ in 0..10_000 {
        let (wo, wi) = (random_direction(&mut rng), random_direction(&mut rng));
        let eval = model.eval(wo, wi);
        let exact = if wo.z * wi.z > 0.0 { f64::from(wi.z.abs()) / std::f64::consts::PI } else { 0.0 };
        assert!((f64::from(eval.pdf) - exact).abs() <= 2.0 * ULP * exact);
        assert_eq!(eval.value.lane(0), [0.25 * eval.pdf, 0.5 * eval.pdf, eval.pdf]);
        let s = model.sample(wo, rng.f32(), [rng.f32(), rng.f32()]);
        assert!(s.valid && !s.delta && s.wi.z * wo.z > 0.0 && s.eta == 1.0);
        assert_eq!(s.weight.lane(0), reflectance.lane(0));
    }
}

#[test]
fn lanes_may_differ_in_kind() {
    // One register: mirror, rough, smooth glass, matched glass …, each as alone.
    let alphas = [0.0, 0.5, 0.0, 0.3, 1e-4, 9e-5, 1.0, 0.1];
    let iors = [1.5, 1.5, 1.3, 1.0, 2.0, 1.5, 0.8, 1.0001];
    let mut model = glass::<f32x8>(0.0, false, 1.0);
    model.alpha = f32x8::from_fn(|i| alphas[i]);
    model.ior = f32x8::from_fn(|i| iors[i]);
    let wo = to_lane::<f32x8>([0.6, 0.0, 0.8]);
    let s = model.sample(wo, f32x8::splat(0.5), [f32x8::splat(0.25), f32x8::splat(0.75)]);
    for i in 0..8 {
        let alone = glass::<f32>(alphas[i], false, iors[i]).sample(to_lane([0.6, 0.0, 0.8]), 0.5, [0.25, 0.75]);
        assert_eq!(s.wi.lane(i), alone.wi.lane(0));
        assert_eq!((s.weight.x.lane(i), s.pdf.lane(i)), (alone.weight.x, alone.pdf));
        assert_eq!((s.delta.lane(i), s.valid.lane(i)), (alone.delta, alone.valid));
    }
    assert_eq!(s.delta.bits(), 0b0010_1101);
}
