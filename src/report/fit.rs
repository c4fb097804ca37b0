//! Statistics of error curves: intervals of means, power laws, and the budget that an error needs.

use crate::student::{CONFIDENCE, student_quantile};

/// An estimate with its interval at [`CONFIDENCE`].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Estimate {
    pub value: f64,
    /// −∞ and ∞ (`null` in JSON) where one value alone says nothing about the spread.
    #[serde(with = "open_end::low")]
    pub lo: f64,
    #[serde(with = "open_end::high")]
    pub hi: f64,
    #[serde(with = "open_end::high")]
    pub standard_error: f64,
    pub dof: u32,
}

impl Estimate {
    /// Student's interval around `value`.
    pub fn student(value: f64, standard_error: f64, dof: u32) -> Self {
        let half = if dof == 0 { f64::INFINITY } else { student_quantile(dof, CONFIDENCE) * standard_error };
        Estimate { value, lo: value - half, hi: value + half, standard_error, dof }
    }

    /// Mean of independent values, with the interval of their spread.
    pub fn mean(values: &[f64]) -> Self {
        let (mean, standard_error) = mean_and_error(values);
        Self::student(mean, standard_error, values.len().saturating_sub(1) as u32)
    }

    /// The same less a known constant: a reference's own noise.
    pub fn minus(self, constant: f64) -> Self {
        Estimate { value: self.value - constant, lo: self.lo - constant, hi: self.hi - constant, ..self }
    }

    /// Of f(value), f increasing on the interval: its ends are mapped, the standard error to first order.
    pub fn map_increasing(self, f: impl Fn(f64) -> f64, derivative: impl Fn(f64) -> f64) -> Self {
        let standard_error = self.standard_error * derivative(self.value);
        Estimate { value: f(self.value), lo: f(self.lo), hi: f(self.hi), standard_error, dof: self.dof }
    }

    /// √ of a mean square; what is below zero counts as zero.
    pub fn sqrt(self) -> Self {
        self.map_increasing(|x| x.max(0.0).sqrt(), |x| if x > 0.0 { 0.5 / x.sqrt() } else { 0.0 })
    }

    /// The same value, as uncertain as its product with an independent estimate: what an uncertain x adds to y on a
    /// line of slope ±1 in logarithms.
    pub fn uncertain_by(self, x: Self) -> Self {
        let relative = self.relative_error().hypot(x.relative_error());
        Self::student(self.value, relative * self.value.abs(), self.dof.min(x.dof))
    }

    /// a b of independent estimates: relative errors add in quadrature.
    pub fn times(self, other: Self) -> Self {
        let error = (self.standard_error * other.value).hypot(other.standard_error * self.value);
        Self::student(self.value * other.value, error, self.dof.min(other.dof))
    }

    /// Standard error over value.
    pub fn relative_error(&self) -> f64 {
        self.standard_error / self.value.abs()
    }
}

/// Mean and standard error of independent values; the error of fewer than two is infinite.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, if values.len() < 2 { f64::INFINITY } else { (squares / (n * (n - 1.0))).sqrt() })
}

/// The middle value, or the mean of the two; NaN of none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// y = constant · x^exponent, fitted.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PowerLaw {
    pub exponent: Estimate,
    pub constant: f64,
    /// Residuals over what the points' own errors explain: χ² per degree of freedom. Far above 1 the points bend, and
    /// one exponent does not describe them. `None` for two points.
    pub lack_of_fit: Option<f64>,
}

/// Straight line through (ln x, ln y) by least squares, each point weighing the same. `points` are x with the
/// independent estimate of y there; those that are not positive are left out. Fewer than two x give `None`, and so does a line so
/// steep that its constant is out of range.
///
/// The exponent is Σ cᵢ ln yᵢ with fixed cᵢ, so that its variance is Σ cᵢ² (sᵢ/yᵢ)² by the points' own standard errors,
/// with the degrees of freedom of Satterthwaite (1946); the interval is of this average exponent, bent curve or not.
pub fn fit_power_law(points: &[(f64, Estimate)]) -> Option<PowerLaw> {
    let usable = |&(x, y): &(f64, Estimate)| (x > 0.0 && y.value > 0.0 && x.is_finite()).then(|| (x.ln(), y));
    let points: Vec<_> = points.iter().filter_map(usable).collect();
    let n = points.len() as f64;
    let mean_x = points.iter().map(|p| p.0).sum::<f64>() / n;
    let mean_y = points.iter().map(|p| p.1.value.ln()).sum::<f64>() / n;
    let spread: f64 = points.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
    if points.len() < 2 || spread <= 1e-12 * n {
        return None;
    }
    let exponent: f64 = points.iter().map(|p| (p.0 - mean_x) / spread * p.1.value.ln()).sum();
    let parts = points.iter().map(|(x, y)| (((x - mean_x) / spread).powi(2) * y.relative_error().powi(2), y.dof));
    let variance: f64 = parts.clone().map(|(part, _)| part).sum();
    let denominator: f64 = parts.map(|(part, dof)| part * part / f64::from(dof.max(1))).sum();
    let dof = if denominator > 0.0 { (variance * variance / denominator).floor().clamp(1.0, 1e6) } else { 1e6 };
    let intercept = mean_y - exponent * mean_x;
    let constant = Some(intercept.exp()).filter(|constant| constant.is_normal())?;
    let chi_square: f64 = points
        .iter()
        .map(|(x, y)| ((y.value.ln() - intercept - exponent * x) / y.relative_error().max(1e-12)).powi(2))
        .sum();
    Some(PowerLaw {
        exponent: Estimate::student(exponent, variance.sqrt(), if variance.is_finite() { dof as u32 } else { 0 }),
        constant,
        lack_of_fit: (points.len() > 2).then(|| chi_square / (n - 2.0)),
    })
}

/// The budget at which an error is reached.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Reached {
    pub budget: f64,
    /// Its interval at [`CONFIDENCE`]; 0 and ∞ (`null` in JSON) where the errors' own are not known.
    #[serde(default)]
    pub lo: f64,
    #[serde(with = "open_end::high", default)]
    pub hi: f64,
    /// Beyond what was measured, along the fitted power law: a guess, not a measurement.
    pub extrapolated: bool,
}

impl Reached {
    /// A relative error of the budget, small or not: the interval is that of its logarithm.
    fn new(budget: f64, relative_error: f64, dof: u32, extrapolated: bool) -> Self {
        let ln = Estimate::student(budget.ln(), relative_error, dof);
        let known = relative_error.is_finite() && dof > 0;
        let (lo, hi) = if known { (ln.lo.exp(), ln.hi.exp()) } else { (0.0, f64::INFINITY) };
        Reached { budget, lo, hi, extrapolated }
    }

    /// With something that costs `more` whatever the error.
    pub fn plus(self, more: f64) -> Self {
        Reached { budget: self.budget + more, lo: self.lo + more, hi: self.hi + more, ..self }
    }
}

/// A budget that is so many times what was measured is said by nobody.
const FARTHEST: f64 = 1e6;

/// The budget from which on y ≤ `target`. `points` are (x, y) with x increasing; between neighbours ln y is linear in
/// ln x, outside the points y goes on from the nearest one with the given `exponent`. `None` where there is nothing to
/// go by, the errors do not fall, or so slowly that the budget is a million times what was measured.
///
/// Its interval is that of y at the budget found, over the slope there; of a budget extrapolated the exponent's error
/// times the distance is added, not in quadrature, since the exponent may come from the same points.
pub fn budget_for(points: &[(f64, Estimate)], target: f64, exponent: Option<Estimate>) -> Option<Reached> {
    let points: Vec<_> = points.iter().copied().filter(|&(x, y)| x > 0.0 && y.value > 0.0).collect();
    let (first, last) = (*points.first()?, *points.last()?);
    if last.1.value > target || first.1.value <= target {
        let (x, y) = if last.1.value > target { last } else { first };
        let slope = exponent.filter(|slope| slope.value < 0.0);
        if y.value == target {
            let error = slope.map_or(f64::INFINITY, |slope| y.relative_error() / -slope.value);
            return Some(Reached::new(x, error, y.dof, false));
        }
        let slope = slope?;
        let far = (target / y.value).ln() / slope.value;
        let error = y.relative_error() / -slope.value + far.abs() * slope.relative_error();
        let budget = Some(x * far.exp()).filter(|budget| (x / FARTHEST..=x * FARTHEST).contains(budget))?;
        return Some(Reached::new(budget, error, y.dof.min(slope.dof), true));
    }
    // The last pair that falls through the target: from there on all measured errors are at most the target.
    let pair = points.windows(2).rev().find(|pair| pair[0].1.value > target)?;
    let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
    let slope = (y1.value / y0.value).ln() / (x1 / x0).ln();
    let far = (target / y0.value).ln() / slope;
    let share = far / (x1 / x0).ln();
    let error = ((1.0 - share) * y0.relative_error()).hypot(share * y1.relative_error());
    // An end that does not count is no reason for doubt.
    let dof = [(1.0 - share, y0.dof), (share, y1.dof)].iter().filter(|p| p.0 > 0.0).map(|p| p.1).min().unwrap_or(0);
    Some(Reached::new(x0 * far.exp(), error / -slope, dof, false))
}

/// An infinite end is `null` in JSON, which has no infinities.
mod open_end {
    macro_rules! end {
        ($name:ident, $infinity:expr) => {
            pub mod $name {
                use serde::{Deserialize, Deserializer, Serialize, Serializer};

                pub fn serialize<S: Serializer>(x: &f64, to: S) -> Result<S::Ok, S::Error> {
                    x.is_finite().then_some(*x).serialize(to)
                }
                pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
                    Ok(Option::deserialize(from)?.unwrap_or($infinity))
                }
            }
        };
    }
    end!(low, f64::NEG_INFINITY);
    end!(high, f64::INFINITY);
}
