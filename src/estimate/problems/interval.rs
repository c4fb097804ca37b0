//! ∫ f over an interval.

use super::UnitProblem;
use super::distribution::Density;
use crate::estimate::adaptive::integrate;
use crate::estimate::expression::Expression;
use crate::estimate::method::{Integrand, Shared};
use crate::estimate::study::Quantity;
use crate::kernel::Width;
use std::sync::Arc;

/// Functions with an antiderivative: name, expression, F.
type Known = (&'static str, &'static str, fn(f64) -> f64);

const KNOWN: [Known; 6] = [
    ("exp", "exp(x)", |x| x.exp()),
    ("linear", "x", |x| 0.5 * x * x),
    ("square", "x^2", |x| x * x * x / 3.0),
    ("sine", "sin(PI*x)", |x| -(std::f64::consts::PI * x).cos() / std::f64::consts::PI),
    ("witch", "1/(1+25*x^2)", |x| (5.0 * x).atan() / 5.0),
    // x below 1/3 counts 1, above it 0: a jump.
    ("step", "(signum(1/3-x)+1)/2", |x| x.min(1.0 / 3.0)),
];

/// The names that [`interval`] knows.
pub const INTERVAL_FUNCTIONS: [&str; 6] = [KNOWN[0].0, KNOWN[1].0, KNOWN[2].0, KNOWN[3].0, KNOWN[4].0, KNOWN[5].0];

/// The expression behind a name; any other text is its own.
pub fn interval_expression(name: &str) -> &str {
    KNOWN.iter().find(|k| k.0 == name).map_or(name, |k| k.1)
}

/// f at a point of the interval, times the length.
struct Uniform {
    f: Arc<Expression>,
    range: [f64; 2],
}

impl Integrand for Uniform {
    fn dimensions(&self) -> usize {
        1
    }
    fn at(&self, x: &[f64]) -> f64 {
        let length = self.range[1] - self.range[0];
        length * self.f.at(self.range[0] + length * x[0])
    }
}

/// f/p at points distributed as p.
struct Importance {
    f: Arc<Expression>,
    density: Density,
}

impl Integrand for Importance {
    fn dimensions(&self) -> usize {
        1
    }
    fn at(&self, u: &[f64]) -> f64 {
        let x = self.density.inverse_cdf(u[0]);
        self.f.at(x) / self.density.at(x)
    }
}

/// Of an exact value, relative to ∫ |f|.
const MOST_ERROR: f64 = 1e-3;

/// ∫ f over `range`: `function` is a name of [`INTERVAL_FUNCTIONS`] or an expression in x; `density` an expression for
/// what importance sampling draws from.
///
/// # Errors
/// Something is no expression, the range is none, f has no value somewhere in it, or the density is none.
pub fn interval(function: &str, range: [f64; 2], density: Option<&str>, width: Width) -> Result<UnitProblem, String> {
    check_range(range)?;
    let known = KNOWN.iter().find(|k| k.0 == function);
    let f = Arc::new(Expression::parse(known.map_or(function, |k| k.1))?);
    let (exact, exact_error, source) = match known {
        Some((_, _, antiderivative)) => (antiderivative(range[1]) - antiderivative(range[0]), 0.0, "antiderivative"),
        None => {
            let (value, error) = integrate(|x| f.at(x), range);
            (value, error, "adaptive Gauss quadrature")
        }
    };
    let length = range[1] - range[0];
    let squares = second_moment(|x| f.at(x).powi(2), range);
    let absolute = integrate(|x| f.at(x).abs(), range).0;
    // Where quadrature does not converge there is most likely nothing to converge to.
    if !exact.is_finite() || exact_error > MOST_ERROR * absolute {
        return Err(format!(
            "{function:?} has no finite integral over [{}, {}] that quadrature finds; choose another range",
            range[0], range[1]
        ));
    }
    let importance = density.map(|text| -> Result<(Shared, f64), String> {
        let density = Density::new(Expression::parse(text)?, range)?;
        let second = second_moment(|x| f.at(x).powi(2) / density.at(x), range);
        Ok((Arc::new(Importance { f: f.clone(), density }), second - exact * exact))
    });
    Ok(UnitProblem {
        quantity: Quantity {
            name: "interval".into(),
            formula: format!("∫ {} dx over [{}, {}]", f.text(), range[0], range[1]),
            exact,
            exact_error,
            source: source.into(),
        },
        variance: length * squares - exact * exact,
        importance: importance.transpose()?,
        optimal_variance: Some((absolute * absolute - exact * exact).max(0.0)),
        control: Some((Arc::new(Uniform { f: Arc::new(Expression::parse("1+x")?), range: [0.0, 1.0] }), 1.5)),
        // Where that is no number nothing is clamped.
        clamp: (0.9 * length * squares.sqrt() / length.sqrt()).min(f64::MAX),
        integrand: Arc::new(Uniform { f, range }),
        rules: true,
        width,
    })
}

/// ∫ of what a variance is made of: infinite where it seems to be, NaN (no prediction) where quadrature does not know it well.
fn second_moment(f: impl Fn(f64) -> f64, range: [f64; 2]) -> f64 {
    match integrate(f, range) {
        (value, error) if error <= MOST_ERROR * value => value,
        (value, error) if value == f64::INFINITY || error == f64::INFINITY => f64::INFINITY,
        _ => f64::NAN,
    }
}

pub(super) fn check_range([a, b]: [f64; 2]) -> Result<(), String> {
    // False for a NaN too.
    if a < b && (b - a).is_finite() { Ok(()) } else { Err(format!("[{a}, {b}] is no range; give A,B with A < B")) }
}
