//! Lights: how one is chosen, how a point or direction on it is sampled, and with which density.
//!
//! Everything is in the kernel's own units: scene, lights and rays already rescaled. What a scene lacks is not built:
//! no table for a single light, none for a constant environment, nothing at all where nothing emits. Lights without extent
//! ([`DeltaLight`](crate::scene::DeltaLight)) are sampled beside the others, and found by nothing else.
//!
//! [`Lights`] answers two questions, and the answers agree: [`Lights::sample`] (next-event estimation), and with which
//! density it would have produced a hit that BSDF sampling found ([`triangle_pdf`], [`sphere_pdf`],
//! [`Lights::environment`]).

mod alias;
mod area;
mod by_power;
mod delta;
mod density;
mod environment;
mod expected;
mod grid;
mod image;
mod inversion;
mod lights;
mod pairs;
mod reach;
mod sample;
mod sphere;
mod triangle;

pub use delta::Extent;
pub use environment::{EnvironmentMap, SkySamples};
pub use grid::{MANY_LIGHTS, Receivers};
pub use lights::{ENVIRONMENT_PROBABILITY, Lights};
pub use reach::{FEW_EMITTERS, Reach};
pub use sample::{DELTA_LIGHT, LightSample, NO_PRIMITIVE};
pub use sphere::sphere_pdf;
pub use triangle::triangle_pdf;

use thiserror::Error;

/// Lights cannot be tabulated.
#[derive(Debug, Error, PartialEq, Eq)]
#[allow(missing_docs)] // fields: as the variant says
pub enum LightError {
    #[error("{count} lights; a light table holds {most}. Make fewer of them shine")]
    TooMany { count: usize, most: usize },
    /// An intensity is out of range.
    #[error("the intensity of a light leaves single precision at the scale of this scene. Use other units of length")]
    Overflow,
}

/// A primitive that emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Triangles in file order, then spheres.
    pub primitive: u32,
    /// In the kernel's unit.
    pub shape: EmitterShape,
    /// Linear RGB, finite and ≥ 0.
    pub radiance: [f32; 3],
}

/// Where an emitter is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // fields: as the variant says
pub enum EmitterShape {
    /// Emits from its counter-clockwise side, where `e1` × `e2` points.
    Triangle { p0: [f32; 3], e1: [f32; 3], e2: [f32; 3] },
    /// Emits outwards.
    Sphere { center: [f32; 3], radius: f32 },
}
