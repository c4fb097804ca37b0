//! An independent eye: a brute-force path tracer in f64 that shares no code with `src`, only the scene's data types.
//!
//! From a sibling test module: `use crate::oracle;`, then for instance
//!
//! ```ignore
//! let image = oracle::render(&scene, oracle::Region::whole(&scene), 256, 1); // mean and variance a pixel
//! let hit = oracle::closest_hit(&scene, origin, direction);                 // t, prim, u, v
//! let f_cos = oracle::bsdf_eval(&bsdf, wo, wi);                             // f·|cosθi|, local frame, z = n
//! let albedo = oracle::directional_albedo(&bsdf, wo);                       // by quadrature
//! ```
//!
//! Its strategies are plain on purpose: half vectors from the normal distribution (not the visible one), light points
//! uniform by area or none at all, no weighting of strategies against each other, no roulette, t_min instead of offsets.

#![allow(dead_code, unused_imports)] // a tool box: not every helper has a user at every commit

mod bsdf;
mod camera;
mod environment;
mod fresnel;
mod geometry;
mod ggx;
mod image;
mod light;
mod path;
mod reference;
mod scenes;
mod tests_bsdf;
mod tests_geometry;
mod tests_light;
mod tests_path;
mod tests_reference;
mod vec3;

pub use bsdf::{Albedo, bsdf_eval, directional_albedo};
pub use camera::camera_ray;
pub use environment::environment_radiance;
pub use fresnel::{fresnel_conductor, fresnel_dielectric, fresnel_schlick};
pub use geometry::{Geometry, Hit, closest_hit};
pub use image::{Estimate, Image, Region};
pub use path::{Direct, Renderer, render};
pub use reference::{read_image, read_scene};
pub use scenes::{LAMBERT, SceneBuilder};
pub use tests_path::tilted_lambert;
