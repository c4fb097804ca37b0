//! What the `exr` crate believes of a chunk and should not: looked at before it is decompressed.

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::error::{Error, UnitResult};
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::{Compression, Vec2};
use std::collections::HashSet;

/// A DWA chunk starts with so many counters of eight bytes.
const DWA_COUNTERS: usize = 11;
/// Which of them say how much is unpacked: bytes that are neither DCT nor runs, runs before and after unpacking, and numbers of DCT
/// coefficients of two bytes.
const DWA_UNPACKED: [usize; 5] = [1, 6, 7, 8, 9];
/// DCT coefficients are of so many pixels a side, the last of them beyond the image.
const DCT_SIDE: usize = 8;

/// Whether a chunk of a file with this header can be decompressed without harm. Empty ones can be of no image.
pub fn check(chunk: &Chunk, header: &Header) -> UnitResult {
    let packed = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    if packed.is_empty() {
        return Err(Error::Invalid("a chunk is empty".into()));
    }
    if matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        let counters = packed.as_chunks::<8>().0.iter().map(|&bytes| u64::from_le_bytes(bytes));
        let most = most_unpacked(header);
        if counters.take(DWA_COUNTERS).enumerate().any(|(which, count)| DWA_UNPACKED.contains(&which) && count > most) {
            return Err(Error::Invalid("a chunk claims more than it can hold".into()));
        }
    }
    Ok(())
}

/// Bytes of a whole block, and as many again: runs may be longer than what they stand for. Memory is made for what the counters
/// say, so that a damaged one would ask for all there is.
fn most_unpacked(header: &Header) -> u64 {
    let size = match header.blocks {
        BlockDescription::Tiles(tiles) => tiles.tile_size,
        BlockDescription::ScanLines => Vec2(header.layer_size.width(), header.compression.scan_lines_per_block()),
    };
    let padded = [size.width(), size.height()].map(|side| side.next_multiple_of(DCT_SIDE) as u64);
    2 * padded[0] * padded[1] * header.channels.bytes_per_pixel as u64
}

/// Which parts of an image have been read: a second chunk for one would stand for another that is missing.
#[derive(Default)]
pub struct Covered(HashSet<[usize; 2]>);

impl Covered {
    /// The block whose first pixel is at this column and row of the data.
    pub fn add(&mut self, column: usize, row: usize) -> UnitResult {
        if self.0.insert([column, row]) { Ok(()) } else { Err(Error::Invalid("a chunk is there twice".into())) }
    }
}
