//! Point, spot and directional lights: inverse squares, cones, and the choice among them and the others.

use super::TESTS;
use super::scenes::*;
use crate::stats::{Moments, Rng, assert_mean, chi2_test, oracle, sidak_alpha};
use octolux::light::{DELTA_LIGHT, Emitter, EnvironmentMap, Extent, LightError, Lights};
use octolux::scene::{DeltaLight, Environment};
use std::f64::consts::PI;

const ULP: f64 = 5.960_464_477_539_063e-8; // 2⁻²⁴
const HERE: Extent = Extent { scale: 1.0, radius: 1.5 };

fn delta(lights: &[DeltaLight]) -> Lights {
    Lights::with_delta(Vec::new(), None, lights, HERE).unwrap()
}

fn point(position: [f32; 3], intensity: f32) -> DeltaLight {
    DeltaLight::Point { position, intensity: [intensity; 3] }
}

fn sun(direction: V, irradiance: f32) -> DeltaLight {
    DeltaLight::Directional { direction: f32s(unit(direction)), irradiance: [irradiance; 3] }
}

fn spot(position: [f32; 3], direction: V, angle: f32, intensity: f32) -> DeltaLight {
    DeltaLight::Spot { position, direction: f32s(unit(direction)), intensity: [intensity; 3], angle }
}

/// What arrives at `p` per unit of area facing the light, and from where, in f64.
fn exact(light: &DeltaLight, p: [f32; 3]) -> (f64, V) {
    let to = |position: [f32; 3]| sub(f64s(position), f64s(p));
    match *light {
        DeltaLight::Directional { direction, irradiance } => (irradiance[0].into(), scaled(f64s(direction), -1.0)),
        DeltaLight::Point { position, intensity } => {
            let way = to(position);
            (f64::from(intensity[0]) / dot(way, way), unit(way))
        }
        DeltaLight::Spot { position, direction, intensity, angle } => {
            let (way, axis) = (to(position), f64s(direction));
            let off = norm(cross(way, axis)).atan2(-dot(way, axis)).to_degrees();
            let lit = if off <= angle.into() { 1.0 } else { 0.0 };
            (lit * f64::from(intensity[0]) / dot(way, way), unit(way))
        }
    }
}

#[test]
fn each_gives_what_its_formula_says() {
    let mut rng = Rng::new(21);
    let lights = [
        point([0.3, 1.2, -0.4], 10.0),
        sun([0.2, -1.0, 0.5], 3.0),
        spot([0.3, 1.2, -0.4], [0.1, -1.0, 0.0], 40.0, 7.0),
        spot([0.0, 0.1, 0.0], [0.0, 0.0, 1.0], 120.0, 2.0),
        spot([0.0, 0.5, 0.0], [1.0, 0.0, 0.0], 180.0, 2.0),
    ];
    for light in lights {
        let alone = delta(&[light]);
        let mut lit = 0;
        for _ in 0..20_000 {
            let p = f32s(scaled(rng.sphere(), rng.range(0.0, 2.0)));
            let sample = draw(&alone, p, &mut rng);
            let (arrives, wi) = exact(&light, p);
            if arrives == 0.0 {
                assert!(sample.pdf == 0.0 && sample.radiance.lane(0) == [0.0; 3], "{light:?} {p:?}");
                continue;
            }
            lit += 1;
            assert_eq!((sample.pdf, sample.primitive), (1.0, bits(DELTA_LIGHT)), "{light:?} {p:?}");
            assert_eq!(sample.is_environment, matches!(light, DeltaLight::Directional { .. }));
            assert!(sample.is_delta());
            // Three differences, each rounded to half its ulp; a dozen roundings more.
            assert!((f64::from(sample.radiance.y) - arrives).abs() <= 12.0 * ULP * arrives, "{light:?} {p:?}");
            assert!(norm(sub(f64s(sample.wi.lane(0)), wi)) < 6.0 * ULP);
        }
        assert!(lit > 500, "{light:?}: {lit}");
    }
    let Some(case) = oracle("B.point_I1_d1") else { return };
    assert_eq!(f64::from(draw(&delta(&[point([0.0, 0.0, 1.0], 1.0)]), [0.0; 3], &mut rng).radiance.x), case.value);
}

/// A cone of a hundredth of a degree is lit inside and dark outside, where a cosine in f32 could not tell.
#[test]
fn narrow_cones_have_their_width() {
    for angle in [0.01f32, 0.3, 5.0, 89.0, 90.0, 91.0, 170.0] {
        let alone = delta(&[spot([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], angle, 1.0)]);
        for (factor, lit) in [(0.999, true), (1.001, false)] {
            let (sin, cos) = (f64::from(angle) * factor).to_radians().sin_cos();
            for phi in [0.0, 1.0, 2.5, 4.0] {
                let p = f32s([sin * f64::cos(phi), sin * f64::sin(phi), 1.0 - cos]);
                let sample = draw(&alone, p, &mut Rng::new(1));
                assert_eq!(sample.pdf > 0.0, lit, "{angle} degrees, {factor} of it");
            }
        }
    }
}

#[test]
fn at_the_light_itself_there_is_no_sample() {
    let sample = draw(&delta(&[point([0.5, 0.25, 0.0], 1.0)]), [0.5, 0.25, 0.0], &mut Rng::new(1));
    assert!(sample.pdf == 0.0 && sample.radiance.lane(0) == [0.0; 3]);
}

/// Told apart by where they are.
#[test]
fn drawn_as_often_as_stated() {
    let strengths = [1.0, 100.0, 1e-9, 20.0];
    let at = |i: usize| [i as f32 * 0.25, 1.0, 0.0];
    let all: Vec<DeltaLight> = strengths.iter().enumerate().map(|(i, &s)| point(at(i), s)).collect();
    let lights = delta(&all);
    let mut rng = Rng::new(22);
    let (mut observed, mut stated) = ([0u64; 4], [0.0; 4]);
    let draws = 400_000;
    for _ in 0..draws {
        let sample = draw(&lights, [0.0; 3], &mut rng);
        let i = (sample.target.x * 4.0) as usize;
        observed[i] += 1;
        stated[i] = sample.pdf.into();
    }
    assert!((stated.iter().sum::<f64>() - 1.0).abs() < 4.0 * ULP, "{stated:?}");
    // Half of the draws are spread evenly, half go by power.
    let total: f64 = strengths.iter().map(|&s| f64::from(s)).sum();
    for (p, &s) in stated.iter().zip(&strengths) {
        assert!((p - 0.125 - 0.5 * f64::from(s) / total).abs() < 1e-6, "{stated:?}");
    }
    let outcome = chi2_test(&observed, &stated.map(|p| p * f64::from(draws)));
    assert!(outcome.p_value > sidak_alpha(TESTS), "{observed:?} {stated:?}: {outcome:?}");
}

/// Whatever else shines, the sum of all arrives: a choice probability that did not match its frequency would show.
#[test]
fn mixtures_add_up() {
    let all =
        [point([0.2, -0.1, 1.0], 2.0), sun([0.3, 0.1, -1.0], 1.5), spot([0.0, 0.0, 1.5], [0.0, 0.0, -1.0], 20.0, 0.01)];
    let n = [0.0, 0.0, 1.0];
    let delta_sum: f64 = all.iter().map(|l| exact(l, [0.0; 3])).map(|(e, wi)| e * dot(wi, n)).sum();
    let lamp = sphere(3, [0.0, 0.0, 1.2], 0.3, [4.0; 3]);
    let lamp_sum = 4.0 * PI * (0.3f64 / 1.2).powi(2);
    let grey = Environment::Constant([0.5; 3]);
    let scenes: [(&str, Vec<Emitter>, Option<&Environment>, f64); 4] = [
        ("alone", vec![], None, 0.0),
        ("with a lamp", vec![lamp], None, lamp_sum),
        ("under a sky", vec![], Some(&grey), 0.5 * PI),
        ("with both", vec![lamp], Some(&grey), 0.5 * PI + lamp_sum),
    ];
    for (name, emitters, environment, others) in scenes {
        let lights = Lights::with_delta(emitters, environment.and_then(EnvironmentMap::build), &all, HERE).unwrap();
        assert_eq!(lights.delta_count(), 3);
        let mut rng = Rng::new(23);
        let one = |_| {
            let s = draw(&lights, [0.0; 3], &mut rng);
            let cos = dot(f64s(s.wi.lane(0)), n).max(0.0);
            if s.pdf > 0.0 { f64::from(s.radiance.x) * cos / f64::from(s.pdf) } else { 0.0 }
        };
        let moments: Moments = (0..400_000).map(one).collect();
        assert_mean(name, &moments, delta_sum + others, 32.0 * ULP * (delta_sum + others), TESTS);
    }
}

#[test]
fn intensities_follow_the_scale() {
    // Lengths halved: the same irradiance takes a quarter of the intensity.
    let light = spot([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 10.0, 12.0);
    let halved = Lights::with_delta(Vec::new(), None, &[light], Extent { scale: 0.5, radius: 1.0 }).unwrap();
    let sample = draw(&halved, [0.0; 3], &mut Rng::new(1));
    assert_eq!((sample.distance, sample.radiance.x), (1.0, 3.0));
    let huge = Lights::with_delta(Vec::new(), None, &[light], Extent { scale: 2f32.powi(80), radius: 1.0 });
    assert_eq!(huge.err(), Some(LightError::Overflow));
    // With nothing to shine on, directions are chosen evenly.
    let suns = [sun([0.0, 0.0, -1.0], 1.0), sun([0.0, -1.0, 0.0], 3.0)];
    let empty = Lights::with_delta(Vec::new(), None, &suns, Extent { scale: 1.0, radius: 0.0 }).unwrap();
    assert_eq!(draw(&empty, [0.0; 3], &mut Rng::new(1)).pdf, 0.5);
    let dark = delta(&[point([0.0; 3], 0.0)]);
    assert!(dark.is_empty() && dark.memory() == 0);
}
