//! Irradiance and its per-sample variance against closed forms.

use super::TESTS;
use super::scenes::*;
use crate::stats::{Moments, Rng, assert_mean, assert_variance, oracle};
use octolux::light::{Emitter, Lights};
use std::f64::consts::PI;

const ULP: f64 = 5.960_464_477_539_063e-8; // 2⁻²⁴
/// What rounded inputs (each coordinate by half an ulp) and a dozen f32 operations may move an estimate, relatively.
const ROUNDING: f64 = 24.0 * ULP;

/// Samples of L·max(cos, 0)/pdf at the origin facing `n`, one channel.
fn samples(lights: &Lights, n: V, count: usize, seed: u64) -> Moments {
    let mut rng = Rng::new(seed);
    let one = |_| {
        let s = draw(lights, [0.0; 3], &mut rng);
        let cos = dot(f64s(s.wi.lane(0)), n).max(0.0);
        if s.pdf > 0.0 { f64::from(s.radiance.x) * cos / f64::from(s.pdf) } else { 0.0 }
    };
    (0..count).map(one).collect()
}

/// Two triangles over the corners, facing the origin.
fn quad(corners: [V; 4]) -> Vec<Emitter> {
    let [a, b, c, d] = corners;
    let faces_origin = dot(cross(sub(b, a), sub(c, a)), a) < 0.0;
    let lamp = |i, p: [V; 3]| triangle(i, if faces_origin { p } else { [p[0], p[2], p[1]] }, [1.0; 3]);
    vec![lamp(0, [a, b, c]), lamp(1, [a, c, d])]
}

fn square(half: f64, z: f64) -> Vec<Emitter> {
    quad([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
}

/// x = 1, |y| ≤ ½, z between the two.
fn wall(z0: f64, z1: f64) -> Vec<Emitter> {
    quad([[1.0, -0.5, z0], [1.0, 0.5, z0], [1.0, 0.5, z1], [1.0, -0.5, z1]])
}

fn check(id: &str, emitters: &[Emitter], n: V, factor: f64, count: usize) {
    let Some(case) = oracle(id) else { return };
    let moments = samples(&area_lights(emitters), n, count, 1);
    assert_mean(id, &moments, case.value / factor, case.value / factor * ROUNDING, TESTS);
}

#[test]
fn polygons() {
    let up = [0.0, 0.0, 1.0];
    for (id, h) in [("0.1", 0.1), ("0.5", 0.5), ("1", 1.0), ("2", 2.0), ("10", 10.0), ("1e3", 1e3)] {
        check(&format!("A.sq_par_h{id}"), &square(0.5, h), up, 1.0, 200_000);
    }
    let corner = |h| quad([[0.0, 0.0, h], [1.0, 0.0, h], [1.0, 1.0, h], [0.0, 1.0, h]]);
    check("A.sq_corner_h1", &corner(1.0), up, 1.0, 200_000);
    check("A.sq_omega1e-6", &square(5e-4, 1.0), up, 1.0, 20_000);
    check("A.sq_perp_full", &wall(0.0, 1.0), up, 1.0, 200_000);
    check("A.sq_perp_grazing1e-3", &wall(0.0, 1e-3), up, 1.0, 200_000);
    check("A.sq_perp_grazing1e-6", &wall(0.0, 1e-6), up, 1.0, 200_000);
    check("A.sq_perp_halfbelow", &wall(-0.5, 0.5), up, 1.0, 200_000);
    check("A.sq_perp_above", &wall(1.0, 2.0), up, 1.0, 200_000);
    let sliver = [[-0.5, 0.0, 1.0], [0.0, 1e-6, 1.0], [0.5, 0.0, 1.0]];
    check("A.sliver_1e6", &[triangle(0, sliver, [1.0; 3])], up, 1.0, 200_000);

    // Unit square facing the receiver from 89.9° off its normal, crossing the horizon.
    let (s, c) = 89.9f64.to_radians().sin_cos();
    let at = |a: f64, b: f64| [5.0 * s - a * c, b, 5.0 * c + a * s];
    let facing = quad([at(-0.5, -0.5), at(0.5, -0.5), at(0.5, 0.5), at(-0.5, 0.5)]);
    check("A.sq_facing_89.9deg", &facing, up, 1.0, 200_000);
}

/// Lambert of reflectance ½ under a triangle (y up): L = E/(2π). A coordinate's half ulp against a light whose nearest
/// point is not near the horizon stays within the rounding allowed.
#[test]
fn nori_triangles() {
    let lights = [
        ("2", [[0.461963, 0.397843, 0.412747], [-0.0381582, 0.851323, -0.156872], [0.195443, 0.891957, -0.260672]]),
        ("3", [[0.100871, 0.289075, -0.422609], [-0.308386, 0.629587, 0.423966], [-0.373132, 0.237287, 0.351592]]),
        ("4", [[-0.17575, 0.639397, 0.151268], [0.318604, 0.732996, 0.459771], [0.139095, 0.294498, 0.478556]]),
        ("5", [[-0.17487, 0.447916, 0.367201], [-0.405259, 0.249607, -0.354079], [0.356029, 0.0918984, -0.132271]]),
    ];
    for (id, p) in lights {
        let towards = dot(cross(sub(p[1], p[0]), sub(p[2], p[0])), p[0]) < 0.0;
        let p = if towards { p } else { [p[0], p[2], p[1]] };
        check(&format!("A.nori_polylum{id}"), &[triangle(0, p, [1.0; 3])], [0.0, 1.0, 0.0], 0.5 / PI, 400_000);
    }
}

#[test]
fn spheres() {
    for (ratio, angles) in [("0.5", [75.0, 90.0, 100.0]), ("0.9", [75.0, 90.0, 100.0]), ("0.01", [0.0, 75.0, 90.0])] {
        for angle in angles {
            let (s, c) = f64::to_radians(angle).sin_cos();
            let light = sphere(0, [s, 0.0, c], ratio.parse().unwrap(), [1.0; 3]);
            check(&format!("B.sphere_r/d{ratio}_th{angle}"), &[light], [0.0, 0.0, 1.0], 1.0, 200_000);
        }
    }
    let sun = sphere(0, [0.0, 0.0, 1.0], 0.2665f64.to_radians().sin(), [1.0; 3]);
    check("B.sun", &[sun], [0.0, 0.0, 1.0], 1.0, 20_000);
}

/// Variance of L_out = E/π, one sample each. Rounding adds the square of a few ulps of the mean.
#[test]
fn variances() {
    let cases = [
        ("H.area_sampling_h0.1", square(0.5, 0.1), 2_000_000),
        ("H.sphere_cone_r/d0.5", vec![sphere(0, [0.0, 0.0, 1.0], 0.5, [1.0; 3])], 1_000_000),
        ("H.sphere_cone_r/d0.01", vec![sphere(0, [0.0, 0.0, 1.0], 0.01, [1.0; 3])], 1_000_000),
    ];
    for (id, emitters, count) in cases {
        let Some(case) = oracle(id) else { return };
        let mean = case.record["mean"].as_f64().unwrap();
        let lights = area_lights(&emitters);
        let mut rng = Rng::new(2);
        let one = |_| {
            let s = draw(&lights, [0.0; 3], &mut rng);
            f64::from(s.radiance.x) * f64::from(s.wi.z) / f64::from(s.pdf) / PI
        };
        let moments: Moments = (0..count).map(one).collect();
        assert_mean(id, &moments, mean, mean * ROUNDING, TESTS);
        let noise = 4.0 * ULP * mean;
        let relative = 2.0 * ROUNDING * case.value;
        assert_variance(
            id,
            &moments,
            case.value,
            relative + noise * noise + 2.0 * noise * case.value.sqrt() * 1e-3,
            TESTS,
        );
    }
}

/// Lights of equal power, one a million times as far: each is chosen half the time, so X is 2a or 2b and its variance
/// (a − b)². X itself wavers by (r/d)² of its value; n fair choices miss ½ by z/(2√n), which takes z²/n off the variance.
#[test]
fn light_selection_variance() {
    let Some(case) = oracle("H.two_light_uniform") else { return };
    let emitters = [sphere(0, [0.0, 0.0, 1.0], 1e-3, [1.0; 3]), sphere(1, [0.0, 0.0, 1e6], 1e-3, [1.0; 3])];
    let n = 400_000;
    let moments = samples(&area_lights(&emitters), [0.0, 0.0, 1.0], n, 3);
    let a = PI * f64::from(1e-3f32).powi(2);
    let normalised = moments.variance() / (a * a);
    let bound = 16.0 / n as f64 + 4.0 * 1e-6 + 2.0 * ROUNDING;
    assert!((normalised - case.value).abs() <= bound, "{normalised} for {}", case.value);
}

/// Scaling everything by a power of two changes no bit of what arrives.
#[test]
fn scale_by_a_power_of_two() {
    let base = [
        triangle(0, [[-0.6, -0.4, 1.0], [0.8, -0.5, 0.9], [0.1, 0.7, 1.1]].map(|p| scaled(p, 1.0)), [1.0; 3]),
        sphere(1, [0.3, 1.0, 0.2], 0.1, [3.0; 3]),
    ];
    let emitters = |k: i32| base.map(|e| scale(e, f32::powi(2.0, k)));
    let reference = area_lights(&emitters(0));
    for k in [-30, -7, 5, 30] {
        let lights = area_lights(&emitters(k));
        let (mut one, mut other) = (Rng::new(4), Rng::new(4));
        let mut valid = 0;
        for _ in 0..5_000 {
            let p = f32s(scaled(one.sphere(), 0.3));
            assert_eq!(f32s(scaled(other.sphere(), 0.3)), p);
            let a = draw(&reference, p, &mut one);
            let b = draw(&lights, p.map(|c| c * f32::powi(2.0, k)), &mut other);
            assert_eq!(
                (a.pdf.to_bits(), a.wi.lane(0).map(f32::to_bits)),
                (b.pdf.to_bits(), b.wi.lane(0).map(f32::to_bits))
            );
            assert_eq!((a.distance * f32::powi(2.0, k)).to_bits(), b.distance.to_bits());
            valid += usize::from(a.pdf > 0.0);
        }
        assert!(valid > 1000);
    }
}

fn scale(e: Emitter, s: f32) -> Emitter {
    use octolux::light::EmitterShape::{Sphere, Triangle};
    let by = |v: [f32; 3]| v.map(|c| c * s);
    let shape = match e.shape {
        Triangle { p0, e1, e2 } => Triangle { p0: by(p0), e1: by(e1), e2: by(e2) },
        Sphere { center, radius } => Sphere { center: by(center), radius: radius * s },
    };
    Emitter { shape, ..e }
}
