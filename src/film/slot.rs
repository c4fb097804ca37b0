//! What one sample leaves on the film.

/// What a film keeps for each pixel. What it does not keep is not allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmChannels {
    /// RGB radiance and its square: 48 bytes a pixel for each block sum held.
    Colour,
    /// The same with [`AovSample`]s: 104 bytes a pixel for each block sum held.
    ColourAndAovs,
}

impl FilmChannels {
    /// f64 sums a pixel holds: 3 radiances, 3 squares, then 7 AOV values where they are kept.
    pub(crate) const fn stride(self) -> usize {
        match self {
            Self::Colour => COLOUR_SUMS,
            Self::ColourAndAovs => COLOUR_SUMS + AOV_SUMS,
        }
    }
}

pub(crate) const COLOUR_SUMS: usize = 6;
pub(crate) const AOV_SUMS: usize = 7;

/// The first hit of one camera sample. A sample that hits nothing leaves `AovSample::default()` (all zero).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AovSample {
    /// Reflectance per channel, in 0 … 1.
    pub albedo: [f32; 3],
    /// Unit shading normal in world space.
    pub normal: [f32; 3],
    /// Distance along the ray, in the scene's own unit.
    pub depth: f32,
}

impl AovSample {
    pub(crate) const fn values(&self) -> [f32; AOV_SUMS] {
        let ([r, g, b], [x, y, z]) = (self.albedo, self.normal);
        [r, g, b, x, y, z, self.depth]
    }
}
