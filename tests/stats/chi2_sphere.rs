//! Do sampled directions follow the density they claim?

use super::bounds::sidak_alpha;
use super::chi2::{Chi2Outcome, chi2_test};
use super::quadrature::{Adaptive, Rect};
use super::rng::Rng;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// A chi-square test of a direction sampler against its pdf over the whole sphere.
///
/// The sphere is cut into cells in (cosθ, φ) about an axis; the pdf (per steradian) is integrated over each cell
/// adaptively. Its total may fall short of 1: samplers may reject (return `None`), and the count of rejections is
/// tested against the missing mass as one more cell. A total above 1 fails by itself.
#[derive(Clone, Debug)]
pub struct Chi2Sphere {
    name: String,
    seed: u64,
    samples: u64,
    tests: usize,
    rows: usize,
    columns: usize,
    frame: [[f64; 3]; 3],
    power: f64,
}

/// What a test saw; `Display` is a readable table of the worst cells.
#[derive(Clone, Debug)]
pub struct SphereOutcome {
    pub chi2: Chi2Outcome,
    /// The pdf's integral over the sphere and the quadrature's estimated error.
    pub pdf_total: f64,
    pub pdf_error: f64,
    /// Samples that were `None`.
    pub rejected: u64,
    /// None, or why the test fails.
    pub failure: Option<String>,
}

/// The short form: 16 × 32 equal cells about z, 200,000 samples, one test. Panics on failure.
#[track_caller]
pub fn chi2_sphere(name: &str, sample: impl FnMut(&mut Rng) -> Option<[f64; 3]>, pdf: impl Fn([f64; 3]) -> f64) {
    Chi2Sphere::new(name).run(sample, pdf);
}

impl Chi2Sphere {
    pub fn new(name: impl Into<String>) -> Self {
        let frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Chi2Sphere { name: name.into(), seed: 1, samples: 200_000, tests: 1, rows: 16, columns: 32, frame, power: 1.0 }
    }

    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Number of draws, rejected ones included.
    pub fn samples(mut self, samples: u64) -> Self {
        self.samples = samples;
        self
    }

    /// How many tests this is one of: the family-wise error stays 1 %.
    pub fn tests(mut self, tests: usize) -> Self {
        self.tests = tests;
        self
    }

    /// Rows in cosθ (even: then the equator is a cell border) and columns in φ.
    pub fn cells(mut self, rows: usize, columns: usize) -> Self {
        (self.rows, self.columns) = (rows, columns);
        self
    }

    /// Cells about another axis, with 1 − cosθ = 2uᵖ for u uniform over the rows: p = 1 gives equal solid angles, larger
    /// p crowds the rows about the axis. For narrow lobes: the lobe's own axis and p = 2 … 6, so that many cells see it.
    pub fn around(mut self, axis: [f64; 3], power: f64) -> Self {
        let len = dot(axis, axis).sqrt();
        let z = axis.map(|a| a / len);
        let helper = if z[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let x = cross(helper, z);
        let len = dot(x, x).sqrt();
        let x = x.map(|a| a / len);
        (self.frame, self.power) = ([x, cross(z, x), z], power);
        self
    }

    /// Panics with a table if the samples do not follow the pdf.
    #[track_caller]
    pub fn run(&self, sample: impl FnMut(&mut Rng) -> Option<[f64; 3]>, pdf: impl Fn([f64; 3]) -> f64) {
        if let Some(failure) = self.outcome(sample, pdf).failure {
            panic!("{failure}");
        }
    }

    /// The same without panicking, for tests of tests.
    pub fn outcome(
        &self,
        mut sample: impl FnMut(&mut Rng) -> Option<[f64; 3]>,
        pdf: impl Fn([f64; 3]) -> f64,
    ) -> SphereOutcome {
        let cells = self.rows * self.columns;
        let mut observed = vec![0u64; cells + 1];
        let mut rng = Rng::new(self.seed);
        for _ in 0..self.samples {
            let cell = match sample(&mut rng) {
                None => cells,
                Some(w) if (dot(w, w) - 1.0).abs() < 1e-4 => self.cell(w),
                Some(w) => return self.not_unit(w),
            };
            observed[cell] += 1;
        }
        let (mut expected, error) = self.expected(&observed, pdf);
        let n = self.samples as f64;
        let total: f64 = expected.iter().sum::<f64>() / n;
        expected.push((n * (1.0 - total)).max(0.0));
        let chi2 = chi2_test(&observed, &expected);
        let mut outcome =
            SphereOutcome { chi2, pdf_total: total, pdf_error: error, rejected: observed[cells], failure: None };
        if !self.total_is_possible(total, error) || chi2.p_value < sidak_alpha(self.tests) {
            outcome.failure = Some(self.table(&outcome, &observed, &expected));
        }
        outcome
    }

    /// Not more than 1, with room for the quadrature's error and for a tenth of what sampling could resolve (an f32 pdf has
    /// ulps of its own). A NaN is not possible.
    fn total_is_possible(&self, total: f64, error: f64) -> bool {
        total <= 1.0 + error + 0.1 / (self.samples as f64).sqrt()
    }

    fn cell(&self, w: [f64; 3]) -> usize {
        let [x, y, z] = self.frame.map(|a| dot(a, w));
        let u = (0.5 * (1.0 - z)).clamp(0.0, 1.0).powf(1.0 / self.power);
        let v = y.atan2(x) / TAU;
        // Rounded up: a direction exactly in the equator belongs to the upper hemisphere.
        let row = ((u * self.rows as f64).ceil() as usize).clamp(1, self.rows) - 1;
        let column = (((v - v.floor()) * self.columns as f64) as usize).min(self.columns - 1);
        row * self.columns + column
    }

    fn direction(&self, u: f64, phi: f64) -> [f64; 3] {
        let h = u.powf(self.power); // (1 − cosθ)/2
        let (r, z) = (2.0 * (h * (1.0 - h)).sqrt(), 1.0 - 2.0 * h);
        let local = [r * phi.cos(), r * phi.sin(), z];
        std::array::from_fn(|i| (0..3).map(|a| self.frame[a][i] * local[a]).sum())
    }

    fn rect(&self, cell: usize) -> Rect {
        let (row, column) = ((cell / self.columns) as f64, (cell % self.columns) as f64);
        let (u, phi) = (1.0 / self.rows as f64, TAU / self.columns as f64);
        Rect { x: [row * u, (row + 1.0) * u], y: [column * phi, (column + 1.0) * phi] }
    }

    /// Expected counts of the cells, and the error of their sum as a fraction.
    fn expected(&self, observed: &[u64], pdf: impl Fn([f64; 3]) -> f64) -> (Vec<f64>, f64) {
        let (n, cells) = (self.samples as f64, self.rows * self.columns);
        // A hundredth of the standard deviation of the count of the smallest cell that is not pooled.
        let tolerance = 0.01 * 5f64.sqrt() / n;
        let density = |u: f64, phi: f64| pdf(self.direction(u, phi)) * 2.0 * self.power * u.powf(self.power - 1.0);
        let integrator = Adaptive::new(tolerance, density);
        let mut error = 0.0;
        let expected = (0..cells).map(|i| {
            // Samples tell where a peak may hide between the nodes of a coarse rule; a finer start is never wrong.
            let crowded = observed[i] as f64 * cells as f64 > 4.0 * n;
            let (mass, e) = integrator.integrate(self.rect(i), if crowded { 4 } else { 1 });
            error += e;
            n * mass
        });
        (expected.collect(), error)
    }

    fn not_unit(&self, w: [f64; 3]) -> SphereOutcome {
        let chi2 = Chi2Outcome { statistic: f64::NAN, dof: 0.0, p_value: 0.0 };
        let failure = Some(format!("{}: sampled {w:?}, which is not a unit vector", self.name));
        SphereOutcome { chi2, pdf_total: f64::NAN, pdf_error: f64::NAN, rejected: 0, failure }
    }

    fn table(&self, outcome: &SphereOutcome, observed: &[u64], expected: &[f64]) -> String {
        let SphereOutcome { chi2, pdf_total, pdf_error, .. } = outcome;
        let mut s = String::new();
        let _ = writeln!(
            s,
            "{}: chi-square {:.1} with {} degrees of freedom, p = {:.3e} (allowed {:.3e}, one of {} tests)\n  {} samples, seed {}; \
             the pdf integrates to {pdf_total:.7} ± {pdf_error:.1e}{}",
            self.name,
            chi2.statistic,
            chi2.dof,
            chi2.p_value,
            sidak_alpha(self.tests),
            self.tests,
            self.samples,
            self.seed,
            if self.total_is_possible(*pdf_total, *pdf_error) { "" } else { ": more than 1" },
        );
        let pull = |i: usize| (observed[i] as f64 - expected[i]) / expected[i].max(1.0).sqrt();
        let mut order: Vec<usize> = (0..observed.len()).collect();
        order.sort_by(|&a, &b| pull(b).abs().total_cmp(&pull(a).abs()));
        let _ = writeln!(s, "  {:>19} {:>15} {:>10} {:>12} {:>8}", "cosθ", "φ/π", "observed", "expected", "σ");
        for &i in order.iter().take(12) {
            let (cos, phi) = if i == self.rows * self.columns {
                ("rejected".to_string(), String::new())
            } else {
                let r = self.rect(i);
                let cos = r.x.map(|u| 1.0 - 2.0 * u.powf(self.power));
                (format!("{:.5} … {:.5}", cos[1], cos[0]), format!("{:.3} … {:.3}", r.y[0] / PI, r.y[1] / PI))
            };
            let _ = writeln!(s, "  {cos:>19} {phi:>15} {:>10} {:>12.2} {:>+8.2}", observed[i], expected[i], pull(i));
        }
        s
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
