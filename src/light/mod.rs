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
mod emitter;
mod environment;
mod expected;
mod grid;
mod image;
mod inversion;
mod lights;
mod pairs;
mod reach;
mod row;
mod sample;
mod slope;
mod sphere;
mod triangle;

pub use delta::Extent;
pub use emitter::{Emitter, EmitterShape};
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
