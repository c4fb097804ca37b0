//! Warps against their densities, their known variances, and at the ends of their domains.

use super::draw::one_by_one;
use crate::lane::widths::{LaneFunction, assert_same_bits};
use crate::stats::{Chi2Sphere, Moments, assert_mean, assert_variance, chi2_test, oracle, sidak_alpha};
use octolux::lane::{Real, Vec3, f32x8};
use octolux::sampling::{ONE_BELOW, Xoshiro, warp};
use std::f64::consts::PI;

fn pair(rng: &mut Xoshiro<f32x8>) -> [f32x8; 2] {
    [rng.next_unit(), rng.next_unit()]
}

fn directions(seed: u64, warp: impl Fn([f32x8; 2]) -> Vec3<f32x8>) -> impl FnMut() -> [f64; 3] {
    one_by_one(seed, move |rng| {
        let w = warp(pair(rng));
        std::array::from_fn(|i| w.lane(i).map(f64::from))
    })
}

/// How many χ² tests are in this file.
const CHI2_TESTS: usize = 6;

fn chi2(name: &str, warp: impl Fn([f32x8; 2]) -> Vec3<f32x8>, pdf: impl Fn([f64; 3]) -> f64) {
    let mut next = directions(11, warp);
    Chi2Sphere::new(name).samples(1_000_000).tests(CHI2_TESTS).run(|_| Some(next()), pdf);
}

#[test]
fn directions_follow_their_densities() {
    chi2("cosine hemisphere", warp::cosine_hemisphere, |w| warp::cosine_hemisphere_pdf(w[2] as f32).into());
    chi2("uniform hemisphere", warp::uniform_hemisphere, |w| warp::uniform_hemisphere_pdf(w[2] as f32).into());
    chi2("uniform sphere", warp::uniform_sphere, |_| warp::uniform_sphere_pdf::<f32>().into());
}

#[test]
fn cones_follow_their_density() {
    // Both borders are borders of cells: 1 − cosθ = 2·(4/16) and 2·(1/32)⁴.
    for (name, height, rows, power) in [("wide", 0.5, 16, 1.0), ("narrow", 2.0 / 32f32.powi(4), 32, 4.0)] {
        let mut next = directions(12, |u| warp::uniform_cone(u, f32x8::splat(height)));
        let pdf = f64::from(warp::uniform_cone_pdf(height));
        // An ulp of cosθ beyond the border is rounding, and the sampler's border cell is 2⁻²⁴ of a whole.
        let inside = |z: f64| 1.0 - z <= f64::from(height) * (1.0 + 1e-6);
        let run = Chi2Sphere::new(format!("{name} cone")).samples(1_000_000).tests(CHI2_TESTS);
        if name == "wide" {
            run.cells(rows, 32)
                .around([0.0, 0.0, 1.0], power)
                .run(|_| Some(next()), |w| if inside(w[2]) { pdf } else { 0.0 });
        } else {
            // 1 − cosθ has only 2⁻²⁴ steps in f32: judge sin²θ, which the cone spreads evenly over [0, sin²θ_max].
            let sin2_max = f64::from(height * (2.0 - height));
            let mut counts = [0u64; 256];
            for _ in 0..1_000_000 {
                let w = next();
                let radial = ((w[0] * w[0] + w[1] * w[1]) / sin2_max * 16.0).min(15.9) as usize;
                let angle = (w[1].atan2(w[0]) / (2.0 * PI) + 0.5) * 16.0;
                counts[radial * 16 + (angle as usize).min(15)] += 1;
            }
            let outcome = chi2_test(&counts, &[1e6 / 256.0; 256]);
            assert!(outcome.p_value > sidak_alpha(CHI2_TESTS), "{outcome:?}");
        }
    }
}

#[test]
fn triangle_points_are_uniform() {
    // The triangle in n² congruent ones.
    const N: usize = 16;
    let mut counts = [0u64; N * N];
    let mut next = one_by_one(13, |rng| {
        let [b1, b2] = warp::uniform_triangle(pair(rng));
        std::array::from_fn(|i| [b1.lane(i), b2.lane(i)])
    });
    for _ in 0..1_000_000 {
        let [b1, b2] = next().map(f64::from);
        assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0, "{b1}, {b2}");
        let (x, y) = (b1 * N as f64, b2 * N as f64);
        let (i, j) = (x as usize, y as usize);
        let upper = (x.fract() + y.fract() > 1.0) as usize;
        // Row i holds 2(N − i) − 1 small triangles: (j, lower) and (j, upper) alternate.
        let row_start = i * (2 * N - i);
        counts[(row_start + 2 * j + upper).min(N * N - 1)] += 1;
    }
    let outcome = chi2_test(&counts, &[1e6 / (N * N) as f64; N * N]);
    assert!(outcome.p_value > sidak_alpha(CHI2_TESTS), "{outcome:?}");
    assert_eq!(warp::uniform_triangle_pdf_area(0.25f32), 4.0);
}

/// Mean and variance of an estimate of ∫ f over 2²⁰ directions of a warp.
fn moments(warp: impl Fn([f32x8; 2]) -> Vec3<f32x8>, estimate: impl Fn([f64; 3]) -> f64) -> Moments {
    let mut next = directions(14, warp);
    (0..1 << 20).map(|_| estimate(next())).collect()
}

fn assert_oracle(id: &str, moments: &Moments, mean: f64) {
    let Some(case) = oracle(id) else { return };
    assert_mean(id, moments, mean, 4e-7 * mean, 16);
    // Rounding of an f32 cosine, as a variance: far below the standard error.
    assert_variance(id, moments, case.value, 1e-13 * mean * mean, 16);
}

#[test]
fn variances_are_the_known_ones() {
    // Constant environment on Lambert, ρ = 1: the integrand is cosθ/π.
    let cosine = moments(warp::cosine_hemisphere, |w| w[2] / PI / f64::from(warp::cosine_hemisphere_pdf(w[2] as f32)));
    assert_oracle("H.cos_var", &cosine, 1.0);
    let hemisphere = moments(warp::uniform_hemisphere, |w| 2.0 * w[2]);
    assert_oracle("H.unif_hemi_var", &hemisphere, 1.0);
    let sphere = moments(warp::uniform_sphere, |w| 4.0 * w[2].max(0.0));
    assert_mean("sphere", &sphere, 1.0, 0.0, 16);
    assert_variance("sphere", &sphere, 5.0 / 3.0, 0.0, 16);
    for (id, k) in [("H.env_cos^1", 1), ("H.env_cos^4", 4)] {
        assert_oracle(id, &moments(warp::cosine_hemisphere, |w| w[2].powi(k)), 2.0 / f64::from(k + 2));
    }
    for (id, sine) in [("H.sphere_cone_r/d0.5", 0.5f32), ("H.sphere_cone_r/d0.01", 0.01)] {
        let height = warp::one_minus_cos(sine * sine);
        let pdf = f64::from(warp::uniform_cone_pdf(height));
        let cone = moments(|u| warp::uniform_cone(u, f32x8::splat(height)), |w| w[2] / PI / pdf);
        // The whole estimate carries the relative error of an f32 pdf and of 0.01 itself.
        assert_oracle(id, &cone, f64::from(sine * sine));
    }
}

#[test]
fn one_sample_mis_has_its_known_variance() {
    let mut next = one_by_one(15, |rng| {
        let (choice, u): (f32x8, _) = (rng.next_unit(), pair(rng));
        let cosine = choice.lt(f32x8::splat(0.5));
        let w = Vec3::select(cosine, warp::cosine_hemisphere(u), warp::uniform_hemisphere(u));
        let pdf = (warp::cosine_hemisphere_pdf(w.z) + warp::uniform_hemisphere_pdf(w.z)) * f32x8::splat(0.5);
        std::array::from_fn(|i| f64::from(w.z.lane(i)) / PI / f64::from(pdf.lane(i)))
    });
    let estimates: Moments = (0..1 << 20).map(|_| next()).collect();
    assert_oracle("H.mis_1sample_balance", &estimates, 1.0);
}

#[test]
fn the_ends_of_the_unit_square_are_unit_vectors() {
    let ends = [0.0, 1e-45, 2f32.powi(-24), 0.5, ONE_BELOW];
    for u in ends.iter().flat_map(|&a| ends.map(|b| [a, b])) {
        let height = 1e-9f32;
        for w in [
            warp::cosine_hemisphere(u),
            warp::uniform_hemisphere(u),
            warp::uniform_sphere(u),
            warp::uniform_cone(u, 2.0),
            warp::uniform_cone(u, height),
        ] {
            let length = w.lane(0).map(f64::from).iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!((length - 1.0).abs() < 4.0 * 2f64.powi(-24), "{u:?} → {w:?}, length {length}");
        }
        assert!(warp::cosine_hemisphere(u).z >= 2f32.powi(-12));
    }
}

#[test]
fn narrow_cones_keep_their_digits() {
    for k in 1..60 {
        let sine = 2f64.powf(-0.5 * f64::from(k)) as f32;
        let sin2 = sine * sine;
        let exact = f64::from(sin2) / (1.0 + (1.0 - f64::from(sin2)).sqrt());
        let relative = (f64::from(warp::one_minus_cos(sin2)) / exact - 1.0).abs();
        // Three roundings: the root's argument and the root weigh less than one each.
        assert!(relative < 3.0 * 2f64.powi(-24), "sin = {sine}: {relative:e}");
    }
}

#[test]
fn the_same_bits_at_every_width() {
    struct Warps;
    impl LaneFunction for Warps {
        fn call<R: Real>(&self, input: &[R]) -> Vec<R> {
            let u = [input[0], input[1]];
            let height = warp::one_minus_cos(input[2]);
            let directions = [
                warp::cosine_hemisphere(u),
                warp::uniform_hemisphere(u),
                warp::uniform_sphere(u),
                warp::uniform_cone(u, height),
            ];
            let mut out: Vec<R> = directions.iter().flat_map(|w| [w.x, w.y, w.z]).collect();
            out.extend(warp::uniform_triangle(u));
            out.extend([warp::uniform_cone_pdf(height), warp::cosine_hemisphere_pdf(out[2])]);
            out.extend([warp::uniform_hemisphere_pdf(out[0]), warp::uniform_triangle_pdf_area(input[2])]);
            out
        }
    }
    let mut rng = Xoshiro::<f32>::from_keys(|_| 16);
    let rows: Vec<Vec<f32>> = (0..100_000).map(|_| (0..3).map(|_| rng.next_unit()).collect()).collect();
    assert_same_bits(&Warps, &rows);
}
