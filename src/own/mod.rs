//! What a program adds to a scene of its own: a [`Bsdf`], a [`Light`], random [`Numbers`], or a whole [`Integrand`].
//!
//! Each is written once, generic over the lane type [`Real`](crate::lane::Real), and is compiled into the path estimator
//! (the integrand: into the same passes over tiles and samples) in the program that has it. So it gets the same
//! random numbers and the same [`Film`](crate::film::Film), and its images the same bits at 1, 8 or 16 lanes, any number
//! of threads and any tile, as long as it keeps to lane arithmetic: [`lane::math`](crate::lane::math) in place of the
//! library's `sin` or `exp`, and no sums across lanes.
//!
//! [`check::DirectionTest`](crate::check::DirectionTest) tells whether what it samples follows the pdf that it claims.
//!
//! Directions are unit and, of a BSDF, in the local frame with z = n; positions are in the scene's unit. Light is followed
//! from the camera: a BSDF need not be symmetric for the estimate to be what its `eval` says.

mod bsdf;
mod integrand;
mod light;
mod numbers;
mod shading;

pub use bsdf::Bsdf;
pub use integrand::{CameraSample, Integrand};
pub use light::{Arrival, Light};
pub use numbers::Numbers;
pub use shading::{Nothing, Own};

pub(crate) use integrand::integrate;
