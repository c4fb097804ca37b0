//! A pixel's sums, and what they estimate.

use super::slot::{AOV_SUMS, FilmChannels, MOST_SUMS};

/// Sums over all samples of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSums {
    /// Samples taken, dropped ones included.
    pub samples: u64,
    /// Σ x per channel.
    pub sum: [f64; 3],
    /// Σ x² per channel.
    pub sum_of_squares: [f64; 3],
    aov_sums: Option<[f64; AOV_SUMS]>,
    posterior_sums: Option<[f64; 3]>,
}

/// Means of the first-hit values of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aovs {
    /// Mean reflectance.
    pub albedo: [f64; 3],
    /// Mean of unit normals: shorter than 1 where they differ.
    pub normal: [f64; 3],
    /// Samples that hit nothing count as 0.
    pub depth: f64,
}

impl PixelSums {
    /// From the film's layout: 3 sums, 3 sums of squares, 7 AOV sums and 3 of posterior variances where they are kept.
    pub(crate) fn new(samples: u64, sums: &[f64; MOST_SUMS], channels: FilmChannels) -> Self {
        let [r, g, b, rr, gg, bb, aov_sums @ .., pr, pg, pb] = *sums;
        Self {
            samples,
            sum: [r, g, b],
            sum_of_squares: [rr, gg, bb],
            aov_sums: channels.has_aovs().then_some(aov_sums),
            posterior_sums: channels.has_posterior().then_some([pr, pg, pb]),
        }
    }

    /// Radiance, W·sr⁻¹·m⁻² per channel; 0 without samples.
    pub fn mean(&self) -> [f64; 3] {
        let n = self.samples.max(1) as f64;
        self.sum.map(|sum| sum / n)
    }

    /// s²/n with the unbiased s², never negative; `None` below two samples.
    ///
    /// Unbiased for the variance of [`Self::mean`] when samples are independent; under a stratified or low-discrepancy
    /// sampler it overstates it. n Σx² − (Σx)² is taken as a difference of products, so the error is that of the two
    /// sums alone: a few ulp of their f64 values, about 1e-15 (mean² + s²).
    pub fn variance_of_mean(&self) -> Option<[f64; 3]> {
        if self.samples < 2 {
            return None;
        }
        let n = self.samples as f64;
        Some(std::array::from_fn(|c| {
            let scaled = difference_of_products(n, self.sum_of_squares[c], self.sum[c], self.sum[c]);
            scaled.max(0.0) / (n * n * (n - 1.0))
        }))
    }

    /// Σv/n², v what each sample's estimator believes its own variance to be: that of [`Self::mean`] if the samples'
    /// errors are independent. `None` on a film that does not keep it.
    pub fn posterior_variance(&self) -> Option<[f64; 3]> {
        let n = self.samples.max(1) as f64;
        self.posterior_sums.map(|sums| sums.map(|sum| sum / (n * n)))
    }

    /// `None` on a film without AOVs; zero without samples.
    pub fn aovs(&self) -> Option<Aovs> {
        let n = self.samples.max(1) as f64;
        let [ar, ag, ab, x, y, z, depth] = self.aov_sums?.map(|sum| sum / n);
        Some(Aovs { albedo: [ar, ag, ab], normal: [x, y, z], depth })
    }
}

/// a b − c d within 1.5 ulp (Jeannerod, Louvet, Muller 2013, "Further analysis of Kahan's algorithm").
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let cd_error = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + cd_error
}
