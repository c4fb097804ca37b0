//! Environments: samples against their density, totals, constants, memory and build time.

use super::TESTS;
use super::image::reference_lookup;
use super::scenes::*;
use crate::stats::quadrature::gauss_legendre;
use crate::stats::{Chi2Sphere, Moments, Rng, assert_mean, assert_variance, oracle};
use octolux::light::Lights;
use octolux::scene::{Environment, EnvironmentImage};
use std::f64::consts::{PI, TAU};

const ULP: f64 = 5.960_464_477_539_063e-8; // 2⁻²⁴

pub fn images() -> Vec<(&'static str, EnvironmentImage)> {
    let sun = image(64, 32, |r, c| if (r, c) == (9, 50) { [3e4, 2.5e4, 2e4] } else { [0.2, 0.3, 0.6] });
    let ground = image(16, 8, |r, _| if r < 4 { [1.0; 3] } else { [0.0; 3] });
    let stripes = image(8, 6, |_, c| [if c % 2 == 0 { 1.0 } else { 0.0 }; 3]);
    let polar = image(6, 5, |r, _| [if r == 0 { 10.0 } else { 0.01 }; 3]);
    let south = image(6, 5, |r, c| [if r == 4 && c == 5 { 10.0 } else { 0.01 }; 3]);
    vec![
        ("noise 8×4", noise(8, 4, 0.0, 1.0, 1)),
        ("noise 5×3", noise(5, 3, 0.1, 9.0, 2)),
        ("one texel", noise(1, 1, 1.0, 2.0, 3)),
        ("2×1", noise(2, 1, 0.0, 2.0, 4)),
        ("1×7", noise(1, 7, 0.0, 2.0, 5)),
        ("sun", sun),
        ("half dark", ground),
        ("stripes", stripes),
        ("bright pole", polar),
        ("bright south", south),
    ]
}

#[test]
fn images_follow_their_density() {
    assert_follow_their_density(image_lights);
}

/// Of all [`images`], as lights, whose sun is looked at closely.
pub fn assert_follow_their_density(lights_of: impl Fn(&EnvironmentImage) -> Lights) {
    for (name, image) in images() {
        let lights = lights_of(&image);
        let axis = if name == "sun" { direction_of(&image, 9, 50) } else { [0.0, 1.0, 0.0] };
        let power = if name == "sun" { 4.0 } else { 1.0 };
        let outcome = Chi2Sphere::new(name).tests(TESTS).around(axis, power).outcome(
            |rng| Some(f64s(draw(&lights, [0.0; 3], rng).wi.lane(0))),
            |d| stated_pdf(&lights, &[], [0.0; 3], d),
        );
        assert!(outcome.failure.is_none(), "{}", outcome.failure.unwrap());
    }
}

/// Towards the centre of a texel.
pub fn direction_of(image: &EnvironmentImage, row: usize, column: usize) -> V {
    let theta = PI * (row as f64 + 0.5) / image.height as f64;
    let phi = TAU * (column as f64 + 0.5) / image.width as f64;
    [theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()]
}

/// Everything arriving, ∫L dω, against cell-by-cell Gauss quadrature of an f64 look-up; and ∫pdf dω = 1 by the same rule.
/// The pdf's rounding (a place to (w + h)·2⁻²³ of a cell) averages out over the nodes, so the bound on it is generous.
#[test]
fn totals() {
    for (name, image) in images() {
        let rule = gauss_legendre(8);
        let lights = image_lights(&image);
        let (mut total, mut mass) = (0.0, 0.0);
        for j in 0..=image.height {
            let edge = |j: f64| j.clamp(0.0, image.height as f64) / image.height as f64;
            let (v0, v1) = (edge(j as f64 - 0.5), edge(j as f64 + 0.5));
            for c in 0..image.width {
                for &(y, wy) in &rule {
                    let v = v0 + (v1 - v0) * 0.5 * (1.0 + y);
                    for &(x, wx) in &rule {
                        let u = (c as f64 + 1.0 + 0.5 * x) / image.width as f64;
                        let (s, cos) = (PI * v).sin_cos();
                        let d = [s * (TAU * u).sin(), cos, -s * (TAU * u).cos()];
                        let area = (v1 - v0) / image.width as f64 * 2.0 * PI * PI * s;
                        let weight = 0.25 * wx * wy * area;
                        total += weight * reference_lookup(&image, d)[0];
                        mass += weight * f64::from(lights.environment(vec1(f32s(d))).1);
                    }
                }
            }
        }
        let rounding = 2.0 * ULP * (image.width + image.height + 8) as f64;
        assert!((mass - 1.0).abs() <= rounding, "{name}: ∫pdf = {mass}");
        let mut rng = Rng::new(7);
        let one = |_| {
            let s = draw(&lights, [0.0; 3], &mut rng);
            f64::from(s.radiance.x) / f64::from(s.pdf)
        };
        let moments: Moments = (0..200_000).map(one).collect();
        assert_mean(name, &moments, total, total * 64.0 * ULP, TESTS);
    }
}

/// The density stated for the sampled direction is the sample's. Its conditioning: an angle is good to 2 ulp of at most
/// π, so a place to about (width + height)·2⁻²³ of a cell, across which neighbours here differ by less than 4 : 1
/// (relative slope ≤ 3); next to a pole the position is relatively accurate. On top, half a step of the table's grid
/// relative to the least cell's share of the mean (1/4 again), and a dozen roundings.
#[test]
fn sample_and_pdf_agree() {
    for (width, height) in [(8, 4), (5, 3), (64, 32), (1024, 512), (4096, 1024), (16_384, 256)] {
        let image = noise(width, height, 0.5, 2.0, 8);
        let lights = image_lights(&image);
        let mut rng = Rng::new(9);
        let mut worst = 0.0f64;
        let bound = ULP * (6.0 * (width + height) as f64 + 4.0 + 16.0);
        for k in 0..40_000 {
            let u =
                if k % 4 == 0 { [rng.f32(), rng.f32() * f32::powi(2.0, -(k % 64))] } else { [rng.f32(), rng.f32()] };
            let s = lights.sample::<f32>(vec1([0.0; 3]), rng.f32(), u, true);
            let (radiance, pdf) = lights.environment(s.wi);
            worst = worst.max((f64::from(pdf) / f64::from(s.pdf) - 1.0).abs());
            let brightness = (f64::from(radiance.x) / f64::from(s.radiance.x) - 1.0).abs();
            assert!(brightness <= bound, "{width}×{height}: radiance {brightness:e} off, bound {bound:e}");
        }
        assert!(worst <= bound, "{width}×{height}: pdf {worst:e} off, bound {bound:e}");
    }
}

/// One bright texel of a large image: the samples see its solid angle. The oracle's texel is constant over its
/// rectangle, ours a bilinear hat: smaller by the factor sin(Δ/2)/(Δ/2) inside, larger by 13/12 + O(Δ²) at the pole.
#[test]
fn one_bright_texel() {
    let (width, height) = (4096, 2048);
    let delta = PI / height as f64;
    let cases = [
        ("J.texel_omega_pole", 0, 13.0 / 12.0, 0.0),
        ("J.texel_omega_45deg", 512, (0.5 * delta).sin() / (0.5 * delta), 0.0),
        ("J.texel_omega_horizon", 1023, (0.5 * delta).sin() / (0.5 * delta), 0.0),
        ("J.texel_E_pole", 0, 13.0 / 12.0, 1.0),
    ];
    for (id, row, factor, cosine) in cases {
        let Some(case) = oracle(id) else { return };
        let lights = image_lights(&image(width, height, |r, c| [if (r, c) == (row, 4095) { 1.0 } else { 0.0 }; 3]));
        let mut rng = Rng::new(10);
        let one = |_| {
            let s = draw(&lights, [0.0; 3], &mut rng);
            let cos = if cosine > 0.0 { f64::from(s.wi.y) } else { 1.0 };
            f64::from(s.radiance.x) * cos / f64::from(s.pdf)
        };
        let moments: Moments = (0..50_000).map(one).collect();
        let tolerance = if row == 0 { delta * delta } else { 0.0 };
        assert_mean(id, &moments, case.value * factor, case.value * (32.0 * ULP + tolerance), TESTS);
    }
}

/// 16,384 columns: the density's integral (bilinear over a cell in u and v, so its value in the middle of each is exact), and
/// light from one texel at either side of the seam and at the pole, none of which a sample misses.
#[test]
fn sixteen_thousand_columns() {
    let (width, height) = (16_384, 256);
    let lights = image_lights(&noise(width, height, 0.0, 1.0, 16));
    let mut mass = 0.0;
    for j in 0..=height {
        let edge = |j: f64| j.clamp(0.0, height as f64) / height as f64;
        let (v0, v1) = (edge(j as f64 - 0.5), edge(j as f64 + 0.5));
        let (sin, cos) = (0.5 * PI * (v0 + v1)).sin_cos();
        for c in 0..width {
            let (sin_phi, cos_phi) = (TAU * (c as f64 + 1.0) / width as f64).sin_cos();
            let d = vec1(f32s([sin * sin_phi, cos, -sin * cos_phi]));
            mass += f64::from(lights.environment(d).1) * 2.0 * PI * PI * sin * (v1 - v0) / width as f64;
        }
    }
    assert!((mass - 1.0).abs() <= 2.0 * ULP * (width + height + 8) as f64, "∫pdf = {mass}");
    let (step, turn) = (PI / height as f64, TAU / width as f64);
    for (row, column) in [(128, 0), (128, 16_383), (1, 16_383), (0, 5), (255, 8192)] {
        let lit = image(width, height, |r, c| [if (r, c) == (row, column) { 1e6 } else { 0.0 }; 3]);
        let lights = image_lights(&lit);
        // The hat of a texel: turn wide, and high ∫(1 − |t|/Δ) sin(θ + t) dt; constant between a row of centres and its pole.
        let theta = step * (row as f64 + 0.5);
        let polar = row == 0 || row == height - 1;
        let hat = 2.0 * (1.0 - step.cos()) / step * theta.sin();
        let far = (0.5 * step).cos() - ((1.5 * step).sin() - (0.5 * step).sin()) / step;
        let exact = 1e6 * turn * if polar { 1.0 - (0.5 * step).cos() + far } else { hat };
        let mut rng = Rng::new(17);
        let one = |_| {
            let s = draw(&lights, [0.0; 3], &mut rng);
            assert!(s.pdf > 0.0 && s.radiance.x > 0.0, "{s:?}");
            f64::from(s.radiance.x) / f64::from(s.pdf)
        };
        let moments: Moments = (0..20_000).map(one).collect();
        assert_mean(&format!("texel {row}, {column}"), &moments, exact, exact * 2.0 * ULP * width as f64, TESTS);
    }
}

/// Uniform over the sphere: the mean of 4π·cos⁺ is π, and per sample (ρ = 1, E/π) the variance 5/3.
#[test]
fn constant_environment() {
    let lights = Lights::build(Vec::new(), Some(&Environment::Constant([1.0, 2.0, 0.5]))).unwrap();
    assert_eq!(lights.memory(), 0);
    Chi2Sphere::new("constant")
        .tests(TESTS)
        .run(|rng| Some(f64s(draw(&lights, [0.0; 3], rng).wi.lane(0))), |d| stated_pdf(&lights, &[], [0.0; 3], d));
    let n = unit([0.3, -0.5, 0.8]);
    let mut rng = Rng::new(11);
    let one = |_| {
        let s = draw(&lights, [0.0; 3], &mut rng);
        dot(f64s(s.wi.lane(0)), n).max(0.0) * f64::from(s.radiance.x) / f64::from(s.pdf) / PI
    };
    let moments: Moments = (0..1_000_000).map(one).collect();
    assert_mean("constant", &moments, 1.0, 16.0 * ULP, TESTS);
    assert_variance("constant", &moments, 5.0 / 3.0, 32.0 * ULP, TESTS);
}

/// A white image is a white furnace: radiance exactly 1 in every direction.
#[test]
fn white_image_is_white() {
    let lights = image_lights(&image(10, 5, |_, _| [1.0; 3]));
    let mut rng = Rng::new(12);
    for _ in 0..10_000 {
        assert_eq!(lights.environment_radiance(vec1(f32s(rng.sphere()))).lane(0), [1.0; 3]);
        assert_eq!(draw(&lights, [0.0; 3], &mut rng).radiance.lane(0), [1.0; 3]);
    }
}

/// At most 20 bytes a texel beside the image itself.
#[test]
fn memory() {
    let (width, height) = (1024, 512);
    let bytes = image_lights(&noise(width, height, 0.0, 1.0, 13)).memory();
    let image = width * height * size_of::<[f32; 3]>();
    assert!(bytes - image <= 20 * width * height + 20 * width, "{bytes}");
}

/// Turning by whole texels is moving the texels: the same radiance and density, up to how well a turned direction is known.
#[test]
fn turning_moves_the_texels() {
    let mut rng = Rng::new(14);
    for (width, height, steps) in [(8, 4, 1usize), (12, 5, 7), (64, 32, 40)] {
        let still = noise(width, height, 0.5, 2.0, 15);
        // Counter-clockwise from above: what was seen towards −z is then seen towards −x, a smaller u.
        let moved = image(width, height, |r, c| still.texels[r * width + (c + steps) % width]);
        let turned = EnvironmentImage { rotation: (360.0 * steps as f64 / width as f64) as f32, ..still };
        let (turned, moved) = (image_lights(&turned), image_lights(&moved));
        // A place is known to 8·2⁻²⁴ of the circle and the angle of rotation to 2⁻²⁴ of itself; the texels' slope is at
        // most 1.5 a column, 1 near the largest density.
        let bound = 24.0 * ULP * (width + height) as f64 * 4.0 + 32.0 * ULP;
        for _ in 0..20_000 {
            // A pole has any azimuth.
            let d = loop {
                let d = rng.sphere();
                if d[1].abs() < 0.99 {
                    break vec1(f32s(d));
                }
            };
            let ((a, pdf_a), (b, pdf_b)) = (turned.environment(d), moved.environment(d));
            for (x, y) in [(a.x, b.x), (pdf_a, pdf_b)] {
                assert!((f64::from(x) / f64::from(y) - 1.0).abs() < bound, "{x} for {y}, {width}×{height}, {d:?}");
            }
            let s = draw(&turned, [0.0; 3], &mut rng);
            let (radiance, pdf) = moved.environment(s.wi);
            assert!(s.wi.y.abs() > 0.99 || (f64::from(s.radiance.x) / f64::from(radiance.x) - 1.0).abs() < bound);
            assert!(s.wi.y.abs() > 0.99 || (f64::from(s.pdf) / f64::from(pdf) - 1.0).abs() < bound);
        }
    }
}

#[test]
fn a_turned_image_follows_its_density() {
    let turned = image_lights(&EnvironmentImage { rotation: -100.0, ..noise(8, 4, 0.0, 1.0, 1) });
    let outcome = Chi2Sphere::new("turned")
        .tests(TESTS)
        .around([0.0, 1.0, 0.0], 1.0)
        .outcome(|rng| Some(f64s(draw(&turned, [0.0; 3], rng).wi.lane(0))), |d| stated_pdf(&turned, &[], [0.0; 3], d));
    assert!(outcome.failure.is_none(), "{}", outcome.failure.unwrap());
    // A whole turn is none, and no stage of its own.
    let sky = |rotation| image_lights(&EnvironmentImage { rotation, ..noise(8, 4, 0.0, 1.0, 1) });
    let d = vec1([0.6, 0.48, -0.64]);
    assert_eq!(sky(-720.0).environment(d).0.lane(0), sky(0.0).environment(d).0.lane(0));
}
