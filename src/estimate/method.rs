//! A way to estimate a number from n samples, as a study runs it.

use super::points::{PointPlan, Points, unit};
use crate::kernel::Width;

/// What a method claims of its mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Claim {
    /// E\[Î\] = I: a bias beyond chance is a fault.
    Unbiased,
    /// E\[Î\] = I + B.
    Biased,
    /// No chance in it: one estimate says all.
    Deterministic,
}

/// One estimate: its value, and its own idea of its standard error where it has one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Single {
    pub value: f64,
    pub standard_error: Option<f64>,
}

type Run = Box<dyn Fn(u64, usize) -> Single + Send + Sync>;

/// A method made ready for a number of samples.
pub struct Prepared {
    /// Evaluations an estimate makes: up to the number asked for.
    pub samples: usize,
    /// More estimates than this would repeat earlier ones.
    pub distinct: Option<usize>,
    /// To be said in the report.
    pub note: Option<String>,
    /// The estimate of a key; the second number counts estimates.
    pub run: Run,
}

type Prepare = Box<dyn Fn(usize) -> Option<Prepared> + Send + Sync>;
type VarianceLaw = Box<dyn Fn(usize) -> f64 + Send + Sync>;

pub struct Method {
    pub name: String,
    pub claim: Claim,
    /// Variance of an estimate of n samples as theory has it.
    pub variance: Option<VarianceLaw>,
    /// `None` where the method cannot do with so many samples.
    pub prepare: Prepare,
}

impl Prepared {
    pub fn new(samples: usize, run: impl Fn(u64, usize) -> Single + Send + Sync + 'static) -> Self {
        Self { samples, distinct: None, note: None, run: Box::new(run) }
    }
}

impl Method {
    pub fn new(
        name: impl Into<String>,
        claim: Claim,
        prepare: impl Fn(usize) -> Option<Prepared> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), claim, variance: None, prepare: Box::new(prepare) }
    }

    pub fn with_variance(mut self, law: impl Fn(usize) -> f64 + Send + Sync + 'static) -> Self {
        self.variance = Some(Box::new(law));
        self
    }
}

/// A function on the unit cube whose mean is wanted.
pub trait Integrand: Send + Sync {
    fn dimensions(&self) -> usize;
    /// In f64, at a point inside the cube.
    fn at(&self, x: &[f64]) -> f64;
    /// At points given by their bits, as [`PointPlan::fill`] writes them; rows are a multiple of the widest lanes long.
    /// In lanes where the function has them; the same bits at any width.
    fn fill(&self, _width: Width, bits: &[Vec<u32>], values: &mut [f64]) {
        let mut x = vec![0.0; self.dimensions()];
        for (i, value) in values.iter_mut().enumerate() {
            x.iter_mut().zip(bits).for_each(|(x, row)| *x = unit(row[i]));
            *value = self.at(&x);
        }
    }
}

/// An integrand that several methods hold.
pub type Shared = std::sync::Arc<dyn Integrand>;

thread_local! {
    /// Coordinates and values of the estimate being made: kept, because most estimates are small.
    static SCRATCH: std::cell::RefCell<(Vec<Vec<u32>>, Vec<f64>)> = const { std::cell::RefCell::new((Vec::new(), Vec::new())) };
}

/// Calls `then` with the values of `integrand` at the points of `key`.
pub fn with_values<T>(
    plan: &PointPlan,
    integrand: &dyn Integrand,
    width: Width,
    key: u64,
    then: impl FnOnce(&[f64]) -> T,
) -> T {
    SCRATCH.with_borrow_mut(|(bits, values)| {
        bits.resize_with(integrand.dimensions(), Vec::new);
        plan.fill(width, key, bits);
        values.resize(plan.len(), 0.0);
        integrand.fill(width, bits, values);
        then(values)
    })
}

/// The plain mean of the integrand over points. Its standard error is √(s²/n) where points are independent; under any
/// other kind s² says nothing of the mean's.
pub fn mean_over(name: impl Into<String>, points: Points, integrand: Shared, width: Width) -> Method {
    Method::new(name, Claim::Unbiased, move |n| {
        let plan = points.plan(n, integrand.dimensions())?;
        let independent = points == Points::Independent;
        let integrand = integrand.clone();
        Some(Prepared::new(plan.len(), move |key, _| {
            with_values(&plan, &*integrand, width, key, |values| {
                let (mean, squares) = mean_and_squares(values);
                let n = values.len() as f64;
                let standard_error = (independent && n > 1.0).then(|| (squares / (n * (n - 1.0))).sqrt());
                Single { value: mean, standard_error }
            })
        }))
    })
}

/// Mean and Σ(y − mean)², in index order.
pub fn mean_and_squares(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|v| (v - mean) * (v - mean)).sum())
}
