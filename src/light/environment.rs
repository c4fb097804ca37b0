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
    Image(ImageMap),
}

impl EnvironmentMap {
    /// `None` for a black environment.
    pub fn build(environment: &Environment) -> Option<Self> {
        match environment {
            Environment::Constant(radiance) => radiance.iter().any(|&c| c > 0.0).then_some(Self::Constant(*radiance)),
            Environment::Image(image) => ImageMap::build(image).map(Self::Image),
        }
    }

    /// Radiance arriving along the unit direction `d`.
    #[inline(always)]
    pub fn radiance<R: Real>(&self, d: Vec3<R>) -> Vec3<R> {
        match self {
            Self::Constant(radiance) => Vec3::splat(*radiance),
            Self::Image(map) => map.radiance(d),
        }
    }

    /// Radiance arriving along the unit direction `d`, and the solid-angle density with which `sample` yields it.
    #[inline(always)]
    pub fn radiance_and_pdf<R: Real>(&self, d: Vec3<R>) -> (Vec3<R>, R) {
        match self {
            Self::Constant(radiance) => (Vec3::splat(*radiance), warp::uniform_sphere_pdf()),
            Self::Image(map) => map.radiance_and_pdf(d),
        }
    }

    /// A unit direction from three numbers uniform in [0, 1), its radiance and its solid-angle density.
    #[inline(always)]
    pub fn sample<R: Real>(&self, u_choice: R, u: [R; 2]) -> (Vec3<R>, Vec3<R>, R) {
        match self {
            Self::Constant(radiance) => (warp::uniform_sphere(u), Vec3::splat(*radiance), warp::uniform_sphere_pdf()),
            Self::Image(map) => map.sample(u_choice, u),
        }
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        match self {
            Self::Constant(_) => 0,
            Self::Image(map) => map.memory(),
        }
    }
}
