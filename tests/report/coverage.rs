//! Do 95 % intervals hold the truth 95 % of the time? Simulated, with the power stated.

use crate::stats::{Rng, z_bound};
use octolux::report::fit::{Estimate, fit_power_law};

/// At 20,000 trials the standard error of a coverage is .0015: a true coverage of .94 or .96 would be found with a
/// probability beyond 99.9 %.
const TRIALS: usize = 20_000;

/// Mean square of `values` normal values of deviation 1.
fn mean_square(rng: &mut Rng, values: usize) -> f64 {
    (0..values).map(|_| normal(rng).powi(2)).sum::<f64>() / values as f64
}

pub fn normal(rng: &mut Rng) -> f64 {
    let (u, v) = (1.0 - rng.f64(), rng.f64());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn assert_coverage(name: &str, hits: usize, tests: usize) {
    let share = hits as f64 / TRIALS as f64;
    let error = (0.95f64 * 0.05 / TRIALS as f64).sqrt();
    let z = (share - 0.95) / error;
    assert!(z.abs() < z_bound(tests), "{name}: {share:.4} instead of .95, z = {z:.2}");
}

#[test]
fn an_interval_over_eight_seeds_covers_the_mean() {
    let mut rng = Rng::new(11);
    let covers = |e: Estimate, truth: f64| e.lo <= truth && truth <= e.hi;
    let normal_hits = (0..TRIALS)
        .filter(|_| covers(Estimate::mean(&std::array::from_fn::<_, 8, _>(|_| 3.0 + normal(&mut rng))), 3.0))
        .count();
    assert_coverage("normal", normal_hits, 2);
    // A seed's MSE is a mean of many squares: skewed, but by 1/√N.
    let squares_hits = (0..TRIALS)
        .filter(|_| covers(Estimate::mean(&std::array::from_fn::<_, 8, _>(|_| mean_square(&mut rng, 300))), 1.0))
        .count();
    assert_coverage("mean squares", squares_hits, 2);
}

#[test]
fn the_slopes_interval_covers_the_slope() {
    let mut rng = Rng::new(12);
    let budgets = [1.0f64, 2.0, 4.0, 8.0, 16.0];
    let hits = (0..TRIALS)
        .filter(|_| {
            let points = budgets.map(|n| {
                let seeds: [f64; 8] = std::array::from_fn(|_| (1.0 + 0.05 * normal(&mut rng)) / n);
                (n, Estimate::mean(&seeds))
            });
            let exponent = fit_power_law(&points).expect("five points").exponent;
            exponent.lo <= -1.0 && -1.0 <= exponent.hi
        })
        .count();
    // Satterthwaite's degrees of freedom are an approximation: within half a percent here.
    let share = hits as f64 / TRIALS as f64;
    assert!((0.945..0.96).contains(&share), "{share}");
}
