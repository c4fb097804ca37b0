//! Lights: each sampler against its density, against closed forms, and at every width the same.

mod area;
mod choice;
mod compensation;
mod delta;
mod environment;
mod grid;
mod image;
mod irradiance;
mod pairs;
mod reach;
mod scenes;
mod slope;
mod sphere;
mod widths;

/// Statistical tests in this folder, for Šidák's bound. A generous count only widens the bound a little.
const TESTS: usize = 96;
