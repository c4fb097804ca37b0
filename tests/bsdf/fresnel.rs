//! Fresnel reflectance against the oracles and f64.

use super::reference;
use crate::stats::{self, OracleCase, oracle, oracles_in, quadrature};
use octolux::bsdf::fresnel::{RelativeIor, conductor, schlick_weight};

const ULP: f64 = 1.0 / (1u32 << 24) as f64;

fn dielectric(cos: f32, ior: f32, outside: bool) -> f64 {
    RelativeIor::new(ior, outside).fresnel(cos).0.into()
}

/// |F − exact| within 16 ulp of F, for a cosine within 4 ulp of the given one: what backward stability promises.
fn assert_near(name: &str, got: f64, cos: f64, exact: impl Fn(f64) -> f64) {
    let nearby: Vec<f64> = (-8..=8).map(|k| exact((cos * (1.0 + 0.5 * f64::from(k) * ULP)).min(1.0))).collect();
    let (low, high) = nearby.iter().fold((f64::MAX, 0f64), |(low, high), &f| (low.min(f), high.max(f)));
    let slack = 16.0 * ULP;
    assert!(got >= low * (1.0 - slack) && got <= high * (1.0 + slack), "{name}: {got:e} outside [{low:e}, {high:e}]");
}

fn number_after(case: &OracleCase, key: &str) -> f64 {
    let text = &case.setup[case.setup.find(key).unwrap() + key.len()..];
    let end = text.find(|c: char| !(c.is_ascii_digit() || ".e-".contains(c))).unwrap_or(text.len());
    text[..end].trim_end_matches('.').parse().unwrap()
}

#[test]
fn dielectric_oracles() {
    for case in oracles_in("Fresnel").iter().filter(|case| case.setup.starts_with("Dielectric")) {
        let (eta, cos) = (number_after(case, "eta="), number_after(case, "cos_i="));
        // The formula at the f32 of the cosine; that the f64 formula is the oracle's is checked beside it.
        assert!((reference::dielectric_f(cos, eta) - case.value).abs() < 1e-14, "{}", case.id);
        assert_near(&case.id, dielectric(cos as f32, eta as f32, true), cos, |c| reference::dielectric_f(c, eta));
    }
    let Some(brewster) = oracle("F.brewster1.5") else { return };
    let cos = 1.0 / (1f64 + 1.5 * 1.5).sqrt();
    assert_near("Brewster", dielectric(cos as f32, 1.5, true), cos, |c| reference::dielectric_f(c, 1.5));
    assert!((reference::dielectric_f(cos, 1.5) - brewster.value).abs() < 1e-15);
}

#[test]
fn near_matched_indices_keep_their_digits() {
    let Some(case) = oracle("F.eta1+2^-20(f32-exact)_mu1e-3") else { return };
    let eta = 1.0 + 2f64.powi(-20);
    assert!((reference::dielectric_f(1e-3, eta) - case.value).abs() < 1e-8);
    assert_near(&case.id, dielectric(1e-3, eta as f32, true), 1e-3, |c| reference::dielectric_f(c, eta));
    // From inside too, where 1/η is not an f32. The f64 formula cancels to about 2⁻⁵²/2⁻²⁰ relative: far below an ulp.
    for cos in [0.9, 0.5, 0.1, 0.01] {
        assert_near("inside", dielectric(cos as f32, eta as f32, false), cos, |c| {
            reference::dielectric_f(c, 1.0 / eta)
        });
    }
}

#[test]
fn total_internal_reflection_is_exactly_1() {
    let Some(critical) = oracle("F.crit_cos_1.5") else { return };
    let Some(above) = oracle("F.tir_above_1e-6") else { return };
    assert_eq!(dielectric((critical.value - 1e-6) as f32, 1.5, false), above.value);
    assert!(dielectric((critical.value + 1e-6) as f32, 1.5, false) < 1.0);
    for cos in [0.0, 1e-6, 0.3, 0.7] {
        assert_eq!(dielectric(cos, 1.5, false), 1.0);
    }
}

#[test]
fn a_matched_index_reflects_exactly_nothing() {
    for outside in [true, false] {
        for cos in [1.0, 0.7, 0.1, 1e-6, 1e-30, 0.0] {
            assert_eq!(dielectric(cos, 1.0, outside), 0.0, "cos {cos}");
        }
    }
}

#[test]
fn dielectrics_over_indices_and_angles() {
    let mut rng = stats::Rng::new(21);
    for _ in 0..200_000 {
        let ior = 2f64.powf(rng.range(-1.5, 1.5)) as f32;
        let cos = 10f64.powf(rng.range(-6.0, 0.0)) as f32;
        let outside = rng.f64() < 0.5;
        let eta = if outside { ior.into() } else { 1.0 / f64::from(ior) };
        let f = dielectric(cos, ior, outside);
        assert!((0.0..=1.0).contains(&f), "F = {f}");
        let exact = reference::dielectric_f(cos.into(), eta);
        // Backward: as if the cosine and the index (1/ior is rounded) were off by 4 ulp; the rest is relative to F.
        let nearby = [(4.0, 0.0), (-4.0, 0.0), (0.0, 4.0), (0.0, -4.0)].map(|(dc, de)| {
            reference::dielectric_f((f64::from(cos) * (1.0 + dc * ULP)).min(1.0), eta * (1.0 + de * ULP))
        });
        let allowed = 16.0 * ULP * exact + nearby.iter().map(|f| (f - exact).abs()).sum::<f64>();
        assert!(
            (f - exact).abs() <= allowed,
            "ior {ior}, cos {cos}, outside {outside}: {f:e} for {exact:e} ± {allowed:e}"
        );
    }
}

#[test]
fn diffuse_reflectance_is_the_closed_form() {
    let Some(case) = oracle("F.Favg_ext1.5") else { return };
    let rule = quadrature::gauss_legendre(16);
    let average = quadrature::integrate(&rule, 0.0, 1.0, 64, |mu| 2.0 * mu * dielectric(mu as f32, 1.5, true));
    // Rounding of F and of its argument, 16 ulp of F ≤ 1 where F is steep, weighed by 2μ.
    assert!((average - case.value).abs() < 16.0 * ULP * case.value, "{average} for {}", case.value);
}

#[test]
fn conductors() {
    if let Some(case) = oracles_in("Fresnel conductor").first() {
        assert!((reference::conductor_f(0.1, 0.2, 3.9) - case.value).abs() < 1e-14);
        assert_near(&case.id, conductor(0.1f32, 0.2, 3.9).into(), 0.1, |c| reference::conductor_f(c, 0.2, 3.9));
    }
    let mut rng = stats::Rng::new(22);
    let mut worst = 0.0f64;
    for _ in 0..200_000 {
        let eta = 10f64.powf(rng.range(-2.0, 1.0)) as f32;
        let k = 10f64.powf(rng.range(-2.0, 1.0)) as f32;
        let cos = 10f64.powf(rng.range(-6.0, 0.0)) as f32;
        let exact = reference::conductor_f(cos.into(), eta.into(), k.into());
        worst = worst.max((f64::from(conductor(cos, eta, k)) - exact).abs() / exact.sqrt());
    }
    println!("conductor: worst |F − exact|/√F {} ulp", worst / ULP);
    // A relative error ε of a moves (a − c)²/(a + c)² by up to 2ε of its root; a, and then the two amplitudes, are the
    // end of a dozen roundings.
    assert!(worst < 32.0 * ULP);
}

#[test]
fn conductors_without_absorption_are_dielectrics() {
    for cos in [1.0f32, 0.8, 0.3, 0.01] {
        let (metal, glass) = (f64::from(conductor(cos, 1.5, 0.0)), dielectric(cos, 1.5, true));
        assert!((metal - glass).abs() <= 32.0 * ULP, "{metal} and {glass} at {cos}");
    }
    for (eta, k) in [(0.0, 3.0), (1.0, 0.0), (1e-6, 1e3), (1.5, 0.0)] {
        for cos in [0.0f32, 1e-6, 0.5, 1.0] {
            let f = conductor(cos, eta, k);
            assert!((0.0..=1.0 + f32::EPSILON).contains(&f), "F({cos}, {eta}, {k}) = {f}");
        }
    }
}

#[test]
fn schlick_runs_from_0_to_1() {
    assert_eq!(schlick_weight(1.0f32), 0.0);
    assert_eq!(schlick_weight(1.0f32 + f32::EPSILON), 0.0);
    assert_eq!(schlick_weight(0.0f32), 1.0);
    assert_eq!(schlick_weight(0.5f32), 0.03125);
}
