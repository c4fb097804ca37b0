//! The look-up against the format's own words in f64.

use super::scenes::*;
use crate::stats::Rng;
use octolux::scene::EnvironmentImage;
use std::f64::consts::{PI, TAU};

/// u = atan2(x, −z)/2π wrapped to [0, 1), v = acos(y)/π, bilinear between texel centres, wrapping in u, clamped in v.
pub fn reference_lookup(image: &EnvironmentImage, d: V) -> V {
    let d = unit(d);
    let u = d[0].atan2(-d[2]) / TAU;
    let v = d[1].clamp(-1.0, 1.0).acos() / PI;
    let x = u.rem_euclid(1.0) * image.width as f64 - 0.5;
    let y = v * image.height as f64 - 0.5;
    let texel = |row: f64, column: f64| {
        let column = column.rem_euclid(image.width as f64) as usize;
        let row = row.clamp(0.0, (image.height - 1) as f64) as usize;
        f64s(image.texels[row * image.width + column])
    };
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let mut sum = [0.0; 3];
    for (row, wy) in [(y.floor(), 1.0 - fy), (y.floor() + 1.0, fy)] {
        for (column, wx) in [(x.floor(), 1.0 - fx), (x.floor() + 1.0, fx)] {
            let t = texel(row, column);
            (0..3).for_each(|k| sum[k] += wx * wy * t[k]);
        }
    }
    sum
}

/// Directions at and beside the poles, both seams of the angle, the axes, and everywhere.
fn directions(rng: &mut Rng) -> Vec<[f32; 3]> {
    let mut list = Vec::new();
    let small = [0.0f32, -0.0, 1e-30, -1e-30, 1e-10, -1e-10, 1e-7, -1e-7, 1e-4, -1e-4, 1e-2, -1e-2];
    for a in small {
        for b in small {
            for one in [1.0f32, -1.0] {
                list.extend([[a, one, b], [one, a, b], [a, b, one]]);
            }
        }
    }
    list.extend((0..20_000).map(|_| f32s(rng.sphere())));
    list.into_iter().map(|d| f32s(unit(f64s(d)))).collect()
}

#[test]
fn lookup_is_the_formats() {
    let mut rng = Rng::new(1);
    let directions = directions(&mut rng);
    for (width, height) in [(1, 1), (2, 1), (1, 2), (3, 5), (8, 4), (13, 6), (256, 128), (4096, 16)] {
        let mut texels = Rng::new(2);
        let image = image(width, height, |_, _| [texels.f32(), 2.0 * texels.f32(), 0.5]);
        let lights = image_lights(&image);
        // Angles to 2 ulp of at most π, their multiples to 1: a place to (width + height)·2⁻²³; contrast below 2.
        let bound = 2.0 * f64::powi(2.0, -23) * (width + height + 4) as f64;
        for &d in &directions {
            let ours = f64s(lights.environment_radiance(vec1(d)).lane(0));
            let exact = reference_lookup(&image, f64s(d));
            for k in 0..3 {
                assert!((ours[k] - exact[k]).abs() <= bound, "{width}×{height} at {d:?}: {ours:?} for {exact:?}");
            }
        }
    }
}

#[test]
fn texel_centres_return_texels() {
    let image = noise(8, 4, 0.0, 1.0, 3);
    let lights = image_lights(&image);
    for row in 0..4 {
        for column in 0..8 {
            let (theta, phi) = (PI * (row as f64 + 0.5) / 4.0, TAU * (column as f64 + 0.5) / 8.0);
            let d = [theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()];
            let ours = lights.environment_radiance(vec1(f32s(d))).x;
            assert!((ours - image.texels[row * 8 + column][0]).abs() < 2e-5, "row {row}, column {column}");
        }
    }
    // Row 0 looks to +y; the middle of the image to +z.
    assert!(
        (lights.environment_radiance(vec1([0.0, 1.0, -0.0])).x - 0.5 * (image.texels[0][0] + image.texels[7][0])).abs()
            < 1e-6
    );
}

/// The density is finite and positive at the poles too, and continuous into them.
#[test]
fn poles_have_a_density() {
    let lights = image_lights(&noise(16, 8, 0.5, 1.5, 4));
    for y in [1.0f32, -1.0] {
        let at = lights.environment(vec1([0.0, y, -0.0])).1;
        // The pole itself lies where its zeros point, here at u = 0: approach along that.
        for eps in [1e-30f32, 1e-20, 1e-12, 1e-8, 1e-6] {
            let near = lights.environment(vec1([0.0, y, -eps])).1;
            assert!(at.is_finite() && at > 0.0 && (near / at - 1.0).abs() < 1e-5, "{at} against {near} at {eps}");
        }
    }
}

/// Dead lanes may hold anything: nothing panics, nothing of them is passed on.
#[test]
fn garbage_is_harmless() {
    let lights = image_lights(&noise(16, 8, 0.5, 1.5, 5));
    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38, -1.0] {
        for y in [f32::NAN, f32::INFINITY, 0.0, 2.0, -1.0] {
            lights.environment_radiance(vec1([x, y, 0.3]));
            lights.environment(vec1([y, x, x]));
            let dead = lights.sample::<f32>(vec1([x; 3]), x, [y, x], false);
            assert_eq!((dead.pdf, dead.radiance.lane(0)), (0.0, [0.0; 3]));
        }
    }
}
