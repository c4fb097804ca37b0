//! A cell: one variant at one budget with one seed.

use serde::{Deserialize, Serialize};

/// What a render may spend.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Budget {
    /// Samples a pixel.
    Samples(u64),
    /// Seconds of rendering. A discarded pilot turns them into a number of samples, the same for all seeds, so that
    /// estimates stay unbiased; the seconds reported are those that the cells took.
    Seconds(f64),
}

impl std::fmt::Display for Budget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Budget::Samples(n) => write!(f, "{n} spp"),
            Budget::Seconds(s) => write!(f, "{s} s"),
        }
    }
}

/// Which cell: what decides its image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellKey {
    /// The variant's arguments.
    pub variant: String,
    pub budget: Budget,
    pub seed: u64,
}

/// A finished cell. Its image is in [`Self::image`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    #[serde(flatten)]
    pub key: CellKey,
    pub samples_per_pixel: u64,
    /// From the first sample traced to the finished film.
    pub render_seconds: f64,
    /// Writing the image with its variance.
    pub output_seconds: f64,
    pub paths: u64,
    pub rays: u64,
    /// Samples that were not finite.
    pub discarded_samples: u64,
    /// Squared relative error as the image's own variances have it, and the largest sample's part of it, 0 … 1; `None` of
    /// one sample a pixel.
    pub estimated_error: Option<f64>,
    pub largest_sample_share: Option<f64>,
    /// File below the study's folder.
    pub image: String,
}
