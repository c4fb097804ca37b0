//! Integrals of functions that nobody knows in closed form, with an error to go with them.

use super::rules::Gauss;

/// Halvings at most: past them a jump has been cornered to 2⁻⁴⁸ of a panel.
const DEPTH: u32 = 48;
/// Panels at most, so that a function which is noise to the last bit ends too.
const PANELS: u32 = 100_000;

/// ∫ f over [a, b] and a bound on its error: fifteen Gauss nodes against twice fifteen, halved until they agree.
pub fn integrate(f: impl Fn(f64) -> f64, range: [f64; 2]) -> (f64, f64) {
    let gauss = Gauss::new(15);
    // A scale for what error is worth chasing, from 64 panels that few functions hide between.
    let scale = gauss.integrate(range, 64, |x| f(x).abs());
    let (mut total, mut error, mut left) = (0.0, 0.0, PANELS);
    let width = (range[1] - range[0]) / 16.0;
    for panel in 0..16 {
        let part = [range[0] + width * f64::from(panel), range[0] + width * f64::from(panel + 1)];
        let (t, e) = refine(&f, &gauss, part, 1e-15 * scale, 0, &mut left);
        total += t;
        error += e;
    }
    (total, error + 4e-16 * scale)
}

fn refine(
    f: &impl Fn(f64) -> f64,
    gauss: &Gauss,
    [a, b]: [f64; 2],
    tolerance: f64,
    depth: u32,
    panels_left: &mut u32,
) -> (f64, f64) {
    let (coarse, fine) = (gauss.integrate([a, b], 1, f), gauss.integrate([a, b], 2, f));
    let difference = (fine - coarse).abs();
    *panels_left = panels_left.saturating_sub(1);
    if difference <= tolerance || depth == DEPTH || *panels_left == 0 || !difference.is_finite() {
        return (fine, difference);
    }
    let middle = 0.5 * (a + b);
    let left = refine(f, gauss, [a, middle], tolerance, depth + 1, panels_left);
    let right = refine(f, gauss, [middle, b], tolerance, depth + 1, panels_left);
    (left.0 + right.0, left.1 + right.1)
}
