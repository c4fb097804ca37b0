//! A Gaussian process on the unit interval: functions drawn from the prior, then the posterior after some values are seen.

use super::{Demonstration, Part};
use crate::estimate::bmc::line::Covariance;
use crate::estimate::bmc::{Mean, weights};
use crate::estimate::cholesky::{Cholesky, dot};
use crate::estimate::expression::Expression;
use crate::estimate::points::unit;
use crate::estimate::study::Quantity;
use crate::report::page::Table;
use crate::report::plot::{Curve, Guide, Plot, Point, Scale};
use crate::sampling::sample_key;
use std::f64::consts::TAU;

/// Where curves are drawn.
const GRID: usize = 121;
const LENGTH: f64 = 0.15;
/// Functions drawn from the prior.
const DRAWS: u32 = 4;
/// Keeps Q factorable; a hundred-thousandth of the band's width.
const JITTER: f64 = 1e-8;

fn grid() -> Vec<f64> {
    (0..GRID).map(|i| i as f64 / (GRID - 1) as f64).collect()
}

/// The covariances shown: one for functions that are smooth beyond reason, one for functions with kinks.
const COVARIANCES: [(&str, Covariance); 2] = [
    ("squared exponential, ℓ = 0.15", Covariance::SquaredExponential { length: LENGTH }),
    ("Sobolev, 1 − |x − x′|", Covariance::Sobolev),
];

/// Prior and posteriors for `f` seen at each number of points.
///
/// # Errors
/// f has no value at a point.
pub fn gp_line(f: &Expression, truth: &Quantity, counts: &[usize], seed: u64) -> Result<Demonstration, String> {
    let mut sections = Vec::new();
    let mut table =
        Table::new(["covariance", "points", "posterior mean of ∫f", "posterior s.d.", "error", "error / s.d."]);
    for (k, (name, covariance)) in COVARIANCES.into_iter().enumerate() {
        let mut plots = vec![(format!("prior-{k}"), prior(name, covariance, seed))];
        for &n in counts {
            let x: Vec<f64> = (0..n).map(|i| stratified(seed, i, n)).collect();
            let y: Vec<f64> = x.iter().map(|&x| f.at(x)).collect();
            if let Some(bad) = x.iter().zip(&y).find(|(_, y)| !y.is_finite()) {
                return Err(format!("{:?} has no value at x = {}; choose another f", f.text(), bad.0));
            }
            let integral = weights(&covariance.system(&x), Mean::Zero, 0.0);
            let (value, deviation) = (integral.estimate(&y), integral.variance(&y).map(f64::sqrt));
            let error = value - truth.exact;
            table = table.row([
                name.to_owned(),
                n.to_string(),
                format!("{value:.8}"),
                deviation.map_or("–".into(), |d| format!("{d:.2e}")),
                format!("{error:+.2e}"),
                deviation.map_or("–".into(), |d| format!("{:+.2}", error / d)),
            ]);
            plots.push((format!("posterior-{k}-{n}"), posterior(covariance, f, &x, &y)?));
        }
        let prose = "Bands are two standard deviations; the scale σ_f is estimated from the values.".to_owned();
        sections.push(Part { title: name.to_owned(), prose, plots, ..Part::default() });
    }
    let prose = format!(
        "∫ {} dx over [0, 1] = {:.8}. Zero mean, one point in each n-th of the interval.",
        f.text(),
        truth.exact
    );
    sections.push(Part { title: "The integral".into(), prose, table, plots: Vec::new() });
    let lead = "What a Gaussian process believes of a function before and after some of its values are seen".into();
    Ok(Demonstration { title: "gp-1d".into(), lead, sections })
}

fn stratified(seed: u64, i: usize, n: usize) -> f64 {
    (i as f64 + unit(sample_key(seed, n as u32, i as u32) as u32)) / n as f64
}

fn prior(name: &str, covariance: Covariance, seed: u64) -> Plot {
    let x = grid();
    let mut plot = Plot::new(format!("Prior: {name}"), ("x", Scale::Linear), ("f", Scale::Linear));
    let band = |x: &f64| Point { x: *x, y: 0.0, lo: -2.0, hi: 2.0 };
    plot = plot.curve(Curve::new("mean ± 2 s.d.", x.iter().map(band).collect()).smooth());
    let Some(factor) = Cholesky::new(&covariance.system(&x).gram, GRID, JITTER) else { return plot };
    for draw in 0..DRAWS {
        let noise: Vec<f64> = (0..GRID).map(|i| normal(sample_key(seed, draw, 1000 + i as u32))).collect();
        let y = factor.times(&noise);
        plot = plot.curve(Curve::line(format!("draw {}", draw + 1), x.iter().copied().zip(y)).smooth());
    }
    plot
}

/// A standard normal number of a key (Box & Muller 1958).
fn normal(key: u64) -> f64 {
    let [a, b] = [key as u32, (key >> 32) as u32].map(unit);
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}

/// m(x) = k(x)ᵀQ⁻¹y, v(x) = σ_f²(k(x, x) − k(x)ᵀQ⁻¹k(x)) (Rasmussen & Williams 2006, eq. 2.25–2.26).
fn posterior(covariance: Covariance, f: &Expression, x: &[f64], y: &[f64]) -> Result<Plot, String> {
    let n = x.len();
    let title = format!("Posterior after {n} value{}", if n == 1 { "" } else { "s" });
    let plot = Plot::new(title, ("x", Scale::Linear), ("f", Scale::Linear));
    let factor = Cholesky::new(&covariance.system(x).gram, n, JITTER)
        .ok_or_else(|| format!("the covariance of {n} points cannot be factored; ask for fewer with --samples"))?;
    let alpha = factor.solve(y);
    let scale = dot(&alpha, y) / n as f64;
    let at = |&t: &f64| {
        let k: Vec<f64> = x.iter().map(|&x| covariance.between(t, x)).collect();
        let (mean, variance) = (dot(&k, &alpha), scale * (covariance.between(t, t) - factor.quadratic(&k)));
        let half = 2.0 * variance.max(0.0).sqrt();
        Point { x: t, y: mean, lo: mean - half, hi: mean + half }
    };
    let grid = grid();
    let truth = grid.iter().map(|&t| (t, f.at(t))).filter(|p| p.1.is_finite());
    Ok(plot
        .curve(Curve::new("posterior mean ± 2 s.d.", grid.iter().map(at).collect()).smooth())
        .curve(Curve::line("f", truth).smooth())
        .curve(Curve::scatter("seen", x.iter().copied().zip(y.iter().copied())))
        .guide(Guide::level(0.0, "prior mean")))
}
