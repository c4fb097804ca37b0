//! octolux: a CPU Monte Carlo renderer kernel for the illumination integral
//!
//! ```text
//! L_r(ωo) = ∫ L_i(ωi) f_r(ωi, ωo) cosθi dωi  ≈  1/N Σ L_i f_r cosθ / p(ωi)
//! ```
//!
//! Data flows one way, and the rooms are named for where it is:
//!
//! | room | holds |
//! |---|---|
//! | [`scene`] | what the user writes: scene files, OBJ/MTL, validated into a [`scene::Scene`] |
//! | [`plan`] | what this scene needs, and what is left out |
//! | [`geometry`], [`accel`] | primitives in lanes; the 8-wide tree and its traversal |
//! | [`sampling`], [`bsdf`], [`light`] | random numbers, warps, scattering and emission, each with its pdf |
//! | [`kernel`] | the estimators of the integral over lanes: the only hot part |
//! | [`film`] | f64 accumulation, variance, EXR and PNG |
//! | [`render`] | budgets, passes, threads: scene in, film out |
//! | [`own`] | a BSDF, light, sampler or integrand of a program's own |
//! | [`student`] | the interval of a mean of few values |
//! | [`report`] | comparison, benchmarks, error against run time; plots and pages |
//! | [`estimate`] | the estimators on their own, and the weights of Bayesian Monte Carlo |
//! | [`lane`] | the arithmetic under all of it: one source for widths 1, 8 and 16 |
//!
//! Conventions: right-handed world; `wo` points to the viewer, `wi` is sampled; local frames have z = n; pdfs are in
//! solid angle unless their name ends in `_area`; radiance is linear RGB in W·sr⁻¹·m⁻².

#![warn(missing_docs)]

#[allow(missing_docs)] // under the kernel: public for tests and benchmarks
pub mod accel;
pub mod bsdf;
pub mod check;
#[allow(missing_docs)] // the program, not the library
pub mod cli;
pub mod cpu;
#[allow(missing_docs)] // fields are keys of reports, and say themselves
pub mod estimate;
pub mod film;
#[allow(missing_docs)] // under the kernel: public for tests and benchmarks
pub mod geometry;
#[doc(hidden)]
pub mod huge_pages;
pub mod kernel;
pub mod lane;
pub mod light;
pub mod own;
pub mod plan;
pub mod process;
pub mod render;
mod renderer;
#[allow(missing_docs)] // fields are keys of reports, and say themselves
pub mod report;
pub mod sampling;
pub mod scene;
pub mod student;

pub use renderer::{RenderError, Renderer};
