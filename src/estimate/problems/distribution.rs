//! Expectations of random variables: tables and densities, sampled by inversion.

use super::UnitProblem;
use super::interval::check_range;
use crate::estimate::adaptive::integrate;
use crate::estimate::expression::Expression;
use crate::estimate::method::{Integrand, Shared};
use crate::estimate::rules::Gauss;
use crate::estimate::study::Quantity;
use crate::kernel::Width;
use std::sync::Arc;

/// How far probabilities may sum from 1: what a user's decimals lose.
const SUM_TOLERANCE: f64 = 1e-6;

/// False for a NaN.
fn is_one(sum: f64, tolerance: f64) -> bool {
    (sum - 1.0).abs() <= tolerance
}

/// Values in the order given, each with the probability of it and all before it.
struct Table(Vec<[f64; 2]>);

impl Integrand for Table {
    fn dimensions(&self) -> usize {
        1
    }
    /// By inversion: the first value whose cumulated probability exceeds u.
    fn at(&self, u: &[f64]) -> f64 {
        let found = self.0.partition_point(|[_, cumulated]| *cumulated <= u[0]);
        self.0[found.min(self.0.len() - 1)][0]
    }
}

/// E\[X\] of a table of (value, probability).
///
/// # Errors
/// The table is empty, a probability is negative, or they do not sum to 1.
pub fn discrete(name: &str, table: &[[f64; 2]], width: Width) -> Result<UnitProblem, String> {
    if let Some(row) = table.iter().find(|row| !row[0].is_finite() || !(0.0..=f64::MAX).contains(&row[1])) {
        return Err(format!("{}:{} in the table; values are finite, probabilities 0 or more", row[0], row[1]));
    }
    let sum: f64 = table.iter().map(|row| row[1]).sum();
    if !is_one(sum, SUM_TOLERANCE) {
        return Err(format!("the probabilities sum to {sum}; make them sum to 1"));
    }
    let mean = table.iter().map(|row| row[0] * row[1]).sum::<f64>() / sum;
    let variance = table.iter().map(|row| (row[0] - mean).powi(2) * row[1]).sum::<f64>() / sum;
    let mut below = 0.0;
    let cumulated = table.iter().filter(|row| row[1] > 0.0).map(|row| {
        below += row[1] / sum;
        [row[0], below]
    });
    let cumulated: Vec<[f64; 2]> = cumulated.collect();
    let formula = format!("E[X] of {} values", table.len());
    let quantity = Quantity { name: name.into(), formula, exact: mean, exact_error: 0.0, source: "Σ x p".into() };
    Ok(expectation(quantity, Arc::new(Table(cumulated)), variance, mean + variance.sqrt(), width))
}

fn expectation(quantity: Quantity, integrand: Shared, variance: f64, clamp: f64, width: Width) -> UnitProblem {
    UnitProblem {
        quantity,
        integrand,
        variance,
        importance: None,
        optimal_variance: None,
        control: None,
        clamp,
        rules: false,
        width,
    }
}

/// A density on an interval and its cumulative distribution.
pub struct Density {
    p: Expression,
    /// Ends of panels and the probability below each.
    cumulated: Vec<[f64; 2]>,
    gauss: Gauss,
}

const PANELS: usize = 256;

impl Density {
    /// # Errors
    /// p has no value or is negative somewhere, or does not integrate to 1: the integral found is named.
    pub fn new(p: Expression, range: [f64; 2]) -> Result<Self, String> {
        check_range(range)?;
        let gauss = Gauss::new(16);
        let edge = |i: usize| range[0] + (range[1] - range[0]) * i as f64 / PANELS as f64;
        let mut cumulated = vec![[range[0], 0.0]];
        let mut below = 0.0;
        for i in 0..PANELS {
            let mut worst = f64::INFINITY;
            let mut lowest = |x: f64| {
                let value = p.at(x);
                // A NaN is as bad as it gets.
                worst = if value.is_nan() { f64::NEG_INFINITY } else { worst.min(value) };
                value
            };
            below += gauss.integrate([edge(i), edge(i + 1)], 1, &mut lowest);
            lowest(edge(i));
            if worst < 0.0 {
                return Err(format!(
                    "{:?} is negative or has no value near x = {}; a density is 0 or more",
                    p.text(),
                    edge(i)
                ));
            }
            cumulated.push([edge(i + 1), below]);
        }
        let (total, error) = integrate(|x| p.at(x), range);
        if !is_one(total, SUM_TOLERANCE.max(error)) {
            return Err(format!(
                "{:?} integrates to {total} over [{}, {}]; a density integrates to 1",
                p.text(),
                range[0],
                range[1]
            ));
        }
        cumulated.iter_mut().for_each(|entry| entry[1] /= below);
        Ok(Self { p, cumulated, gauss })
    }

    pub fn at(&self, x: f64) -> f64 {
        self.p.at(x)
    }

    /// The x below which a fraction `u` lies: a panel by search, in it by bisection and Newton steps on the integral.
    pub fn inverse_cdf(&self, u: f64) -> f64 {
        let panel = self.cumulated.partition_point(|entry| entry[1] <= u).clamp(1, PANELS);
        let [[start, below], [end, above]] = [self.cumulated[panel - 1], self.cumulated[panel]];
        let (mut low, mut high) = (start, end);
        let mut x = if above > below { start + (end - start) * (u - below) / (above - below) } else { start };
        for _ in 0..60 {
            let excess = below + self.gauss.integrate([start, x], 1, |x| self.p.at(x)) - u;
            if excess > 0.0 {
                high = x
            } else {
                low = x
            }
            let newton = x - excess / self.p.at(x);
            // False for a NaN: p may vanish.
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - x).abs() <= 4e-16 * x.abs().max(end - start) {
                return next;
            }
            x = next;
        }
        x
    }
}

/// f(X), or 1 where X is in an interval, X by inversion.
struct OfDensity {
    density: Arc<Density>,
    f: Wanted,
}

/// What is wanted of a random variable.
pub enum Wanted {
    Expectation(Expression),
    Probability([f64; 2]),
}

impl Wanted {
    fn at(&self, x: f64) -> f64 {
        match self {
            Wanted::Expectation(f) => f.at(x),
            Wanted::Probability([a, b]) => f64::from(u8::from(x >= *a && x <= *b)),
        }
    }
}

impl Integrand for OfDensity {
    fn dimensions(&self) -> usize {
        1
    }
    fn at(&self, u: &[f64]) -> f64 {
        self.f.at(self.density.inverse_cdf(u[0]))
    }
}

/// E[f(X)] or Pr(X ∈ [a, b]) of a variable with the density `p` on `range`.
///
/// # Errors
/// `p` is no density, or f has no finite expectation.
pub fn continuous(p: &str, range: [f64; 2], f: Wanted, width: Width) -> Result<UnitProblem, String> {
    let density = Density::new(Expression::parse(p)?, range)?;
    let cut = match &f {
        Wanted::Probability([a, b]) => {
            check_range([*a, *b])?;
            [a.max(range[0]), b.min(range[1])]
        }
        Wanted::Expectation(_) => range,
    };
    let moment = |k: i32| integrate(|x| f.at(x).powi(k) * density.at(x), cut);
    let (mean, error) = if cut[0] < cut[1] { moment(1) } else { (0.0, 0.0) };
    let variance = if cut[0] < cut[1] { moment(2).0 - mean * mean } else { 0.0 };
    if !mean.is_finite() {
        return Err(format!("f has no finite expectation under {p:?}; choose another f"));
    }
    let formula = match &f {
        Wanted::Expectation(f) => format!("E[{}], X with density {p} on [{}, {}]", f.text(), range[0], range[1]),
        Wanted::Probability([a, b]) => {
            format!("Pr(X in [{a}, {b}]), X with density {p} on [{}, {}]", range[0], range[1])
        }
    };
    // The table that samples is exact to the tolerance of its total.
    let exact_error = error + 1e-12 * mean.abs();
    let source = "adaptive Gauss quadrature".to_owned();
    let quantity = Quantity { name: "continuous".into(), formula, exact: mean, exact_error, source };
    let integrand = OfDensity { density: Arc::new(density), f };
    Ok(expectation(quantity, Arc::new(integrand), variance, mean + variance.max(0.0).sqrt(), width))
}
