//! Integrals of functions that nobody knows in closed form, with an error to go with them.

use super::rules::Gauss;

/// Halvings at most: as many as halve a panel at 0 to nothing.
const DEPTH: u32 = 1000;
/// Elsewhere numbers end sooner: a panel this narrow, relative to where it is, holds some thousand of them, and its nodes must not fall
/// together on what it corners.
const NARROWEST: f64 = 1e-12;
/// Panels at most, so that a function which is noise to the last bit ends too.
const PANELS: u32 = 100_000;
/// Where each halving leaves more than this of the difference before, it is taken to go on for ever.
const ENDLESS: f64 = 0.999;

/// ∫ f over [a, b] and a bound on its error, infinite where the integral seems to be: fifteen Gauss nodes against twice fifteen, halved
/// until they agree.
pub fn integrate(f: impl Fn(f64) -> f64, range: [f64; 2]) -> (f64, f64) {
    let gauss = Gauss::new(15);
    // A scale for what error is worth chasing, from 64 panels that few functions hide between.
    let scale = gauss.integrate(range, 64, |x| f(x).abs());
    let mut walk = Walk { f, gauss, tolerance: 1e-15 * scale, panels_left: PANELS };
    let (mut total, mut error) = (0.0, 0.0);
    let width = (range[1] - range[0]) / 16.0;
    for panel in 0..16 {
        let part = [range[0] + width * f64::from(panel), range[0] + width * f64::from(panel + 1)];
        let (t, e) = walk.refine(part, f64::INFINITY, 0);
        total += t;
        error += e;
    }
    (total, error + 4e-16 * scale)
}

struct Walk<F> {
    f: F,
    gauss: Gauss,
    tolerance: f64,
    panels_left: u32,
}

impl<F: Fn(f64) -> f64> Walk<F> {
    /// Of a panel, whose parent's two values were `parent` apart.
    fn refine(&mut self, [a, b]: [f64; 2], parent: f64, depth: u32) -> (f64, f64) {
        let (coarse, fine) = (self.gauss.integrate([a, b], 1, &self.f), self.gauss.integrate([a, b], 2, &self.f));
        let difference = (fine - coarse).abs();
        self.panels_left = self.panels_left.saturating_sub(1);
        let cornered = depth == DEPTH || b - a <= NARROWEST * a.abs().max(b.abs());
        if difference <= self.tolerance || cornered || self.panels_left == 0 || !difference.is_finite() {
            // At a singularity xᵃ each halving leaves the same part q of a difference: further ones would sum to q/(1 − q) of this.
            let further = match difference / parent {
                q if q < ENDLESS => 1.0 / (1.0 - q),
                _ if cornered && difference > self.tolerance => f64::INFINITY,
                _ => 1.0,
            };
            return (fine, if difference == 0.0 { 0.0 } else { difference * further });
        }
        let middle = 0.5 * (a + b);
        let left = self.refine([a, middle], difference, depth + 1);
        let right = self.refine([middle, b], difference, depth + 1);
        (left.0 + right.0, left.1 + right.1)
    }
}
