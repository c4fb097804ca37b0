//! OpenEXR to f32 planes: any flat file with R, G, B (or one layer `NAME.R/G/B`, or Y alone) in half, float or uint.
//!
//! The image is what the display window shows. The data window may hold less of it (the rest is 0) or reach beyond.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use exr::block::reader::{ChunksReader, Reader};
use exr::block::{UncompressedBlock, chunk::Chunk};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{Vec2, f16};
use rayon::prelude::*;

use super::beside::is_stream;
use super::error::FilmError;
use super::exr_chunks::{self, Covered};
use super::exr_colours::{find_colour, string};
use super::metadata::{Attribute, NAME_PREFIX, VARIANCE_VALIDITY, VarianceValidity};

/// Longest side that is read: what a scene file may ask for.
const MAX_SIDE: usize = 65_536;

/// A header may ask for this much memory whatever the file's length: the image of one colour that compresses to nothing.
const ALWAYS_ALLOWED_BYTES: u64 = 1 << 28;

/// Beyond that, at most this many bytes for each byte of the file: deflate reaches 1032.
const MAX_EXPANSION: u64 = 2_000;

/// Chunks decompressed in parallel at a time.
const CHUNKS_IN_FLIGHT: usize = 64;

/// An image in memory, row 0 on top. Planes are row-major, `width · height` values each.
#[derive(Clone, Debug)]
pub struct ExrImage {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Name and plane of the channels of the part that holds the colour.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Text, float and integer attributes of the header, sorted by name.
    pub attributes: Vec<(String, Attribute)>,
    colour: [usize; 3],
}

impl ExrImage {
    /// Planes of red, green, blue; the same plane three times for a grey image.
    pub fn rgb(&self) -> [&[f32]; 3] {
        self.colour.map(|c| self.channels[c].1.as_slice())
    }

    /// Whether errors can be measured against it.
    ///
    /// # Errors
    /// Colours that are not finite, which every mean would leave out, in one line.
    pub fn check_reference(&self) -> Result<(), String> {
        match self.rgb().into_iter().flatten().filter(|x| !x.is_finite()).count() {
            0 => Ok(()),
            count => Err(format!("{count} of its values are not finite; mend it, or give another reference")),
        }
    }

    /// A channel by its full name, row by row from the top.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(known, _)| known == name).map(|(_, plane)| plane.as_slice())
    }

    /// Planes of the variance of the mean, if the file has them.
    pub fn variance(&self) -> Option<[&[f32]; 3]> {
        Some([self.channel("variance.R")?, self.channel("variance.G")?, self.channel("variance.B")?])
    }

    /// Metadata by name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }

    /// What the file says its variance may be used for; `None` where it says nothing that is known here.
    pub fn variance_validity(&self) -> Option<VarianceValidity> {
        match self.attribute(VARIANCE_VALIDITY)? {
            Attribute::Text(text) => VarianceValidity::parse(text),
            _ => None,
        }
    }
}

/// Reads the first part that holds a colour image. Decompresses in the current rayon pool.
///
/// # Errors
/// No such file, not an EXR, no colour channels or those of several layers, deep or subsampled data, a damaged file, or a header that asks for a
/// size that such a file cannot hold; one line that names `path`.
pub fn read_exr(path: &Path) -> Result<ExrImage, FilmError> {
    read(path).map_err(|why| FilmError::read(path, why))
}

fn read(path: &Path) -> Result<ExrImage, String> {
    if is_stream(path) {
        return Err("it is not a regular file".to_owned());
    }
    let file = File::open(path).map_err(|error| error.to_string())?;
    let status = file.metadata().map_err(|error| error.to_string())?;
    decode(BufReader::new(file), status.len())
}

/// Reads an image from `length` bytes that hold an EXR file, as [`read_exr`] does.
///
/// # Errors
/// What is wrong with the bytes, in one line.
pub fn decode(bytes: impl Read + Seek, length: u64) -> Result<ExrImage, String> {
    decode_kept(bytes, length, |_| true)
}

/// As [`decode`], but without channels other than the colours and `A`: a render's layers are many times its image.
///
/// # Errors
/// As [`decode`].
pub fn decode_colours(bytes: impl Read + Seek, length: u64) -> Result<ExrImage, String> {
    decode_kept(bytes, length, |name| name == "A")
}

/// Keeps the colours and what `is_wanted`.
fn decode_kept(bytes: impl Read + Seek, length: u64, is_wanted: impl Fn(&str) -> bool) -> Result<ExrImage, String> {
    let reader = exr::block::read(bytes, false).map_err(|error| describe(&error))?;
    let (part, colour) = find_colour(reader.headers())?;
    let header = &reader.headers()[part];
    check_size(reader.headers(), header, length)?;

    let Vec2(width, height) = header.shared_attributes.display_window.size;
    let names = header.channels.list.iter().map(|c| string(&c.name)).enumerate();
    let (kept, names): (Vec<usize>, Vec<String>) =
        names.filter(|(c, name)| colour.contains(c) || is_wanted(name)).unzip();
    let mut image = ExrImage {
        width: width as u32,
        height: height as u32,
        channels: names.into_iter().map(|name| (name, vec![0.0; width * height])).collect(),
        attributes: attributes(header),
        // In order, and the colours among them.
        colour: colour.map(|channel| kept.partition_point(|&c| c < channel)),
    };
    read_planes(reader, part, &kept, &mut image).map_err(|error| describe(&error))?;
    Ok(image)
}

/// `kept`: which of the file's channels are the image's, in order.
fn read_planes<R: Read + Seek>(
    reader: Reader<R>,
    part: usize,
    kept: &[usize],
    image: &mut ExrImage,
) -> exr::error::UnitResult {
    let mut chunks =
        reader.filter_chunks(true, |_, tile, block| block.layer == part && tile.is_largest_resolution_level())?;
    let meta = chunks.meta_data().clone();
    let size = meta.headers[part].layer_size;
    let (mut pixels_read, mut covered) = (0, Covered::default());
    loop {
        let batch: Vec<Chunk> = chunks.by_ref().take(CHUNKS_IN_FLIGHT).collect::<exr::error::Result<_>>()?;
        if batch.is_empty() {
            break;
        }
        let blocks: Vec<_> = batch.into_par_iter().map(|chunk| decompress(chunk, &meta)).collect();
        for block in blocks {
            let block = block?;
            if block.index.layer != part {
                return Err(exr::error::Error::Invalid("a chunk of another part".into()));
            }
            covered.add(block.index.pixel_position.x(), block.index.pixel_position.y())?;
            pixels_read += block.index.pixel_size.area();
            copy_block(&block, &meta, kept, image);
        }
    }
    if pixels_read != size.area() {
        return Err(exr::error::Error::Invalid("pixels are missing".into()));
    }
    Ok(())
}

fn decompress(chunk: Chunk, meta: &MetaData) -> exr::error::Result<UncompressedBlock> {
    if let Some(header) = meta.headers.get(chunk.layer_index) {
        exr_chunks::check(&chunk, header)?;
    }
    UncompressedBlock::decompress_chunk(chunk, meta, true)
}

/// Copies the part of a block that the image shows.
fn copy_block(block: &UncompressedBlock, meta: &MetaData, kept: &[usize], image: &mut ExrImage) {
    let header = &meta.headers[block.index.layer];
    let channels = &header.channels;
    let [left, top] = data_origin(header);
    let (width, height) = (i64::from(image.width), i64::from(image.height));
    for line in block.lines(channels) {
        let at = line.location;
        let (x, y) = (left + at.position.x() as i64, top + at.position.y() as i64);
        let Ok(plane) = kept.binary_search(&at.channel) else { continue };
        if !(0..height).contains(&y) {
            continue;
        }
        let (first, end) = (x.clamp(0, width), (x + at.sample_count as i64).clamp(0, width));
        if first >= end {
            continue;
        }
        let kind = channels.list[at.channel].sample_type;
        let bytes = &line.value[(first - x) as usize * kind.bytes_per_sample()..];
        let row = (y * width) as usize;
        convert(kind, bytes, &mut image.channels[plane].1[row + first as usize..row + end as usize]);
    }
}

/// Column and row of the image that the first pixel of the data is at.
fn data_origin(header: &Header) -> [i64; 2] {
    let (data, display) = (header.own_attributes.layer_position, header.shared_attributes.display_window.position);
    [i64::from(data.x()) - i64::from(display.x()), i64::from(data.y()) - i64::from(display.y())]
}

fn convert(kind: SampleType, bytes: &[u8], target: &mut [f32]) {
    match kind {
        SampleType::F32 => {
            let values = bytes.as_chunks().0.iter().map(|&b| f32::from_ne_bytes(b));
            target.iter_mut().zip(values).for_each(|(t, value)| *t = value);
        }
        SampleType::F16 => {
            let values = bytes.as_chunks().0.iter().map(|&b| f16::from_ne_bytes(b).to_f32());
            target.iter_mut().zip(values).for_each(|(t, value)| *t = value);
        }
        SampleType::U32 => {
            let values = bytes.as_chunks().0.iter().map(|&b| u32::from_ne_bytes(b) as f32);
            target.iter_mut().zip(values).for_each(|(t, value)| *t = value);
        }
    }
}

fn check_size(headers: &[Header], header: &Header, file_bytes: u64) -> Result<(), String> {
    let (data, display) = (header.layer_size, header.shared_attributes.display_window.size);
    let (width, height) = (data.width().max(display.width()), data.height().max(display.height()));
    if width.max(height) > MAX_SIDE {
        return Err(format!("{width}x{height} pixels are too many: {MAX_SIDE} a side is the most"));
    }
    let [left, top] = data_origin(header);
    let meets = |start: i64, data: usize, display: usize| start < display as i64 && start + data as i64 > 0;
    if !meets(left, data.width(), display.width()) || !meets(top, data.height(), display.height()) {
        return Err("its data window holds nothing of its display window".to_owned());
    }
    if header.channels.list.iter().any(|c| (c.sampling.x(), c.sampling.y()) != (1, 1)) {
        return Err("subsampled channels are not supported".to_owned());
    }
    let needed = (width * height) as u64 * header.channels.list.len() as u64 * size_of::<f32>() as u64;
    let chunks: u64 = headers.iter().map(|header| header.chunk_count as u64).sum();
    if needed > ALWAYS_ALLOWED_BYTES.max(file_bytes.saturating_mul(MAX_EXPANSION)) || chunks > file_bytes / 8 {
        return Err(format!(
            "{width}x{height} pixels cannot be in {file_bytes} bytes: the file is cut short or damaged"
        ));
    }
    Ok(())
}

fn attributes(header: &Header) -> Vec<(String, Attribute)> {
    let all = header.own_attributes.other.iter().chain(&header.shared_attributes.other);
    let name = |stored: &Text| {
        let stored = string(stored);
        stored.strip_prefix(NAME_PREFIX).map_or(stored.clone(), str::to_owned)
    };
    let mut known: Vec<_> = all.filter_map(|(stored, value)| Some((name(stored), attribute(value)?))).collect();
    known.sort_by(|a, b| a.0.cmp(&b.0));
    known
}

fn attribute(value: &AttributeValue) -> Option<Attribute> {
    match value {
        AttributeValue::Text(text) => Some(Attribute::Text(string(text))),
        AttributeValue::F32(value) => Some(Attribute::Float(*value)),
        AttributeValue::F64(value) => Some(Attribute::Float(*value as f32)),
        AttributeValue::I32(value) => {
            Some(u64::try_from(*value).map_or_else(|_| Attribute::Text(value.to_string()), Attribute::Integer))
        }
        _ => None,
    }
}

fn describe(error: &exr::error::Error) -> String {
    use exr::error::Error;
    match error {
        Error::NotSupported(what) => format!("this kind of EXR is not supported: {what}"),
        Error::Invalid(what) => format!("not a whole, valid EXR file: {what}"),
        Error::Io(error) => error.to_string(),
        Error::Aborted => "stopped".to_owned(),
    }
}
