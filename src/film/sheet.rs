//! The whole film: a grid of tiles, and the estimates read from it.

use rayon::prelude::*;

use super::discarded::Discarded;
use super::error::MergeError;
use super::pixel::{Aovs, PixelSums};
use super::slot::FilmChannels;
use super::tile::{Rect, TileFilm};

/// An image under way. Row 0 is the top. Every value read from it is the same for any tile size.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    tile: u32,
    tiles_across: u32,
    channels: FilmChannels,
    tiles: Vec<TileFilm>,
}

impl Film {
    /// An empty film of `width × height` pixels in square tiles of side `tile` (at least 1), smaller at the right and
    /// bottom edge. The first sample of each pixel will be number `64 · first_block`.
    pub fn new(width: u32, height: u32, tile: u32, channels: FilmChannels, first_block: u64) -> Self {
        let tile = tile.max(1);
        let (across, down) = (width.div_ceil(tile), height.div_ceil(tile));
        let corners = (0..down).flat_map(|j| (0..across).map(move |i| (i * tile, j * tile)));
        let tiles = corners
            .map(|(x, y)| Rect { x, y, width: tile.min(width - x), height: tile.min(height - y) })
            .map(|rect| TileFilm::new(rect, channels, first_block))
            .collect();
        Self { width, height, tile, tiles_across: across, channels, tiles }
    }

    /// Pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Kept of each sample.
    pub fn channels(&self) -> FilmChannels {
        self.channels
    }

    /// Side of a tile in pixels.
    pub fn tile_side(&self) -> u32 {
        self.tile
    }

    /// Tiles row by row from the top left.
    pub fn tiles(&self) -> &[TileFilm] {
        &self.tiles
    }

    /// For a pass: each tile may be filled by another thread.
    pub fn tiles_mut(&mut self) -> &mut [TileFilm] {
        &mut self.tiles
    }

    /// Samples that every pixel has at least: all of them have it between passes.
    pub fn samples(&self) -> u64 {
        self.tiles.iter().map(TileFilm::samples).min().unwrap_or(0)
    }

    /// Mean over pixels of the samples that they have.
    pub fn mean_samples(&self) -> f64 {
        let of_tile = |tile: &TileFilm| tile.samples() as f64 * tile.rect().pixels() as f64;
        let pixels = f64::from(self.width) * f64::from(self.height);
        self.tiles.iter().map(of_tile).sum::<f64>() / pixels.max(1.0)
    }

    /// Have some pixels more samples than others?
    pub fn is_uneven(&self) -> bool {
        self.tiles.iter().any(|tile| tile.samples() != self.tiles[0].samples())
    }

    /// The number of the next sample of the pixels that have least.
    pub fn next_sample(&self) -> u64 {
        self.tiles.iter().map(TileFilm::next_sample).min().unwrap_or(0)
    }

    /// Sums of the pixel in column `x < width`, row `y < height`.
    pub fn pixel(&self, x: u32, y: u32) -> PixelSums {
        self.tile_at(x, y).pixel(x, y)
    }

    /// The tile of a pixel.
    pub(super) fn tile_at(&self, x: u32, y: u32) -> &TileFilm {
        &self.tiles[(y / self.tile) as usize * self.tiles_across as usize + (x / self.tile) as usize]
    }

    /// See [`TileFilm::largest`].
    pub fn largest(&self, x: u32, y: u32) -> [f32; 3] {
        self.tile_at(x, y).largest(x, y)
    }

    /// See [`PixelSums::mean`].
    pub fn mean(&self, x: u32, y: u32) -> [f64; 3] {
        self.pixel(x, y).mean()
    }

    /// See [`PixelSums::variance_of_mean`].
    pub fn variance_of_mean(&self, x: u32, y: u32) -> Option<[f64; 3]> {
        self.pixel(x, y).variance_of_mean()
    }

    /// See [`PixelSums::posterior_variance`].
    pub fn posterior_variance(&self, x: u32, y: u32) -> Option<[f64; 3]> {
        self.pixel(x, y).posterior_variance()
    }

    /// See [`PixelSums::aovs`].
    pub fn aovs(&self, x: u32, y: u32) -> Option<Aovs> {
        self.pixel(x, y).aovs()
    }

    /// What all tiles dropped.
    pub fn discarded(&self) -> Discarded {
        let mut all = Discarded::default();
        self.tiles.iter().for_each(|tile| all.absorb(tile.discarded()));
        all
    }

    /// Adds what was dropped of an estimate [added](TileFilm::add_estimate) to it.
    pub fn note_discarded(&mut self, discarded: &Discarded) {
        self.tiles.iter_mut().take(1).for_each(|tile| tile.discarded.absorb(discarded));
    }

    /// The estimated relative error E = √(mean over pixels and channels of var/(mean² + 0.01)), var being the variance
    /// of the mean; `None` while some pixel has fewer than two samples, or without pixels.
    ///
    /// Rows are taken in parallel in the current rayon pool and added in order, so E has the same bits on any machine.
    pub fn relative_error(&self) -> Option<f64> {
        let rows: Vec<f64> = (0..self.height).into_par_iter().map(|y| self.row_error(y)).collect::<Option<_>>()?;
        let values = 3.0 * f64::from(self.width) * f64::from(self.height);
        (values > 0.0).then(|| (rows.iter().sum::<f64>() / values).sqrt())
    }

    fn row_error(&self, y: u32) -> Option<f64> {
        let mut sum = 0.0;
        for x in 0..self.width {
            let pixel = self.pixel(x, y);
            let (mean, variance) = (pixel.mean(), pixel.variance_of_mean()?);
            for c in 0..3 {
                sum += variance[c] / (mean[c] * mean[c] + 0.01);
            }
        }
        Some(sum)
    }

    /// Does it hold all samples of each pixel that `other`, a film of the same image, holds? (Where tiles are of another size, by the
    /// first.)
    pub fn covers(&self, other: &Self) -> bool {
        let covered = |(own, theirs): (&TileFilm, &TileFilm)| {
            own.whole.covers(&theirs.whole) && own.next_sample >= theirs.next_sample
        };
        let tiles = if self.tile == other.tile { self.tiles.len() } else { 1 };
        self.tiles.iter().zip(&other.tiles).take(tiles).all(covered)
    }

    /// Takes over samples of the same image that were rendered elsewhere, bit for bit as if rendered here.
    ///
    /// # Errors
    /// The films differ in size or channels, tiles of another size stand at different samples, or some tile cannot be merged ([`TileFilm::merge`]; tiles
    /// before it are then merged already, so the film is to be thrown away).
    pub fn merge(&mut self, other: Self) -> Result<(), MergeError> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(MergeError::Shape);
        }
        let other = if other.tile == self.tile { other } else { other.retiled(self.tile).ok_or(MergeError::Tiles)? };
        self.tiles.iter_mut().zip(other.tiles).try_for_each(|(tile, theirs)| tile.merge(theirs))
    }
}
