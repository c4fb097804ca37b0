//! How far the weights of a posterior are drawn back towards equal ones.
//!
//! What a covariance does not explain (a small sun, the noise of paths that go on) is to the weights as white noise, and of
//! white noise the plain mean makes the least: unequal weights only add Σw². With w_λ = (1 − λ) w + λ P/n the estimate is
//! the plain mean plus (1 − λ) times the difference of the two, a control variate, so its error is a parabola in λ whose
//! lowest point a pilot finds (Owen 2013, "Monte Carlo theory, methods and examples", § 8.9). The pilot has random numbers
//! of its own: for the estimates that follow, λ is a constant.

/// What the pilot saw of pairs of estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pilot {
    /// Σ over integrals of the means of (equal − reference) · difference and of difference².
    cross: f64,
    square: f64,
}

impl Pilot {
    /// Adds one integral: `pairs` of estimates of it with equal weights and with the posterior's, each pair from the values
    /// at the same points, and a `reference`, an unbiased estimate of it from points of its own. (Not the mean of the pairs:
    /// where they share a few sets of points, it is off by what the sets share.) Nothing without pairs or where something is not
    /// finite.
    pub fn add(&mut self, reference: f64, pairs: &[[f64; 2]]) {
        if pairs.is_empty() || !reference.is_finite() || pairs.iter().flatten().any(|v| !v.is_finite()) {
            return;
        }
        let n = pairs.len() as f64;
        let difference = |pair: &[f64; 2]| pair[1] - pair[0];
        self.cross += pairs.iter().map(|pair| (pair[0] - reference) * difference(pair)).sum::<f64>() / n;
        self.square += pairs.iter().map(|pair| difference(pair).powi(2)).sum::<f64>() / n;
    }

    /// λ in [0, 1] of the least squared error, summed over the integrals; 0 where nothing tells the weights apart.
    pub fn intensity(&self) -> f64 {
        if self.square > 0.0 { 1.0 - (-self.cross / self.square).clamp(0.0, 1.0) } else { 0.0 }
    }
}
