//! Pixels with their variances, and when two images disagree.

use crate::stats::{Moments, t_bound, z_bound};
use octolux::scene::Scene;
use std::fmt::Write;

/// A rectangle of pixels: columns x0 … x1 − 1, rows y0 … y1 − 1, row 0 on top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    pub x0: u32,
    pub y0: u32,
    pub x1: u32,
    pub y1: u32,
}

impl Region {
    pub fn whole(scene: &Scene) -> Self {
        Region { x0: 0, y0: 0, x1: scene.film.width, y1: scene.film.height }
    }

    pub fn width(&self) -> usize {
        (self.x1 - self.x0) as usize
    }

    pub fn height(&self) -> usize {
        (self.y1 - self.y0) as usize
    }
}

/// Moments of the samples of each pixel of a region, a channel each; rows from the top.
#[derive(Clone, Debug)]
pub struct Image {
    pub region: Region,
    pub pixels: Vec<[Moments; 3]>,
}

/// A mean and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub mean: f64,
    pub std_error: f64,
}

impl Image {
    /// Of the pixel in column x, row y of the whole film.
    pub fn pixel(&self, x: u32, y: u32) -> &[Moments; 3] {
        &self.pixels[(y - self.region.y0) as usize * self.region.width() + (x - self.region.x0) as usize]
    }

    /// Per-pixel means, rows from the top.
    pub fn means(&self) -> Vec<[f64; 3]> {
        self.pixels.iter().map(|p| p.map(|m| m.mean)).collect()
    }

    /// Mean over all pixels, a channel.
    pub fn mean(&self) -> [Estimate; 3] {
        std::array::from_fn(|c| average(self.pixels.iter().map(|p| estimate(&p[c]))))
    }

    /// Panics unless the mean over all pixels is `expected` in every channel, as one of `tests` tests.
    #[track_caller]
    pub fn assert_mean(&self, name: &str, expected: [f64; 3], abs_tol: f64, tests: usize) {
        for (c, e) in self.mean().into_iter().enumerate() {
            let samples = self.pixels.len() as f64 * self.pixels[0][c].n as f64;
            let allowed = t_bound(tests, samples - 1.0) * e.std_error + abs_tol;
            let off = (e.mean - expected[c]).abs();
            assert!(
                off <= allowed,
                "{name}, channel {c}: image mean {:.7} ± {:.1e} for {:.7}; allowed {allowed:.1e}",
                e.mean,
                e.std_error,
                expected[c]
            );
        }
    }

    /// Per-pixel means with their standard errors.
    pub fn estimates(&self) -> Vec<[Estimate; 3]> {
        self.pixels.iter().map(|p| p.map(|m| estimate(&m))).collect()
    }

    /// None if `other`, another renderer's estimates of the same region, agrees: in blocks of `block` × `block` pixels
    /// (averaging makes rare bright samples more normal) every channel's means differ by no more than Šidák's normal
    /// bound, family-wise 1 % over all blocks and channels. Otherwise the worst blocks. `abs_tol` is for rounding.
    pub fn disagreement(&self, other: &[[Estimate; 3]], block: usize, abs_tol: f64) -> Option<String> {
        let (w, h) = (self.region.width(), self.region.height());
        assert_eq!(other.len(), w * h, "regions differ");
        let ours = self.estimates();
        let mut worst = Vec::new();
        for (y, x) in (0..h).step_by(block).flat_map(|y| (0..w).step_by(block).map(move |x| (y, x))) {
            let inside = || (y..(y + block).min(h)).flat_map(|j| (x..(x + block).min(w)).map(move |i| j * w + i));
            for c in 0..3 {
                let (a, b) = (average(inside().map(|k| ours[k][c])), average(inside().map(|k| other[k][c])));
                let over = (a.mean - b.mean).abs() - abs_tol;
                let z = if over <= 0.0 { 0.0 } else { over / a.std_error.hypot(b.std_error) };
                worst.push((z, x, y, c, a, b));
            }
        }
        let allowed = z_bound(worst.len());
        worst.sort_by(|a, b| b.0.total_cmp(&a.0)); // NaN first
        let failed = worst.iter().filter(|t| t.0 > allowed || t.0.is_nan()).count();
        if failed == 0 {
            return None;
        }
        let n = worst.len();
        let mut s = format!("{failed} of {n} blocks × channels differ by more than {allowed:.2} standard errors\n");
        for (z, x, y, c, a, b) in worst.iter().take(10) {
            let [a, b] = [a, b].map(|e| format!("{:.6} ± {:.1e}", e.mean, e.std_error));
            let _ = writeln!(s, "  block at ({x}, {y}), channel {c}: {a} against {b}, {z:.2} σ");
        }
        Some(s)
    }
}

fn estimate(m: &Moments) -> Estimate {
    Estimate { mean: m.mean, std_error: m.std_error() }
}

fn average(estimates: impl Iterator<Item = Estimate>) -> Estimate {
    let (mut n, mut sum, mut variance) = (0.0, 0.0, 0.0);
    for e in estimates {
        n += 1.0;
        sum += e.mean;
        variance += e.std_error * e.std_error;
    }
    Estimate { mean: sum / n, std_error: f64::sqrt(variance) / n }
}
