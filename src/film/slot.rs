//! What one sample leaves on the film.

/// What a film keeps for each pixel. What it does not keep is not allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmChannels {
    /// RGB radiance and its square: 48 bytes a pixel for each block sum held.
    Colour,
    /// The same with [`AovSample`]s: 104 bytes a pixel for each block sum held.
    ColourAndAovs,
    /// And with their [posterior variances](AovSample::posterior): 128 bytes.
    ColourAovsAndPosterior,
}

impl FilmChannels {
    /// Posterior variances come with AOVs alone.
    pub const fn of(aovs: bool, posterior: bool) -> Self {
        match (aovs, posterior) {
            (false, _) => Self::Colour,
            (true, false) => Self::ColourAndAovs,
            (true, true) => Self::ColourAovsAndPosterior,
        }
    }

    /// Are first-hit features kept?
    pub const fn has_aovs(self) -> bool {
        !matches!(self, Self::Colour)
    }

    /// Does it keep a posterior variance?
    pub const fn has_posterior(self) -> bool {
        matches!(self, Self::ColourAovsAndPosterior)
    }

    /// f64 sums a pixel holds: 3 radiances, 3 squares, then 7 AOV values and 3 posterior variances where they are kept.
    pub(crate) const fn stride(self) -> usize {
        match self {
            Self::Colour => COLOUR_SUMS,
            Self::ColourAndAovs => COLOUR_SUMS + AOV_SUMS,
            Self::ColourAovsAndPosterior => MOST_SUMS,
        }
    }
}

pub(crate) const COLOUR_SUMS: usize = 6;
pub(crate) const AOV_SUMS: usize = 7;
/// What the widest film holds.
pub(crate) const MOST_SUMS: usize = COLOUR_SUMS + AOV_SUMS + 3;

/// The first hit of one camera sample. A sample that hits nothing leaves `AovSample::default()` (all zero).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AovSample {
    /// Reflectance per channel, in 0 … 1.
    pub albedo: [f32; 3],
    /// Unit shading normal in world space.
    pub normal: [f32; 3],
    /// Distance along the ray, in the scene's own unit.
    pub depth: f32,
    /// Variance of the sample's own estimate as its estimator believes it, per channel.
    pub posterior: [f32; 3],
}

impl AovSample {
    /// In the order of the sums: a film may want fewer.
    pub(crate) const fn values(&self) -> [f32; AOV_SUMS + 3] {
        let ([r, g, b], [x, y, z], [pr, pg, pb]) = (self.albedo, self.normal, self.posterior);
        [r, g, b, x, y, z, self.depth, pr, pg, pb]
    }
}
