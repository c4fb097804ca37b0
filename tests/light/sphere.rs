//! Sphere lights: the cone, its stable forms, points on the surface.

use super::TESTS;
use super::scenes::*;
use crate::stats::{Rng, chi2_test, oracle, sidak_alpha};
use octolux::light::{EmitterShape, sphere_pdf, triangle_pdf};
use std::f64::consts::TAU;

const ULP: f64 = 5.960_464_477_539_063e-8; // 2⁻²⁴

/// Cells of equal solid angle inside the cone: the stated density times that must be each one's share.
#[test]
fn spheres_follow_their_density() {
    const ROWS: usize = 16;
    const COLUMNS: usize = 32;
    let cases = [("near", [0.3, -0.2, 1.0], 1.0), ("half", [1.0, 1.0, -1.0], 0.8), ("small", [-1.2, 0.4, 0.3], 0.02)];
    for (name, center, radius) in cases {
        let lights = area_lights(&[sphere(0, center, radius, [1.0; 3])]);
        let axis = unit(center);
        let side = unit(cross(axis, [0.0, 1.0, 0.0]));
        let other = cross(axis, side);
        let s2 = radius * radius / dot(center, center);
        let one_minus_cos = s2 / (1.0 + (1.0 - s2).sqrt());
        let pdf = f64::from(lights.pdf_area::<f32>(bits(0), vec1([0.0; 3]), 1.0, 1.0));
        let share = pdf * TAU * one_minus_cos / (ROWS * COLUMNS) as f64;
        let draws = 200_000;
        let mut observed = vec![0u64; ROWS * COLUMNS];
        let mut rng = Rng::new(5);
        for _ in 0..draws {
            let d = f64s(draw(&lights, [0.0; 3], &mut rng).wi.lane(0));
            // 1 − cosθ without cancellation: |d − axis|²/2.
            let off = sub(d, axis);
            let row = (0.5 * dot(off, off) / one_minus_cos * ROWS as f64) as usize;
            let turn = (dot(d, other).atan2(dot(d, side)) / TAU).rem_euclid(1.0);
            let column = ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1);
            observed[row.min(ROWS - 1) * COLUMNS + column] += 1;
        }
        let outcome = chi2_test(&observed, &vec![share * f64::from(draws); ROWS * COLUMNS]);
        assert!(outcome.p_value > sidak_alpha(TESTS), "{name}: {outcome:?}");
    }
}

/// 1/(cone's solid angle) from far to touching, within the ulps that r, D and the quotients cost; nearer than that the
/// error of D itself decides, hence its share ulp·D/(D − r).
#[test]
fn cone_solid_angle() {
    let mut rng = Rng::new(1);
    for exponent in 0..60 {
        let distance = 1.0 + f64::powi(2.0, 20 - exponent);
        for _ in 0..20 {
            let center = f32s(scaled(rng.sphere(), distance));
            let d = norm(f64s(center));
            if d <= 1.0 {
                continue;
            }
            let s2 = 1.0 / (d * d);
            let exact = (1.0 + (1.0 - s2).sqrt()) / (TAU * s2);
            let pdf = f64::from(sphere_pdf(1.0, vec1(center), 1.0, vec1([0.0; 3])));
            let bound = exact * ULP * (10.0 + 2.0 * (d / (d - 1.0)).sqrt());
            assert!((pdf - exact).abs() <= bound || pdf == 0.0 && d - 1.0 < 3.0 * ULP, "{pdf} for {exact} at {d}");
        }
    }
}

#[test]
fn cone_oracles() {
    for (id, ratio) in [("B.cone_1-cos_rd1e-3", 1e-3), ("B.sun_solid", (0.2665f64).to_radians().sin())] {
        let Some(case) = oracle(id) else { return };
        let pdf = f64::from(sphere_pdf(1.0, vec1([0.0, 0.0, 1.0]), ratio as f32, vec1([0.0; 3])));
        let relative = (1.0 / pdf / case.value - 1.0).abs();
        assert!(relative <= 8.0 * ULP, "{id}: {relative:e} off");
    }
}

/// From every distance and for every u, limb included, the point is on the surface and along wi, and wi meets the
/// sphere there: nothing is off by more than a few ulp of the coordinates.
#[test]
fn targets_lie_on_the_sphere() {
    let mut rng = Rng::new(2);
    for radius in [1.0, 1e-3, 1e-6] {
        for ratio in [1.0001, 1.1, 2.0, 100.0, 1e5, 1e7] {
            let distance = radius * ratio;
            for _ in 0..50 {
                let light = sphere(0, rng.sphere(), radius, [1.0; 3]);
                let EmitterShape::Sphere { center, radius } = light.shape else { unreachable!() };
                let lights = area_lights(&[light]);
                let p = f32s(std::array::from_fn({
                    let away = scaled(rng.sphere(), distance);
                    move |k| f64::from(center[k]) + away[k]
                }));
                let to_center = norm(sub(f64s(center), f64s(p)));
                for k in 0..20 {
                    let edge = [0.0, 1.0 - f32::EPSILON / 2.0, f32::EPSILON][k % 3];
                    let u = [if k < 6 { edge } else { rng.f32() }, rng.f32()];
                    let sample = lights.sample(vec1(p), rng.f32(), u, true);
                    let outside = to_center > f64::from(radius) * (1.0 + 4.0 * ULP);
                    assert!(!outside || sample.pdf > 0.0);
                    if sample.pdf == 0.0 {
                        continue;
                    }
                    let r = f64::from(radius);
                    let target = f64s(sample.target.lane(0));
                    let from_center = sub(target, f64s(center));
                    let error = norm(f64s(sample.target_error.lane(0)));
                    assert!((norm(from_center) - r).abs() <= error, "{} off the surface", norm(from_center) - r);
                    assert!((norm(f64s(sample.ng.lane(0))) - 1.0).abs() <= 6.0 * ULP);
                    assert!((norm(f64s(sample.wi.lane(0))) - 1.0).abs() <= 6.0 * ULP);
                    // Both ways to the target: along wi from p, and the point itself. The common part of their errors
                    // is how exactly D is known: its rounding moves the near point by D/cos at the limb.
                    let reached = scaled(f64s(sample.wi.lane(0)), f64::from(sample.distance));
                    let gap = norm(sub(sub(target, f64s(p)), reached));
                    let scale = to_center + norm(f64s(p)) + 1.0;
                    assert!(gap <= 16.0 * ULP * scale, "gap {gap:e} at distance {to_center:e}, radius {r:e}");
                }
            }
        }
    }
}

#[test]
fn inside_is_dark() {
    let lights = area_lights(&[sphere(0, [0.1, 0.0, 0.0], 1.0, [1.0; 3])]);
    let mut rng = Rng::new(3);
    for p in [[0.1, 0.0, 0.0], [0.0; 3], [0.5, 0.5, 0.5], [1.1, 0.0, 0.0]] {
        let sample = draw(&lights, p, &mut rng);
        assert_eq!((sample.pdf, sample.radiance.lane(0)), (0.0, [0.0; 3]), "from {p:?}");
        assert_eq!(lights.pdf_area::<f32>(bits(0), vec1(p), 1.0, 1.0), 0.0);
    }
}

/// For spheres sample and pdf are the same expression of the same operands.
#[test]
fn sample_and_pdf_agree() {
    let emitters = [sphere(4, [1.0, 0.2, 0.1], 0.3, [1.0; 3]), sphere(9, [-1.0, 0.5, 0.1], 0.01, [50.0; 3])];
    let lights = area_lights(&emitters);
    let mut rng = Rng::new(4);
    for _ in 0..10_000 {
        let p = f32s(scaled(rng.sphere(), 0.5));
        let sample = draw(&lights, p, &mut rng);
        let pdf = lights.pdf_area::<f32>(sample.primitive, vec1(p), f32::NAN, f32::NAN);
        assert_eq!(pdf.to_bits(), sample.pdf.to_bits());
    }
    // A primitive that is no light has no density.
    assert_eq!(lights.pdf_area::<f32>(bits(5), vec1([0.0; 3]), 1.0, 1.0), 0.0);
    assert!(triangle_pdf(lights.emitter_pdf_row(5), 1.0f32, 1.0) == 0.0);
}
