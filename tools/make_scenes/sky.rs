//! A clear sky with the sun: the CIE standard general sky's luminance, coloured by hand.
//!
//! CIE S 011/E:2003 (Darula & Kittler 2002), type 12 "CIE standard clear sky, low illuminance turbidity": relative
//! luminance φ(Z) f(χ) of zenith distance Z and distance χ from the sun. Units are arbitrary: the sky gives a
//! horizontal plane an irradiance near 1, the sun five times that.

use exr::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

const WIDTH: usize = 256;
const HEIGHT: usize = 128;
/// Samples along each side of a texel: the sun's rim is finer than texels are.
const SUPERSAMPLING: usize = 8;

const SUN_ELEVATION: f64 = 38.0 * PI / 180.0;
const SUN_AZIMUTH: f64 = 300.0 * PI / 180.0;
/// Nine times the true radius: it must cover some texels.
const SUN_RADIUS: f64 = 2.4 * PI / 180.0;
const SUN_COLOUR: [f64; 3] = [1.0, 0.92, 0.78];
/// Irradiance of the sun on a plane facing it, over that of the sky on a horizontal one.
const SUN_TO_SKY: f64 = 6.0;

const HORIZON_COLOUR: [f64; 3] = [0.82, 0.92, 1.0];
const ZENITH_COLOUR: [f64; 3] = [0.28, 0.52, 1.0];
const GROUND: [f64; 3] = [0.13, 0.12, 0.10];

/// Parameters of sky type 12.
const A: f64 = -1.0;
const B: f64 = -0.32;
const C: f64 = 10.0;
const D: f64 = -3.0;
const E: f64 = 0.45;

/// With the sun.
pub fn write(path: &Path) -> Result<()> {
    write_texels(path, &scaled_sky(true))
}

/// The sky and the ground alone: smooth but at the horizon.
pub fn write_without_sun(path: &Path) -> Result<()> {
    write_texels(path, &scaled_sky(false))
}

fn write_texels(path: &Path, sky: &[[f64; 3]]) -> Result<()> {
    let texel = |position: Vec2<usize>| {
        let [r, g, b] = sky[position.y() * WIDTH + position.x()].map(f16::from_f64);
        (r, g, b)
    };
    let channels = SpecificChannels::rgb(texel);
    let encoding = Encoding::SMALL_LOSSLESS;
    let layer = Layer::new((WIDTH, HEIGHT), LayerAttributes::named("sky"), encoding, channels);
    Image::from_layer(layer).write().to_file(path)
}

/// Sky and ground with the sky's horizontal irradiance brought to 1, and the sun added if wanted.
fn scaled_sky(with_sun: bool) -> Vec<[f64; 3]> {
    let sky = texels(|w| if w[1] > 0.0 { clear_sky(w) } else { [0.0; 3] });
    let irradiance: f64 = (0..HEIGHT / 2)
        .flat_map(|row| (0..WIDTH).map(move |column| (row, column)))
        .map(|(row, column)| {
            let theta = (row as f64 + 0.5) / HEIGHT as f64 * PI;
            let solid_angle = theta.sin() * (PI / HEIGHT as f64) * (TAU / WIDTH as f64);
            luminance(sky[row * WIDTH + column]) * theta.cos() * solid_angle
        })
        .sum();
    let sun_radiance = if with_sun { SUN_TO_SKY / (PI * SUN_RADIUS.sin().powi(2)) } else { 0.0 };
    let sun = texels(|w| if angle_to_sun(w) < SUN_RADIUS { SUN_COLOUR.map(|c| c * sun_radiance) } else { [0.0; 3] });
    let ground = texels(|w| if w[1] > 0.0 { [0.0; 3] } else { GROUND });
    (0..WIDTH * HEIGHT).map(|i| std::array::from_fn(|c| sky[i][c] / irradiance + sun[i][c] + ground[i][c])).collect()
}

/// Means over texels. Row 0 looks to +y; u = atan2(x, −z)/2π.
fn texels(radiance: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
    let mean = |row: usize, column: usize| {
        let mut sum = [0.0; 3];
        for i in 0..SUPERSAMPLING * SUPERSAMPLING {
            let inside = |k: usize| (k as f64 + 0.5) / SUPERSAMPLING as f64;
            let theta = (row as f64 + inside(i / SUPERSAMPLING)) / HEIGHT as f64 * PI;
            let phi = (column as f64 + inside(i % SUPERSAMPLING)) / WIDTH as f64 * TAU;
            let value = radiance([theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()]);
            sum = std::array::from_fn(|c| sum[c] + value[c]);
        }
        sum.map(|x| x / (SUPERSAMPLING * SUPERSAMPLING) as f64)
    };
    (0..HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| (row, column))).map(|(r, c)| mean(r, c)).collect()
}

fn clear_sky(w: [f64; 3]) -> [f64; 3] {
    let chi = angle_to_sun(w);
    let gradation = 1.0 + A * (B / w[1]).exp();
    let indicatrix = 1.0 + C * ((D * chi).exp() - (D * FRAC_PI_2).exp()) + E * chi.cos().powi(2);
    // Whiter where the air is thick or the sun near.
    let white = (1.0 - w[1]).powi(3).max((-4.0 * chi).exp());
    std::array::from_fn(|c| gradation * indicatrix * (ZENITH_COLOUR[c] * (1.0 - white) + HORIZON_COLOUR[c] * white))
}

fn angle_to_sun(w: [f64; 3]) -> f64 {
    let horizontal = SUN_ELEVATION.cos();
    let sun = [horizontal * SUN_AZIMUTH.sin(), SUN_ELEVATION.sin(), -horizontal * SUN_AZIMUTH.cos()];
    (w[0] * sun[0] + w[1] * sun[1] + w[2] * sun[2]).clamp(-1.0, 1.0).acos()
}

/// Rec. 709.
fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}
