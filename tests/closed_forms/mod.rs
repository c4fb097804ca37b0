//! Whole renders held to values known in closed form, and their variances to known variances.

mod delta_lights;
mod enclosures;
mod furnaces;
mod irradiance;
mod lens;
mod roulette;
mod shading_normals;
mod slab;
mod variance;

/// Means and variances tested in this folder, rounded up: the family of Šidák's bound. Seeds are fixed.
const TESTS: usize = 500;

/// What f32 may do to a mean over paths: 20 roundings of 2⁻²⁴ a bounce, all to one side.
fn rounding(value: f64, bounces: u32) -> f64 {
    value * 20.0 * f64::from(bounces + 1) / 16_777_216.0
}
