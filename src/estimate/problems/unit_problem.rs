//! A problem posed on the unit cube: a mean of a function of uniform numbers.

use super::{Problem, unknown_method};
use crate::estimate::biased::{clamped, pilot_reuse, ratio};
use crate::estimate::bmc::line;
use crate::estimate::method::{Integrand, Method, Shared, mean_over};
use crate::estimate::points::Points;
use crate::estimate::study::Quantity;
use crate::estimate::tensor::{Rule, product};
use crate::kernel::Width;

/// The mean of `integrand` over the unit cube, by whatever can estimate it.
pub struct UnitProblem {
    pub quantity: Quantity,
    pub integrand: Shared,
    /// Of one sample with uniform points; NaN where it is not known, infinite where it is.
    pub variance: f64,
    /// An importance-sampled form of the same integral and its variance a sample.
    pub importance: Option<(Shared, f64)>,
    /// Variance a sample of the best density, p* ∝ |f|.
    pub optimal_variance: Option<f64>,
    /// A function with a known mean for the ratio estimator.
    pub control: Option<(Shared, f64)>,
    /// What `clamped` cuts samples to.
    pub clamp: f64,
    /// Is a quadrature rule of any sense here?
    pub rules: bool,
    pub width: Width,
}

impl UnitProblem {
    fn points(&self) -> impl Iterator<Item = Points> + '_ {
        Points::ALL.into_iter().filter(|p| p.plan(1, self.integrand.dimensions()).is_some())
    }

    fn monte_carlo(&self, name: &str, points: Points, integrand: &Shared, variance: f64) -> Method {
        let method = mean_over(name, points, integrand.clone(), self.width);
        if variance.is_nan() {
            return method;
        }
        match points {
            Points::Independent => method.with_variance(move |n| variance / n as f64),
            Points::Stratified if integrand.dimensions() == 1 => {
                let integrand = integrand.clone();
                method.with_variance(move |n| stratified_variance(&*integrand, n))
            }
            _ => method,
        }
    }
}

/// (1/n²) Σ over strata of the variance within, by Gauss quadrature of each. NaN, no prediction, where twice the nodes
/// find another value: at jumps.
fn stratified_variance(integrand: &dyn Integrand, n: usize) -> f64 {
    let with = |nodes: usize| {
        let Some(nodes) = Rule::Gauss.nodes(nodes) else { return f64::NAN };
        let stratum = |j: usize| {
            let value = |x: f64| integrand.at(&[(j as f64 + x) / n as f64]);
            let mean: f64 = nodes.iter().map(|&[x, w]| w * value(x)).sum();
            nodes.iter().map(|&[x, w]| w * (value(x) - mean).powi(2)).sum::<f64>()
        };
        (0..n).map(stratum).sum::<f64>() / (n as f64).powi(2)
    };
    let (coarse, fine) = (with(8), with(16));
    if (coarse - fine).abs() <= 1e-6 * fine { fine } else { f64::NAN }
}

impl Problem for UnitProblem {
    fn quantity(&self) -> Quantity {
        self.quantity.clone()
    }

    fn method_names(&self) -> (Vec<String>, usize) {
        let mut names: Vec<String> = self.points().map(|p| p.name().to_owned()).collect();
        if self.importance.is_some() {
            names.insert(1, "mc-is".into());
        }
        if self.rules {
            names.extend(Rule::ALL.map(|r| r.name().to_owned()));
        }
        let defaults = names.len();
        if self.rules && self.integrand.dimensions() == 1 {
            names.extend(["bmc", "bmc-se"].map(String::from));
        }
        names.extend(["clamped", "pilot-reuse"].map(String::from));
        if self.control.is_some() {
            names.push("ratio".into());
        }
        (names, defaults)
    }

    fn method(&self, name: &str) -> Result<Method, String> {
        let integrand = &self.integrand;
        if !self.method_names().0.iter().any(|known| known == name) {
            return Err(unknown_method(self, name));
        }
        if let Some(points) = Points::ALL.into_iter().find(|p| p.name() == name) {
            return Ok(self.monte_carlo(name, points, integrand, self.variance));
        }
        if let Some(rule) = Rule::ALL.into_iter().find(|r| r.name() == name) {
            return Ok(product(rule, integrand.clone()));
        }
        match (name, &self.importance, &self.control) {
            ("mc-is", Some((form, variance)), _) => Ok(self.monte_carlo(name, Points::Independent, form, *variance)),
            ("ratio", _, Some((control, mean))) => Ok(ratio(integrand.clone(), control.clone(), *mean, self.width)),
            ("clamped", ..) => Ok(clamped(integrand.clone(), self.clamp, self.width)),
            ("pilot-reuse", ..) => Ok(pilot_reuse(integrand.clone(), self.width)),
            ("bmc", ..) => Ok(line::bmc(name, line::Covariance::Sobolev, integrand.clone())),
            ("bmc-se", ..) => {
                Ok(line::bmc(name, line::Covariance::SquaredExponential { length: 0.3 }, integrand.clone()))
            }
            _ => Err(unknown_method(self, name)),
        }
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!("variance of one uniform sample, ∫f²/p − I² = {:.8}", self.variance)];
        if let Some((_, variance)) = &self.importance {
            notes.push(format!("of one sample of the given density: {variance:.8}"));
        }
        if let Some(best) = self.optimal_variance {
            notes.push(format!("of the best density, p* ∝ |f|: {best:.8}"));
        }
        notes
    }
}
