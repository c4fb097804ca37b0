//! Light from infinitely far away, by direction.

use super::image::ImageMap;
use crate::lane::{Real, Vec3};
use crate::sampling::warp;
use crate::scene::Environment;

/// The environment prepared for look-ups and sampling. Pdfs here do not yet include the choice between environment
/// and area lights.
pub enum EnvironmentMap {
    /// The same radiance from everywhere: sampled uniformly over the sphere, nothing tabulated.
    Constant([f32; 3]),
    /// By an image.
    Image(ImageMap),
    /// An image, turned about +y.
    Turned(ImageMap, Turn),
}

/// What directions to an environment's image are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkySamples {
    /// An estimate of their own: in proportion to radiance.
    Alone,
    /// One beside directions from a BSDF that reach all that it scatters, weighted by multiple importance sampling. These
    /// find an even sky well enough: so in proportion to what radiance exceeds its mean by, and nowhere else (Karlík,
    /// Šik, Vévoda, Skřivan, Křivánek 2019, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance
    /// Sampling", §4, for as many light samples as BSDF samples).
    Compensated,
}

/// A rotation about +y, counter-clockwise seen from above.
#[derive(Clone, Copy)]
pub struct Turn {
    sin: f32,
    cos: f32,
}

impl Turn {
    fn new(degrees: f32) -> Self {
        let (sin, cos) = (f64::from(degrees) % 360.0).to_radians().sin_cos();
        Self { sin: sin as f32, cos: cos as f32 }
    }

    #[inline(always)]
    fn apply<R: Real>(self, d: Vec3<R>) -> Vec3<R> {
        let (sin, cos) = (R::splat(self.sin), R::splat(self.cos));
        Vec3::new(d.x.mul_add(cos, d.z * sin), d.y, d.x.neg_mul_add(sin, d.z * cos))
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        Self { sin: -self.sin, ..self }
    }
}

impl EnvironmentMap {
    /// `None` for a black environment. Its samples stand alone.
    pub fn build(environment: &Environment) -> Option<Self> {
        Self::sampled(environment, SkySamples::Alone)
    }

    /// The same for a purpose.
    pub fn sampled(environment: &Environment, samples: SkySamples) -> Option<Self> {
        match environment {
            Environment::Constant(radiance) => radiance.iter().any(|&c| c > 0.0).then_some(Self::Constant(*radiance)),
            Environment::Image(image) if image.rotation % 360.0 == 0.0 => {
                ImageMap::build(image, samples).map(Self::Image)
            }
            Environment::Image(image) => {
                ImageMap::build(image, samples).map(|map| Self::Turned(map, Turn::new(image.rotation)))
            }
        }
    }

    /// Radiance arriving along the unit direction `d`.
    #[inline(always)]
    pub fn radiance<R: Real>(&self, d: Vec3<R>) -> Vec3<R> {
        match self {
            Self::Constant(radiance) => Vec3::splat(*radiance),
            Self::Image(map) => map.radiance(d),
            Self::Turned(map, turn) => map.radiance(turn.inverse().apply(d)),
        }
    }

    /// Radiance arriving along the unit direction `d`, and the solid-angle density with which `sample` yields it.
    #[inline(always)]
    pub fn radiance_and_pdf<R: Real>(&self, d: Vec3<R>) -> (Vec3<R>, R) {
        match self {
            Self::Constant(radiance) => (Vec3::splat(*radiance), warp::uniform_sphere_pdf()),
            Self::Image(map) => map.radiance_and_pdf(d),
            Self::Turned(map, turn) => map.radiance_and_pdf(turn.inverse().apply(d)),
        }
    }

    /// A unit direction from two numbers uniform in [0, 1), its radiance and its solid-angle density.
    #[inline(always)]
    pub fn sample<R: Real>(&self, u: [R; 2]) -> (Vec3<R>, Vec3<R>, R) {
        match self {
            Self::Constant(radiance) => (warp::uniform_sphere(u), Vec3::splat(*radiance), warp::uniform_sphere_pdf()),
            Self::Image(map) => map.sample(u),
            Self::Turned(map, turn) => {
                let (d, radiance, pdf) = map.sample(u);
                (turn.apply(d), radiance, pdf)
            }
        }
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        match self {
            Self::Constant(_) => 0,
            Self::Image(map) | Self::Turned(map, _) => map.memory(),
        }
    }
}
