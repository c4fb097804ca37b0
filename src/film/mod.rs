//! The film: f64 accumulation of samples per pixel, their variance, and the image files made of them.
//!
//! A [`Film`] is a grid of [`TileFilm`]s. A render pass writes every path's radiance to its (pixel, sample) slot and
//! hands the slots to the tile; the tile adds them **in sample order**, in f64, within aligned blocks of
//! [`BLOCK`] samples, and combines whole blocks in a dyadic tree ([`blocks`]). The result is therefore a function of
//! the set of samples alone: not of tile size, thread count, pass size, or of which machine rendered which blocks.
//!
//! Files: [`exr_write`], [`exr_read`], [`png`]; all are written beside their target and renamed ([`beside`]).

pub mod beside;
pub mod blocks;
pub mod checksum;
pub mod codec;
pub mod discarded;
pub mod error;
mod exr_chunks;
mod exr_colours;
pub mod exr_read;
pub mod exr_write;
pub mod metadata;
pub mod pixel;
pub mod png;
mod retile;
pub mod shares;
pub mod sheet;
pub mod slot;
pub mod tile;

pub use blocks::BLOCK;
pub use discarded::{Discarded, DiscardedSample};
pub use error::{FilmError, MergeError};
pub use exr_read::{ExrImage, read_exr};
pub use exr_write::write_exr;
pub use metadata::{Attribute, VarianceValidity};
pub use pixel::{Aovs, PixelSums};
pub use png::write_png;
pub use shares::SampleShares;
pub use sheet::Film;
pub use slot::{AovSample, FilmChannels};
pub use tile::{Rect, TileFilm};
