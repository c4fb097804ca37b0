//! Means and variances of samples, and tests of them.

use super::bounds::t_bound;

/// Count, mean and central sums of powers 2 and 4 (Welford 1962; Pébay 2008), in f64.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    pub n: u64,
    pub mean: f64,
    m2: f64,
    m3: f64,
    m4: f64,
}

impl Moments {
    pub fn new() -> Self {
        Self::default()
    }

    pub fn push(&mut self, x: f64) {
        let n0 = self.n as f64;
        self.n += 1;
        let n = self.n as f64;
        let d = x - self.mean;
        let dn = d / n;
        let t = d * dn * n0;
        self.mean += dn;
        self.m4 += t * dn * dn * (n * n - 3.0 * n + 3.0) + 6.0 * dn * dn * self.m2 - 4.0 * dn * self.m3;
        self.m3 += t * dn * (n - 2.0) - 3.0 * dn * self.m2;
        self.m2 += t;
    }

    /// Unbiased sample variance; 0 for fewer than two samples.
    pub fn variance(&self) -> f64 {
        if self.n < 2 { 0.0 } else { self.m2 / (self.n - 1) as f64 }
    }

    /// Standard error of the mean.
    pub fn std_error(&self) -> f64 {
        (self.variance() / self.n.max(1) as f64).sqrt()
    }

    /// Standard error of [`Moments::variance`], to first order in 1/n: √((μ₄ − σ⁴)/n).
    pub fn variance_std_error(&self) -> f64 {
        let n = self.n.max(1) as f64;
        let v = self.m2 / n;
        ((self.m4 / n - v * v).max(0.0) / n).sqrt()
    }
}

impl Extend<f64> for Moments {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, samples: T) {
        samples.into_iter().for_each(|x| self.push(x));
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<T: IntoIterator<Item = f64>>(samples: T) -> Self {
        let mut m = Moments::new();
        m.extend(samples);
        m
    }
}

/// None if the mean is `expected` ± (`abs_tol` + Student's t bound for one of `tests` tests · standard error), else what
/// is wrong. `abs_tol` is for rounding, not for luck. NaN is wrong.
pub fn mean_problem(name: &str, m: &Moments, expected: f64, abs_tol: f64, tests: usize) -> Option<String> {
    problem(&format!("{name}: mean"), m.mean, m.std_error(), m.n, expected, abs_tol, tests)
}

fn problem(what: &str, value: f64, se: f64, n: u64, expected: f64, abs_tol: f64, tests: usize) -> Option<String> {
    assert!(n >= 2, "{what}: {n} samples say nothing");
    let k = t_bound(tests, (n - 1) as f64);
    let off = value - expected;
    let allowed = k * se + abs_tol;
    let fits = off.abs() <= allowed; // false for a NaN
    (!fits).then(|| {
        format!(
            "{what} {value:.9} for {expected:.9}: off by {off:+.3e}, {:.2} standard errors of {se:.3e} (n = {n}); \
             allowed {k:.3} of them as one of {tests} tests, plus {abs_tol:.1e}",
            off / se
        )
    })
}

/// Panics unless the mean is `expected`; see [`mean_problem`].
#[track_caller]
pub fn assert_mean(name: &str, m: &Moments, expected: f64, abs_tol: f64, tests: usize) {
    if let Some(problem) = mean_problem(name, m, expected, abs_tol, tests) {
        panic!("{problem}");
    }
}

/// Panics unless the per-sample variance is `expected`, within its own standard error (for n in the thousands and
/// more) and Šidák's bound: a correct mean with the wrong variance is a bug too.
#[track_caller]
pub fn assert_variance(name: &str, m: &Moments, expected: f64, abs_tol: f64, tests: usize) {
    let what = format!("{name}: variance");
    if let Some(problem) = problem(&what, m.variance(), m.variance_std_error(), m.n, expected, abs_tol, tests) {
        panic!("{problem}");
    }
}
