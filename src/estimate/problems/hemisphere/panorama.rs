//! An environment image over the hemisphere: what a point under it, facing up, receives.

use crate::lane::{Real, Vec3};
use crate::light::EnvironmentMap;
use crate::scene::{Environment, EnvironmentImage};
use std::f64::consts::{PI, TAU};
use std::fmt;

/// Radiance is the mean of the channels; +y of the image is up, and is the normal.
pub struct Panorama {
    map: EnvironmentMap,
    size: [usize; 2],
    exact: f64,
    exact_error: f64,
}

impl Panorama {
    /// # Errors
    /// The image is black.
    pub fn new(image: &EnvironmentImage) -> Result<Self, String> {
        let map = EnvironmentMap::build(&Environment::Image(image.clone()));
        let map = map.ok_or("the image is black: its integral is 0; give another")?;
        let mut panorama = Self { map, size: [image.width, image.height], exact: 0.0, exact_error: 0.0 };
        // Bilinear between texels: the error of the midpoint rule falls with the square of the step.
        let (coarse, fine) = (panorama.irradiance(1024), panorama.irradiance(2048));
        (panorama.exact, panorama.exact_error) = (fine, (fine - coarse).abs());
        if fine > 0.0 { Ok(panorama) } else { Err("the image is black above the horizon; give another".into()) }
    }

    /// The midpoint rule in sin²θ and φ.
    fn irradiance(&self, side: usize) -> f64 {
        let cell = |i: usize, j: usize| {
            let (u, phi) = ((i as f64 + 0.5) / side as f64, (j as f64 + 0.5) / side as f64 * TAU);
            let (sin, cos) = (u.sqrt(), (1.0 - u).sqrt());
            self.radiance([sin * phi.cos(), sin * phi.sin(), cos])
        };
        let row = |i: usize| (0..side).map(|j| cell(i, j)).sum::<f64>();
        PI * (0..side).map(row).sum::<f64>() / (side * side) as f64
    }

    pub fn radiance(&self, [x, y, z]: [f64; 3]) -> f64 {
        f64::from(self.radiance_lanes(Vec3::new(x as f32, y as f32, z as f32)))
    }

    /// In lanes.
    #[inline(always)]
    pub fn radiance_lanes<R: Real>(&self, w: Vec3<R>) -> R {
        let light = self.map.radiance(Vec3::new(w.x, w.z, -w.y));
        (light.x + light.y + light.z) * R::splat(1.0 / 3.0)
    }

    /// ∫ L cosθ, and how far that may be off.
    pub fn exact(&self) -> [f64; 2] {
        [self.exact, self.exact_error]
    }
}

impl fmt::Debug for Panorama {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "an image of {} x {} texels", self.size[0], self.size[1])
    }
}
