//! Light from outside.

use super::vec3::V3;
use octolux::scene::{Environment, EnvironmentImage, Scene};
use std::f64::consts::{PI, TAU};

/// Radiance arriving from where the unit vector `dir` points; 0 without an environment.
pub fn environment_radiance(scene: &Scene, dir: [f64; 3]) -> [f64; 3] {
    match &scene.environment {
        None => [0.0; 3],
        Some(Environment::Constant(radiance)) => radiance.map(f64::from),
        Some(Environment::Image(image)) => lookup(image, dir),
    }
}

fn lookup(image: &EnvironmentImage, [x, y, z]: [f64; 3]) -> [f64; 3] {
    // Turned counter-clockwise as seen from above, the image is looked up further to the right.
    let u = (x.atan2(-z) / TAU + f64::from(image.rotation) / 360.0).rem_euclid(1.0);
    let v = y.clamp(-1.0, 1.0).acos() / PI;
    // Texel i's centre is at i + ½.
    let (column, row) = (u * image.width as f64 - 0.5, v * image.height as f64 - 0.5);
    let (s, t) = (column - column.floor(), row - row.floor());
    let texel = |i: i64, j: i64| {
        let i = (column.floor() as i64 + i).rem_euclid(image.width as i64);
        let j = (row.floor() as i64 + j).clamp(0, image.height as i64 - 1);
        V3::of(image.texels[j as usize * image.width + i as usize])
    };
    let upper = texel(0, 0) * (1.0 - s) + texel(1, 0) * s;
    let lower = texel(0, 1) * (1.0 - s) + texel(1, 1) * s;
    (upper * (1.0 - t) + lower * t).0
}
