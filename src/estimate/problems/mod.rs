//! Problems with known answers.

mod cube;
mod distribution;
mod hemisphere;
mod illumination;
mod interval;
mod unit_problem;

pub use cube::{CUBE_FUNCTIONS, cube, pi};
pub use distribution::{Wanted, continuous, discrete};
pub use hemisphere::{
    Density, Field, HEMISPHERE_FUNCTIONS, Hemisphere, Learned, Lobe, Panorama, Sky, hemisphere, hemisphere_of_image,
    integrate,
};
pub use illumination::{Illumination, illumination};
pub use interval::{INTERVAL_FUNCTIONS, interval, interval_expression};
pub use unit_problem::UnitProblem;

use super::method::Method;
use super::study::Quantity;

/// A quantity and the methods that estimate it.
pub trait Problem: Sync {
    fn quantity(&self) -> Quantity;
    /// Names of methods, the defaults first; those after the number given must be asked for.
    fn method_names(&self) -> (Vec<String>, usize);
    /// # Errors
    /// There is no such method; says which there are.
    fn method(&self, name: &str) -> Result<Method, String>;
    /// Said beside the results.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

pub(super) fn unknown_method(problem: &dyn Problem, name: &str) -> String {
    format!("no method {name:?} for this problem; there are {}", problem.method_names().0.join(", "))
}
