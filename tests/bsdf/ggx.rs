//! GGX against its closed forms: the density's peak, albedo, variance and losses of visible-normal sampling.

use super::{at, direction, reference, white_metal};
use crate::oracle::directional_albedo;
use crate::sampling::draw::one_by_one;
use crate::stats::{
    self, Moments, OracleCase, assert_mean, assert_variance, oracles_in, sidak_alpha, special::poisson_tail,
};
use octolux::bsdf::ggx::Ggx;
use octolux::bsdf::{ALPHA_MIN, Model};
use octolux::check::numerics::ulp::spacing;
use octolux::lane::{Real, Vec3, f32x8};
use octolux::sampling::warp;
use octolux::scene::{Bsdf, Masking};

const ULP: f64 = 1.0 / (1u32 << 24) as f64;
const SAMPLES: u64 = 1 << 20;
/// The oracle cases of this file that are statistics, rounded up.
const TESTS: usize = 128;

fn parameter(case: &OracleCase, name: &str) -> f64 {
    let field = case.setup.split([' ', ',']).find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
    field.unwrap_or_else(|| panic!("{}: no {name} in {}", case.id, case.setup)).trim_end_matches(':').parse().unwrap()
}

fn density(h: [f32; 3], alpha: f32) -> f64 {
    let h = Vec3::<f32>::splat(h);
    Ggx { alpha, separable: false }.density(h, h.length_squared()).into()
}

#[test]
fn the_density_has_its_peak_and_half_width() {
    for case in oracles_in("GGX NDF") {
        let alpha = parameter(&case, "alpha");
        // alpha rounds to f32 (2 halves of an ulp in its square); six more roundings.
        let relative = density([0.0, 0.0, 1.0], alpha as f32) / case.value - 1.0;
        assert!(relative.abs() < 8.0 * ULP, "{}: {relative:e}", case.id);
    }
    for case in oracles_in("GGX NDF (cancellation)") {
        let alpha: f64 = case.id.rsplit("_a").next().unwrap().parse().unwrap();
        let relative = density([alpha as f32, 0.0, 1.0], alpha as f32) / case.value - 1.0;
        assert!(relative.abs() < 8.0 * ULP, "{}: {relative:e}", case.id);
    }
}

#[test]
fn the_density_is_the_formula_for_any_length_of_normal() {
    let mut rng = stats::Rng::new(31);
    for _ in 0..100_000 {
        let alpha = 10f64.powf(rng.range(-4.0, 0.0)) as f32;
        let tan = f64::from(alpha) * 10f64.powf(rng.range(-2.0, 3.0));
        let (sin_phi, cos_phi) = rng.range(0.0, 7.0).sin_cos();
        let scale = 2f64.powf(rng.range(-20.0, 20.0));
        let h = [tan * cos_phi * scale, tan * sin_phi * scale, scale].map(|x| x as f32);
        let h64 = h.map(f64::from);
        let length = super::dot(h64, h64).sqrt();
        let exact = reference::ggx_d(h64.map(|x| x / length), alpha.into());
        let relative = density(h, alpha) / exact - 1.0;
        assert!(relative.abs() < 16.0 * ULP, "alpha {alpha}, tan {tan}: {relative:e}, spacing {:e}", spacing(exact));
    }
}

/// (weight of a sample, 0 below the horizon; is it above?) at cosine `mu`.
fn samples(alpha: f64, mu: f64, separable: bool, seed: u64) -> impl FnMut() -> (f64, bool) {
    let metal = white_metal::<f32x8>(alpha as f32, separable);
    let wo = at(mu, 0.3);
    one_by_one(seed, move |rng| {
        let s = metal.sample(wo, rng.next_unit(), [rng.next_unit(), rng.next_unit()]);
        std::array::from_fn(|i| (s.weight.x.lane(i).into(), direction(&s, i).is_some()))
    })
}

/// What a mean over [`SAMPLES`] may miss when a loss has probability `p` so small that its count is not normal: the
/// excess of the Poisson count that has less than the Šidák level of probability.
fn rare(p: f64) -> f64 {
    let mean = p * SAMPLES as f64;
    if mean > 100.0 {
        return 0.0;
    }
    let mut count = mean.ceil() as u64;
    while poisson_tail(mean, count) > 0.5 * sidak_alpha(TESTS) {
        count += 1;
    }
    count as f64 / SAMPLES as f64
}

#[test]
fn albedo() {
    for (category, separable) in
        [("GGX conductor F=1 (height-correlated Smith)", false), ("GGX conductor F=1 (separable Smith G1*G1)", true)]
    {
        for (seed, case) in oracles_in(category).iter().enumerate() {
            let mut next = samples(parameter(case, "alpha"), parameter(case, "mu"), separable, seed as u64);
            let weights: Moments = (0..SAMPLES).map(|_| next().0).collect();
            assert_mean(&case.id, &weights, case.value, 8.0 * ULP + rare(1.0 - case.value), TESTS);
        }
    }
}

#[test]
fn average_albedo() {
    for case in oracles_in("GGX conductor F=1").iter().filter(|case| case.id.contains("Eavg")) {
        let metal = white_metal::<f32x8>(parameter(case, "alpha") as f32, false);
        let mut next = one_by_one(33, |rng| {
            let wo = warp::cosine_hemisphere([rng.next_unit(), rng.next_unit()]);
            let s = metal.sample(wo, rng.next_unit(), [rng.next_unit(), rng.next_unit()]);
            std::array::from_fn(|i| f64::from(s.weight.x.lane(i)))
        });
        let weights: Moments = (0..SAMPLES).map(|_| next()).collect();
        assert_mean(&case.id, &weights, case.value, 8.0 * ULP, TESTS);
    }
}

#[test]
fn variance_of_the_sampled_albedo() {
    for (seed, case) in oracles_in("variance oracle (GGX VNDF)").iter().enumerate() {
        let mut next = samples(parameter(case, "alpha"), parameter(case, "mu"), false, 100 + seed as u64);
        let weights: Moments = (0..SAMPLES).map(|_| next().0).collect();
        assert_variance(&case.id, &weights, case.value, rare(case.value), TESTS);
    }
}

#[test]
fn probability_of_reflecting_below_the_horizon() {
    for (seed, case) in oracles_in("GGX VNDF").iter().enumerate() {
        let mut next = samples(parameter(case, "alpha"), parameter(case, "mu"), false, 200 + seed as u64);
        let lost: Moments = (0..SAMPLES)
            .map(|_| {
                let (weight, above) = next();
                assert!(above || weight == 0.0);
                f64::from(u8::from(!above))
            })
            .collect();
        assert_mean(&case.id, &lost, case.value, rare(case.value), TESTS);
    }
}

/// The furnace at each decade of α, at incidences down to one millionth, as an f64 quadrature has it: whatever is not reflected
/// went below the horizon. The least α that has a lobe, too, and below it a mirror, which loses nothing.
#[test]
fn the_furnace_at_every_decade() {
    let alphas = [1.0f32, 0.1, 1e-2, 1e-3, ALPHA_MIN, ALPHA_MIN.next_down()];
    let cosines = [1.0, 0.5, 0.1, 1e-2, 1e-4, 1e-6];
    for (i, alpha) in alphas.into_iter().enumerate() {
        for (j, mu) in cosines.into_iter().enumerate() {
            for (k, masking) in [Masking::Correlated, Masking::Separable].into_iter().enumerate() {
                let fresnel = octolux::scene::ConductorFresnel::Constant { reflectance: [1.0; 3] };
                let exact = match alpha < ALPHA_MIN {
                    true => 1.0,
                    false => {
                        directional_albedo(
                            &Bsdf::Conductor { alpha, masking, fresnel },
                            at::<f32>(mu, 0.3).lane(0).map(f64::from),
                        )
                        .reflected[0]
                    }
                };
                let mut next = samples(alpha.into(), mu, masking == Masking::Separable, (100 * i + 10 * j + k) as u64);
                let values: Moments = (0..SAMPLES / 8).map(|_| next().0).collect();
                // Grazing samples are above the horizon or below by the last bits of their slope: as the mirror's 4 ulp of μ.
                let horizon = 4.0 * ULP / mu.max(f64::from(alpha));
                // A loss that so few samples hardly meet: weights are in [0, 1], so their variance is at most 1 − E.
                let (loss, n) = (1.0 - exact, (SAMPLES / 8) as f64);
                let rare = if loss * n < 100.0 { 4.0 * (loss.max(0.0) / n).sqrt() } else { 0.0 };
                let rounding = 16.0 * ULP + horizon + rare + 2e-7;
                assert_mean(&format!("α {alpha}, μ {mu}, {masking:?}"), &values, exact, rounding, TESTS);
            }
        }
    }
}
