//! Which light: frequencies against the stated probabilities, and those against power.

use super::TESTS;
use super::scenes::*;
use crate::stats::{Rng, chi2_test, sidak_alpha};
use octolux::light::{Emitter, EmitterShape, Lights};
use octolux::scene::Environment;

/// Triangles that all face the origin, so that every draw is valid.
fn lamps(powers: &[f64]) -> Vec<Emitter> {
    let lamp = |(i, &power): (usize, &f64)| {
        let x = i as f64 / powers.len() as f64;
        let corners = [[x, 0.0, 1.0], [x, 0.5, 1.0], [x + 0.5, 0.0, 1.0]];
        triangle(i as u32, corners, [power as f32; 3])
    };
    powers.iter().enumerate().map(lamp).collect()
}

/// Choice probabilities as the densities state them.
fn stated(lights: &Lights, emitters: &[Emitter]) -> Vec<f64> {
    let probability = |e: &Emitter| match e.shape {
        EmitterShape::Triangle { .. } => f64::from(lights.emitter_pdf_row(e.primitive)) * e.area(),
        EmitterShape::Sphere { .. } => f64::from(lights.emitter_pdf_row(e.primitive)),
    };
    emitters.iter().map(probability).collect()
}

fn frequencies_match(name: &str, emitters: &[Emitter], draws: usize, seed: u64) {
    let lights = area_lights(emitters);
    let mut rng = Rng::new(seed);
    let mut observed = vec![0u64; emitters.len()];
    for _ in 0..draws {
        observed[draw(&lights, [0.0; 3], &mut rng).primitive.0 as usize] += 1;
    }
    let p = stated(&lights, emitters);
    let expected: Vec<f64> = p.iter().map(|p| p * draws as f64).collect();
    let outcome = chi2_test(&observed, &expected);
    assert!(outcome.p_value > sidak_alpha(TESTS), "{name}: {outcome:?}");
    assert!((p.iter().sum::<f64>() - 1.0).abs() < f64::powi(2.0, -23), "{name}: Σ = {}", p.iter().sum::<f64>());
}

fn log_normal(n: usize, sigma: f64, seed: u64) -> Vec<f64> {
    let mut rng = Rng::new(seed);
    (0..n).map(|_| (sigma * (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0 * sigma).exp()).collect()
}

#[test]
fn drawn_as_often_as_stated() {
    frequencies_match("three", &lamps(&[1.0, 2.0, 5.0]), 100_000, 1);
    frequencies_match("equal", &lamps(&[1.0; 7]), 100_000, 2);
    frequencies_match(
        "one of 64 bright",
        &lamps(&std::array::from_fn::<f64, 64, _>(|i| if i == 17 { 1e4 } else { 1.0 })),
        400_000,
        3,
    );
    frequencies_match("log-normal 1000", &lamps(&log_normal(1000, 2.0, 9)), 2_000_000, 4);
    frequencies_match("log-normal 10,000", &lamps(&log_normal(10_000, 0.5, 10)), 2_000_000, 5);
}

/// Each probability is the light's share of the power, up to a step of the cumulative sums' grid, 2⁻²⁴ (half of one at
/// either end; of more than 1024 lights, half a step of the thresholds' grid, 2⁻²⁵ / n), and roundings of the weight and of
/// the stored quotient.
#[test]
fn stated_as_the_powers_are() {
    for powers in [
        vec![1.0, 1e-3, 1e3],
        log_normal(1000, 3.0, 11),
        log_normal(2000, 3.0, 11),
        vec![1e-30, 3e-30],
        vec![1e30, 1e25],
    ] {
        let emitters = lamps(&powers);
        let lights = area_lights(&emitters);
        let total: f64 = emitters.iter().map(Emitter::power).sum();
        let step = if powers.len() > 1024 { 1.0 / powers.len() as f64 } else { 1.0 };
        for (e, p) in emitters.iter().zip(stated(&lights, &emitters)) {
            let share = e.power() / total;
            let bound = f64::powi(2.0, -24) * (share * 4.0 + step);
            assert!((p - share).abs() <= bound, "{p} for a share of {share}");
        }
    }
}

/// A share below the table's grid is probability 0 in the table, in the density and in the draws alike.
#[test]
fn power_ratio_1e12() {
    for order in [[1.0, 1e-12], [1e-12, 1.0]] {
        let emitters = lamps(&order);
        let lights = area_lights(&emitters);
        let bright = usize::from(order[1] == 1.0);
        let p = stated(&lights, &emitters);
        assert!((p[bright] - 1.0).abs() < f64::powi(2.0, -23) && p[1 - bright] == 0.0, "{p:?}");
        let mut rng = Rng::new(12);
        for _ in 0..100_000 {
            assert_eq!(draw(&lights, [0.0; 3], &mut rng).primitive, bits(bright as u32));
        }
        for edge in [0.0, 0.5 - f32::EPSILON, 0.5, 1.0 - f32::EPSILON / 2.0] {
            let sample = lights.sample(vec1([0.0; 3]), edge, [0.0, 0.0], true);
            assert_eq!(sample.primitive, bits(bright as u32));
        }
    }
    // Above the grid, seen by frequency.
    frequencies_match("one in 16,385", &lamps(&[1.0, f64::powi(2.0, -14)]), 2_000_000, 13);
}

/// 10⁵ equal lights do not divide 2²⁴ numbers: 23 % of the places hold 167 of them, the rest 168. Without bits below the
/// last one the former would come .46 % too rarely, five standard errors here.
#[test]
fn many_lights_are_equally_frequent() {
    let n = 100_000u64;
    let emitters = lamps(&vec![1.0; n as usize]);
    let lights = area_lights(&emitters);
    let numbers = |i: u64| ((i + 1) << 24).div_ceil(n) - (i << 24).div_ceil(n);
    let scarce = (0..n).filter(|&i| numbers(i) == 167).count() as f64 / n as f64;
    let mut rng = Rng::new(15);
    let draws = 6_000_000u64;
    let seen =
        (0..draws).filter(|_| numbers(u64::from(draw(&lights, [0.0; 3], &mut rng).primitive.0)) == 167).count() as u64;
    let outcome = chi2_test(&[seen, draws - seen], &[scarce, 1.0 - scarce].map(|p| p * draws as f64));
    assert!(outcome.p_value > sidak_alpha(TESTS), "{seen} of {draws}: {outcome:?}");
}

/// The environment takes half the samples where there are area lights, all where there are none.
#[test]
fn the_environments_share() {
    let emitters = lamps(&[1.0, 2.0]);
    let sky = Environment::Constant([1e-3; 3]);
    let both = Lights::build(emitters.clone(), Some(&sky)).unwrap();
    assert!((stated(&both, &emitters).iter().sum::<f64>() - 0.5).abs() < f64::powi(2.0, -24));
    let d = vec1([0.0, 1.0, 0.0]);
    let uniform = 0.25 / std::f64::consts::PI;
    assert_eq!(both.environment(d).1, (0.5 * uniform) as f32);
    assert_eq!(Lights::build(Vec::new(), Some(&sky)).unwrap().environment(d).1, uniform as f32);
    let mut rng = Rng::new(14);
    let n = 100_000;
    let mut observed = [0u64; 3];
    for _ in 0..n {
        let sample = draw(&both, [0.0; 3], &mut rng);
        observed[if sample.is_environment { 2 } else { sample.primitive.0 as usize }] += 1;
        assert_eq!(sample.is_environment, sample.distance == f32::INFINITY);
    }
    let outcome = chi2_test(&observed, &[1.0 / 6.0, 1.0 / 3.0, 0.5].map(|p| p * f64::from(n)));
    assert!(outcome.p_value > sidak_alpha(TESTS), "{outcome:?}");
}
