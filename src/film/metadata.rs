//! Attributes of an image file: what it was rendered from, with and by.

use crate::sampling::SamplerKind;
use std::fmt;

/// A named attribute's value in an EXR header.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// UTF-8, stored as `string`.
    Text(String),
    /// Stored as `float`.
    Float(f32),
    /// Stored as `int` where that is exact, otherwise as a decimal `string`.
    Integer(u64),
}

impl fmt::Display for Attribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Float(value) => value.fmt(f),
            Self::Integer(value) => value.fmt(f),
        }
    }
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Attribute {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f32> for Attribute {
    fn from(value: f32) -> Self {
        Self::Float(value)
    }
}

impl From<u64> for Attribute {
    fn from(value: u64) -> Self {
        Self::Integer(value)
    }
}

/// Put before the names of attributes, some of which the format reserves.
pub(crate) const NAME_PREFIX: &str = "octolux.";

/// Name of the attribute that says what `variance.*` may be used for.
pub const VARIANCE_VALIDITY: &str = "variance_validity";

/// What s²/n means in the image at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VarianceValidity {
    /// Independent samples in a number chosen beforehand: unbiased for the variance of the mean.
    Independent,
    /// A stratified or low-discrepancy sampler: overstates it.
    Correlated,
    /// The number of samples was chosen by looking at their values: both mean and s²/n are biased by O(1/n).
    Stopped,
    /// Samples share point sets: what these err by is in every sample, and s²/n does not see it.
    Shared,
}

impl VarianceValidity {
    const ALL: [Self; 4] = [Self::Independent, Self::Correlated, Self::Stopped, Self::Shared];

    /// Of a number of samples chosen beforehand.
    pub fn of(sampler: SamplerKind, shares_points: bool) -> Self {
        match sampler {
            _ if shares_points => Self::Shared,
            SamplerKind::Independent => Self::Independent,
            _ => Self::Correlated,
        }
    }

    /// The attribute's text: a key word, then what it means.
    pub fn text(self) -> &'static str {
        match self {
            Self::Independent => "independent: s^2/n is the unbiased variance of the mean; valid for z-scores",
            Self::Correlated => "correlated: the sampler stratifies and s^2/n overstates the variance of the mean",
            Self::Stopped => "stopped: the sample count depends on sample values; mean and s^2/n are biased by O(1/n)",
            Self::Shared => "shared: samples share point sets; s^2/n leaves out the error that all of them have",
        }
    }

    /// The inverse of [`Self::text`], by its key word.
    pub fn parse(text: &str) -> Option<Self> {
        let key = |text: &str| text.split(':').next().map(|word| word.trim().to_ascii_lowercase());
        Self::ALL.into_iter().find(|validity| key(validity.text()) == key(text))
    }
}
