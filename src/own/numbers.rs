//! Random numbers of a program's own.

/// A sampler: where a sample's numbers come from.
///
/// Dimensions are numbered as the kernel reserves them ([`dimensions`](crate::sampling::dimensions)): the camera's four,
/// then twelve for every bounce. A number belongs to its (pixel, sample, dimension) alone, or images would depend on which
/// lane and thread asked first.
pub trait Numbers: Send + Sync {
    /// In [0, 1) (others are held to it), uniform over pixels or over samples, or the estimate is biased. `pixel` counts
    /// row by row from the top left.
    fn number(&self, pixel: u32, sample: u32, dimension: u32) -> f32;
}
