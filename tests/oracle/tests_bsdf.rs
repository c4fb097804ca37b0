//! The oracle's scattering functions against closed forms and against themselves.

use super::bsdf::{is_delta, sample};
use super::ggx::Ggx;
use super::vec3::V3;
use super::*;
use crate::stats::{self, Chi2Sphere, Moments, Rng, oracle, oracles_in};
use octolux::scene::{Bsdf, ConductorFresnel, Masking};

pub const WHITE: ConductorFresnel = ConductorFresnel::Constant { reflectance: [1.0; 3] };

fn metal(alpha: f32, masking: Masking) -> Bsdf {
    Bsdf::Conductor { alpha, masking, fresnel: WHITE }
}

fn phong(exponent: f32) -> Bsdf {
    Bsdf::Phong { diffuse: [0.5, 0.1, 0.3], specular: [0.5, 0.9, 0.2], exponent }
}

fn coat(alpha: f32) -> Bsdf {
    Bsdf::Coated { reflectance: [0.9, 0.5, 0.1], alpha, masking: Masking::Correlated, ior: 1.5 }
}

fn glass(alpha: f32, ior: f32) -> Bsdf {
    Bsdf::Dielectric { alpha, masking: Masking::Correlated, ior }
}

/// At cosθ = mu, off every axis.
fn at(mu: f64) -> [f64; 3] {
    let r = (1.0 - mu * mu).max(0.0).sqrt();
    [0.6 * r, -0.8 * r, mu]
}

#[test]
fn dielectric_fresnel_matches_the_oracles() {
    for (id, eta) in [
        ("F.diel1.5_45deg", 1.5),
        ("F.diel1.5_60deg", 1.5),
        ("F.diel1.5_75deg", 1.5),
        ("F.diel1.5_85deg", 1.5),
        ("F.diel1.5_89.9deg", 1.5),
        ("F.diel1.5_mu1e-3", 1.5),
        ("F.diel1.5_mu1e-6", 1.5),
        ("F.eta1+1e-6_mu0.1", 1.0 + 1e-6),
        ("F.eta1+1e-6_mu1e-3", 1.0 + 1e-6),
        ("F.eta1+2^-20(f32-exact)_mu1e-3", 1.0 + f64::powi(2.0, -20)),
    ] {
        let Some(case) = oracle(id) else { return };
        let cos = case
            .setup
            .split("cos_i=")
            .nth(1)
            .and_then(|s| s.split('.').take(2).collect::<Vec<_>>().join(".").split(' ').next().map(str::to_string));
        let cos: f64 = cos.and_then(|s| s.trim_end_matches('.').parse().ok()).expect("cos_i in the setup");
        let got = fresnel_dielectric(cos, eta);
        // 1 + 1e-6 is rounded to 1e-16 before its 1 is taken away again: 1e-10 of what remains, squared.
        let rounding = if eta < 1.1 { 4e-10 } else { 1e-14 };
        assert!((got / case.value - 1.0).abs() < rounding, "{id}: {got} for {}", case.value);
        // The same facet from behind, along the refracted ray.
        let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
        let back = fresnel_dielectric(cos_t, 1.0 / eta);
        assert!((got - back).abs() < 1e-8, "{id}: {got} in front, {back} behind");
    }
    assert_eq!(fresnel_dielectric(0.3, 1.0), 0.0);
    let critical = oracle("F.crit_cos_1.5").map_or(0.7453559924999299, |c| c.value);
    assert_eq!(fresnel_dielectric(critical - 1e-6, 1.0 / 1.5), 1.0);
    assert!(fresnel_dielectric(critical + 1e-6, 1.0 / 1.5) < 1.0);
}

#[test]
fn conductor_fresnel_matches_the_oracle_and_its_limits() {
    if let Some(case) = oracle("F.cond_0.2_3.9_mu0.1") {
        assert!((fresnel_conductor(0.1, 0.2, 3.9) - case.value).abs() < 1e-14);
    }
    for cos in [0.05, 0.3, 0.7, 1.0] {
        let (metal, glass) = (fresnel_conductor(cos, 1.5, 0.0), fresnel_dielectric(cos, 1.5));
        assert!((metal - glass).abs() < 1e-14, "no absorption: a dielectric, {metal} for {glass}");
    }
    // At normal incidence ((η − 1)² + k²)/((η + 1)² + k²).
    let normal = ((0.143f64 - 1.0).powi(2) + 3.98f64.powi(2)) / ((0.143f64 + 1.0).powi(2) + 3.98f64.powi(2));
    assert!((fresnel_conductor(1.0, 0.143, 3.98) - normal).abs() < 1e-14);
    assert_eq!((fresnel_schlick(1.0, 0.2), fresnel_schlick(0.0, 0.2)), (0.2, 1.0));
}

#[test]
fn normal_distribution_matches_the_oracles() {
    for case in oracles_in("GGX NDF").into_iter().chain(oracles_in("GGX NDF (cancellation)")) {
        let alpha: f64 = case.id.split("_a").nth(1).and_then(|a| a.parse().ok()).expect("an alpha in the id");
        let tan = if case.id.contains("half") { alpha } else { 0.0 };
        let z = 1.0 / (1.0 + tan * tan).sqrt();
        let d = Ggx { alpha, masking: Masking::Correlated }.d(V3::new(tan * z, 0.0, z));
        assert!((d / case.value - 1.0).abs() < 1e-14, "{}: {d} for {}", case.id, case.value);
    }
}

/// The whole table of single-scattering albedos. Alphas such as 0.1 are rounded to f32 in the scene: 6e-8 of them, times
/// |dE/d ln α| < .3, and the quadrature's own 1e-7.
#[test]
fn ggx_albedo_matches_the_oracles() {
    for (category, masking) in [
        ("GGX conductor F=1 (height-correlated Smith)", Masking::Correlated),
        ("GGX conductor F=1 (separable Smith G1*G1)", Masking::Separable),
    ] {
        for case in oracles_in(category) {
            let (alpha, mu) = case.id.split_once("_a").and_then(|(_, s)| s.split_once("_mu")).expect("…_a0.1_mu0.5");
            let (alpha, mu): (f32, f64) = (alpha.parse().expect("alpha"), mu.parse().expect("mu"));
            for mu in [mu, -mu] {
                let albedo = directional_albedo(&metal(alpha, masking), at(mu));
                let off = albedo.reflected[0] - case.value;
                assert!(off.abs() < 1.2e-7, "{}: {} for {}", case.id, albedo.reflected[0], case.value);
                assert_eq!(albedo.transmitted, [0.0; 3]);
            }
        }
    }
}

#[test]
fn sampling_and_quadrature_agree() {
    let exact = ConductorFresnel::Exact { eta: [0.143, 0.375, 1.442], k: [3.98, 2.39, 1.6] };
    let schlick = ConductorFresnel::Schlick { f0: [0.9, 0.5, 0.1] };
    let bsdfs = [
        Bsdf::Diffuse { reflectance: [0.9, 0.5, 0.0] },
        metal(1.0, Masking::Correlated),
        metal(0.3, Masking::Separable),
        Bsdf::Conductor { alpha: 0.1, masking: Masking::Correlated, fresnel: exact },
        Bsdf::Conductor { alpha: 0.5, masking: Masking::Correlated, fresnel: schlick },
        Bsdf::Conductor { alpha: 0.0, masking: Masking::Correlated, fresnel: exact },
        glass(0.0, 1.5),
        glass(0.2, 1.5),
        glass(0.8, 1.3),
        Bsdf::Dielectric { alpha: 0.5, masking: Masking::Separable, ior: 2.0 },
        phong(3.0),
        phong(60.0),
        coat(0.0),
        coat(0.3),
    ];
    let mus = [1.0, 0.7, 0.2, -0.9, -0.4];
    let tests = bsdfs.len() * mus.len() * 4;
    for (i, bsdf) in bsdfs.iter().enumerate() {
        for mu in mus {
            let albedo = directional_albedo(bsdf, at(mu));
            let mut rng = Rng::new(100 + i as u64);
            let mut moments = [[Moments::new(); 3]; 2];
            for _ in 0..20_000 {
                let sampled = sample(bsdf, V3(at(mu)), &mut rng);
                let through = sampled.is_some_and(|s| s.wi.z() * mu < 0.0);
                let scale = match *bsdf {
                    Bsdf::Dielectric { ior, .. } if through => f64::from(ior).powf(2.0 * mu.signum()),
                    _ => 1.0,
                };
                let weight = sampled.map_or(V3::default(), |s| s.weight * scale);
                for (part, counts) in moments.iter_mut().zip([!through, through]) {
                    part.iter_mut().zip(weight.0).for_each(|(m, w)| m.push(if counts { w } else { 0.0 }));
                }
            }
            for (m, want) in [(moments[0], albedo.reflected), (moments[1], albedo.transmitted)] {
                for c in [0, 2] {
                    stats::assert_mean(&format!("{bsdf:?}, mu {mu}, channel {c}"), &m[c], want[c], 1e-5, tests);
                }
            }
        }
    }
}

#[test]
fn lossless_smooth_glass_keeps_all_and_rough_glass_never_gains() {
    for mu in [1.0, 0.5, 0.05, -0.05, -0.5, -1.0] {
        let smooth = directional_albedo(&glass(0.0, 1.5), at(mu));
        assert!((smooth.reflected[0] + smooth.transmitted[0] - 1.0).abs() < 1e-15);
        for alpha in [0.05, 0.3, 1.0] {
            let rough = directional_albedo(&glass(alpha, 1.5), at(mu));
            let total = rough.reflected[0] + rough.transmitted[0];
            assert!(total < 1.0 + 1e-5 && total > 0.3, "alpha {alpha}, mu {mu}: {rough:?}");
        }
        // A narrow lobe tends to the smooth split (its second moment, α² ln(1/α²)-ish, times F'' of order one).
        if mu.abs() > 0.3 && mu != -0.5 {
            let narrow = directional_albedo(&glass(1e-3, 1.5), at(mu));
            assert!((narrow.reflected[0] - smooth.reflected[0]).abs() < 1e-4, "mu {mu}: {narrow:?} for {smooth:?}");
        }
    }
}

/// f(wo, wi)/η_o² is symmetric: Veach 1997, § 5.2.
#[test]
fn scattering_is_reciprocal() {
    let mut rng = Rng::new(5);
    let mut lit = 0;
    let layered = [phong(2.0), phong(30.0), coat(0.0), coat(0.5)];
    let single = [metal(0.4, Masking::Correlated), metal(0.9, Masking::Separable), glass(0.5, 1.5), glass(0.9, 1.2)];
    for bsdf in single.into_iter().chain(layered) {
        for _ in 0..2_000 {
            let (wo, wi) = (rng.sphere(), rng.sphere());
            let f = |o: [f64; 3], i: [f64; 3]| {
                let index = |w: [f64; 3]| match bsdf {
                    Bsdf::Dielectric { ior, .. } if w[2] < 0.0 => f64::from(ior),
                    _ => 1.0,
                };
                bsdf_eval(&bsdf, o, i)[0] / i[2].abs() / index(o).powi(2)
            };
            let (there, back) = (f(wo, wi), f(wi, wo));
            assert!((there - back).abs() <= 1e-9 * there.max(1e-12), "{bsdf:?} {wo:?} {wi:?}: {there} {back}");
            lit += u32::from(there > 0.0);
        }
    }
    assert!(lit > 3_000, "only {lit} pairs scattered at all");
}

/// The half-vector sampler against its own density, seen as directions on the sphere: chi-square, and a demonstration.
#[test]
fn half_vectors_follow_their_density() {
    for (i, alpha) in [0.05, 0.4, 1.0].into_iter().enumerate() {
        let ggx = Ggx { alpha, masking: Masking::Correlated };
        Chi2Sphere::new(format!("GGX normals, alpha {alpha}"))
            .seed(i as u64)
            .tests(3)
            .around([0.0, 0.0, 1.0], 4.0)
            .run(|rng| Some(ggx.normal([rng.f64(), rng.f64()]).0), |m| ggx.d(V3(m)) * m[2].max(0.0));
    }
}

#[test]
fn weak_white_furnace_holds() {
    // ∫ D G1(o) (o·m)/cosθo dm = 1 over facets that face wo (Heitz 2014, eq. 22), by quadrature over the sphere.
    let Some(case) = oracle("E.weak_furnace") else { return };
    for (alpha, mu) in [(0.3, 0.2), (1.0, 0.7), (0.5, 1.0)] {
        let (ggx, wo) = (Ggx { alpha, masking: Masking::Separable }, V3(at(mu)));
        let visible = |u: f64, phi: f64| {
            let m = ggx.normal([u, phi]);
            // Against a direction along z, whose own masking is 1, G2 is G1(wo).
            if m.z() <= 0.0 { 0.0 } else { ggx.g2(wo, V3::Z, m) * wo.dot(m) / (m.z() * mu) }
        };
        let squeezed = |s: f64, phi: f64| visible(1.0 - (1.0 - s).powi(2), phi) * 2.0 * (1.0 - s);
        let whole = stats::quadrature::Rect { x: [0.0, 1.0], y: [0.0, 1.0] };
        let (sum, _) = stats::quadrature::Adaptive::new(1e-7, squeezed).integrate(whole, 3);
        assert!((sum - case.value).abs() < 1e-5, "alpha {alpha}, mu {mu}: {sum}");
    }
    assert!(is_delta(&glass(0.0, 1.5)) && !is_delta(&glass(0.1, 1.5)));
}
