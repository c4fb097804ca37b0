//! How much single samples weigh in an image: whether its errors, as it estimates them itself, can be relied on.
//!
//! Where the variance is infinite, or the light is met by a few samples in thousands, s²/n is too small in most images and far
//! too large in a few, and mean ± 1.96·√(s²/n) holds the truth less often than 95 %. One sample's share tells: k equal hits
//! among black samples have 1/k each.

use super::sheet::Film;
use rayon::prelude::*;

/// Of a value's sum, at one sample. Of rare equal hits ten have it: an interval that holds fewer is wrong most often (exact
/// Poisson sums at 95 %: 20 % of intervals at 3 expected hits, all but 1 % at .01), and of the rest never more than the 7 % at
/// 30 hits are wrong.
pub const LARGEST_TRUSTED_OF_VALUE: f64 = 0.1;

/// Of the squared relative error of an image, at one sample.
pub const LARGEST_TRUSTED_OF_ERROR: f64 = 0.01;

/// Of the squared relative error, at values of which one sample has more than [`LARGEST_TRUSTED_OF_VALUE`]: it then says little
/// of what it has not met. Simulated with exponentials of normal values of deviation σ, the squared error is found to be
/// .88, .73, .54, .18, .03 of itself at 64 samples and σ = 1, 1.25, 1.5, 2, 2.5, where doubtful values make up 63, 88, 97, 99.8 and 100 % of
/// it; of exponential values, whose squared error is found at .99, they make up 12 %.
pub const MOST_TRUSTED_DOUBTFUL: f64 = 0.75;

/// See the [module](self). A value is a channel of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct SampleShares {
    /// Values of the image: three a pixel.
    pub values: u64,
    /// The largest sample's part of the squared relative error ([`Film::relative_error`]), 0 … 1.
    pub largest_of_error: f64,
    /// The pixel (column, row) that it belongs to.
    pub at: (u32, u32),
    /// Values of which one sample makes up more than [`LARGEST_TRUSTED_OF_VALUE`].
    pub doubtful: u64,
    /// Their part of the squared relative error, 0 … 1.
    pub doubtful_of_error: f64,
    /// Values that no sample has brought any light: an interval of 0 ± 0 knows nothing of what no sample has met.
    pub dark: u64,
}

impl SampleShares {
    /// Is the relative error more than a lower bound?
    pub fn error_trusted(&self) -> bool {
        self.largest_of_error <= LARGEST_TRUSTED_OF_ERROR && self.doubtful_of_error <= MOST_TRUSTED_DOUBTFUL
    }

    /// Takes in a row below; shares are still parts of a sum to come.
    fn and(self, below: Self) -> Self {
        let larger = if below.largest_of_error > self.largest_of_error { below } else { self };
        SampleShares {
            values: self.values + below.values,
            doubtful: self.doubtful + below.doubtful,
            doubtful_of_error: self.doubtful_of_error + below.doubtful_of_error,
            dark: self.dark + below.dark,
            ..larger
        }
    }
}

impl Film {
    /// Of an image whose [`Film::relative_error`] is `error`.
    pub fn sample_shares(&self, error: f64) -> SampleShares {
        let rows = (0..self.height()).into_par_iter().map(|y| self.row_shares(y)).collect::<Vec<_>>();
        let all = rows.into_iter().fold(SampleShares::default(), SampleShares::and);
        let squares = error * error * all.values as f64;
        let share = |part: f64| if squares > 0.0 { (part / squares).min(1.0) } else { 0.0 };
        let (largest_of_error, doubtful_of_error) = (share(all.largest_of_error), share(all.doubtful_of_error));
        SampleShares { largest_of_error, doubtful_of_error, ..all }
    }

    fn row_shares(&self, y: u32) -> SampleShares {
        let mut row = SampleShares { at: (0, y), ..SampleShares::default() };
        for x in 0..self.width() {
            let (pixel, largest) = (self.pixel(x, y), self.largest(x, y));
            let (n, mean, variance) =
                (pixel.samples as f64, pixel.mean(), pixel.variance_of_mean().unwrap_or_default());
            for c in 0..3 {
                row.values += 1;
                let (sum, largest) = (pixel.sum[c].abs(), f64::from(largest[c]));
                let weight = 1.0 / (mean[c] * mean[c] + 0.01);
                row.dark += u64::from(largest == 0.0);
                if largest > LARGEST_TRUSTED_OF_VALUE * sum {
                    row.doubtful += 1;
                    row.doubtful_of_error += variance[c] * weight;
                }
                // Its term of s²/n.
                let part = (largest - mean[c].abs()).powi(2) / (n * (n - 1.0)) * weight;
                if part > row.largest_of_error {
                    (row.largest_of_error, row.at) = (part, (x, y));
                }
            }
        }
        row
    }
}

impl std::fmt::Display for SampleShares {
    /// A line for each thing that is to be said; nothing where all is well.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.error_trusted() {
            let ((x, y), share) = (self.at, 100.0 * self.largest_of_error);
            writeln!(
                f,
                "this error is not to be trusted: few samples carry it, the largest, of pixel {x},{y}, {share:.2} % of its square"
            )?;
        }
        if self.doubtful > 0 {
            let (values, part) = (self.doubtful as f64 / self.values.max(1) as f64, self.doubtful_of_error);
            writeln!(
                f,
                "variances not to be trusted: {:.2} % of values, {:.0} % of the squared error, where one sample makes up more than a tenth",
                100.0 * values,
                100.0 * part
            )?;
        }
        Ok(())
    }
}
