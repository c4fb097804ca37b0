//! A film's sums as bytes, little-endian, tile after tile: what a state file holds.
//!
//! A tile: number of the next sample (u64), dropped samples and AOVs (2 × u64), how many of them are remembered (u32)
//! and each of these (x, y: u32, sample: u64), number of nodes (u32), each node (level: u32, index: u64, sums: f64),
//! then the sums of the unfinished block where there is one, and, where there are samples, the largest of each pixel and channel
//! (f32).

use std::io::{self, Read, Write};

use super::blocks::{BLOCK, BlockTree, Node};
use super::discarded::{Discarded, DiscardedSample, REMEMBERED};
use super::sheet::Film;
use super::slot::FilmChannels;
use super::tile::{Rect, TileFilm};

/// Bytes of a tile that holds nothing.
const LEAST_TILE_BYTES: u64 = 8 + 2 * 8 + 4 + 4;

/// Size and form of a film, known before its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmShape {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Side of a tile in pixels.
    pub tile: u32,
    /// Kept of each sample.
    pub channels: FilmChannels,
}

impl Film {
    /// What [`Film::encode`] leaves out.
    pub fn shape(&self) -> FilmShape {
        FilmShape { width: self.width(), height: self.height(), tile: self.tile_side(), channels: self.channels() }
    }

    /// Writes the sums; [`Film::decode`] reads them.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn encode(&self, out: &mut impl Write) -> io::Result<()> {
        let mut scratch = Vec::new();
        self.tiles().iter().try_for_each(|tile| encode_tile(tile, out, &mut scratch))
    }

    /// Bytes that [`Film::encode`] writes.
    pub fn encoded_bytes(&self) -> u64 {
        let sums = |tile: &TileFilm| {
            (tile.whole.nodes.len() as u64 + 1) * sum_bytes(tile.rect(), self.channels()) + largest_bytes(tile.rect())
        };
        self.tiles().iter().map(|tile| LEAST_TILE_BYTES + sums(tile)).sum()
    }

    /// Reads what [`Film::encode`] wrote: exactly `length` bytes of `input`. Nothing is allocated that these bytes could
    /// not fill.
    ///
    /// # Errors
    /// What is wrong with the bytes, in one line.
    pub fn decode(shape: FilmShape, input: &mut impl Read, length: u64) -> Result<Film, String> {
        let side = u64::from(shape.tile.max(1));
        let tiles = u64::from(shape.width).div_ceil(side) * u64::from(shape.height).div_ceil(side);
        if tiles.saturating_mul(LEAST_TILE_BYTES) > length {
            return Err(format!("is too short for {} × {} pixels", shape.width, shape.height));
        }
        let mut film = Film::new(shape.width, shape.height, shape.tile, shape.channels, 0);
        let mut source = Source { input, left: length, scratch: Vec::new() };
        film.tiles_mut().iter_mut().try_for_each(|tile| decode_tile(tile, &mut source))?;
        if source.left > 0 { Err(format!("has {} bytes too many", source.left)) } else { Ok(film) }
    }
}

fn sum_bytes(rect: Rect, channels: FilmChannels) -> u64 {
    8 * rect.pixels() as u64 * channels.stride() as u64
}

fn largest_bytes(rect: Rect) -> u64 {
    12 * rect.pixels() as u64
}

fn encode_tile(tile: &TileFilm, out: &mut impl Write, scratch: &mut Vec<u8>) -> io::Result<()> {
    let Discarded { count, aov_count, first } = &tile.discarded;
    for value in [tile.next_sample, *count, *aov_count] {
        out.write_all(&value.to_le_bytes())?;
    }
    out.write_all(&(first.len() as u32).to_le_bytes())?;
    for DiscardedSample { x, y, sample } in first {
        out.write_all(&x.to_le_bytes())?;
        out.write_all(&y.to_le_bytes())?;
        out.write_all(&sample.to_le_bytes())?;
    }
    out.write_all(&(tile.whole.nodes.len() as u32).to_le_bytes())?;
    let mut put = |sums: &[f64], out: &mut dyn Write| {
        scratch.clear();
        scratch.extend(sums.iter().flat_map(|sum| sum.to_le_bytes()));
        out.write_all(scratch)
    };
    for Node { level, index, sums } in &tile.whole.nodes {
        out.write_all(&level.to_le_bytes())?;
        out.write_all(&index.to_le_bytes())?;
        put(sums, out)?;
    }
    if tile.is_inside_block() {
        put(&tile.partial, out)?;
    }
    if tile.samples() == 0 {
        return Ok(());
    }
    scratch.clear();
    scratch.extend(tile.largest.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
    out.write_all(scratch)
}

fn decode_tile<R: Read>(tile: &mut TileFilm, source: &mut Source<'_, R>) -> Result<(), String> {
    let sums = tile.rect().pixels() * tile.channels().stride();
    tile.next_sample = source.u64()?;
    tile.discarded = Discarded { count: source.u64()?, aov_count: source.u64()?, first: Vec::new() };
    let remembered = source.u32()? as usize;
    if remembered > REMEMBERED {
        return Err(DAMAGED.to_owned());
    }
    for _ in 0..remembered {
        let (x, y) = (source.u32()?, source.u32()?);
        tile.discarded.first.push(DiscardedSample { x, y, sample: source.u64()? });
    }
    let nodes = source.u32()?;
    let mut whole = BlockTree::default();
    for _ in 0..nodes {
        let (level, index) = (source.u32()?, source.u64()?);
        whole.append(Node { level, index, sums: source.sums(sums)? }).ok_or(DAMAGED)?;
    }
    let finished = tile.next_sample / BLOCK;
    if whole.end_block().is_some_and(|end| end > finished) || tile.next_sample > 1 << 32 {
        return Err(DAMAGED.to_owned());
    }
    tile.whole = whole;
    tile.partial = if tile.is_inside_block() { source.sums(sums)? } else { Vec::new() };
    tile.largest = if tile.samples() > 0 { source.largest(tile.rect())? } else { Vec::new() };
    Ok(())
}

const DAMAGED: &str = "is damaged: its sums do not fit together";

/// Bytes of which a known number is left.
struct Source<'a, R> {
    input: &'a mut R,
    left: u64,
    scratch: Vec<u8>,
}

impl<R: Read> Source<'_, R> {
    fn take(&mut self, bytes: u64) -> Result<(), String> {
        self.left = self.left.checked_sub(bytes).ok_or("ends too early")?;
        Ok(())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.take(N as u64)?;
        let mut bytes = [0; N];
        self.input.read_exact(&mut bytes).map_err(|error| error.to_string())?;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.array().map(u64::from_le_bytes)
    }

    fn largest(&mut self, rect: Rect) -> Result<Vec<[f32; 3]>, String> {
        self.bytes(largest_bytes(rect))?;
        let values: Vec<f32> = self.scratch.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        Ok(values.as_chunks::<3>().0.to_vec())
    }

    /// So many bytes into the scratch.
    fn bytes(&mut self, count: u64) -> Result<(), String> {
        self.take(count)?;
        self.scratch.resize(count as usize, 0);
        self.input.read_exact(&mut self.scratch).map_err(|error| error.to_string())
    }

    fn sums(&mut self, count: usize) -> Result<Vec<f64>, String> {
        self.bytes(8 * count as u64)?;
        Ok(self.scratch.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
    }
}
