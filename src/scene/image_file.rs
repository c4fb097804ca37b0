//! Texture files: PNG and JPEG by their decoders, OpenEXR through the film's reader.

use super::texture::{Image, Texels};
use crate::film::{beside::is_stream, exr_read};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The most texels of a texture: 32,768 × 32,768.
const MOST_TEXELS: u64 = 1 << 30;
/// A header is believed up to this many bytes whatever the file's length, and beyond up to [`BEST_COMPRESSION`].
const ALWAYS_BELIEVED: usize = 1 << 24;
/// The most a file is believed to shrink by compression: deflate reaches 1,032:1.
const BEST_COMPRESSION: usize = 2048;

const JPEG_START: [u8; 3] = [0xff, 0xd8, 0xff];
const JPEG_END: [u8; 2] = [0xff, 0xd9];
/// So many bytes may follow the end mark of a JPEG: cameras pad.
const JPEG_TAIL: usize = 4096;

/// Reads each file once, whoever asks.
#[derive(Default)]
pub(super) struct ImageFiles {
    read: HashMap<PathBuf, Arc<Image>>,
}

impl ImageFiles {
    /// The image in a file.
    ///
    /// # Errors
    /// What is wrong with it, to follow the file's name.
    pub fn read(&mut self, path: &Path) -> Result<Arc<Image>, String> {
        let key = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if let Some(image) = self.read.get(&key) {
            return Ok(image.clone());
        }
        let image = Arc::new(read(path)?);
        self.read.insert(key, image.clone());
        Ok(image)
    }
}

fn read(path: &Path) -> Result<Image, String> {
    if path.is_dir() {
        return Err("is a folder, not an image".to_owned());
    }
    if is_stream(path) {
        return Err("is not a regular file".to_owned());
    }
    let bytes = std::fs::read(path).map_err(|error| format!("cannot be read: {error}"))?;
    let is_exr = bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]);
    let image = if is_exr { decode_exr(&bytes) } else { decode(&bytes) }?;
    if image.width == 0 || image.height == 0 {
        return Err("holds no texels".to_owned());
    }
    if bytes.starts_with(&JPEG_START) && !has_jpeg_end(&bytes) {
        log::warn!("{}: has no end mark near its end: it may be cut short, and then shows grey", path.display());
    }
    Ok(image)
}

fn decode(bytes: &[u8]) -> Result<Image, String> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => decode_png(bytes),
        _ if bytes.starts_with(&JPEG_START) => decode_jpeg(bytes),
        _ => Err("is neither PNG, JPEG nor OpenEXR".to_owned()),
    }
}

/// Palettes and fewer than eight bits become bytes, a transparent colour a channel.
fn decode_png(bytes: &[u8]) -> Result<Image, String> {
    // Held to what the file can hold, or a header's claim of one long row would be believed before it is seen here.
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: most_bytes(bytes) });
    decoder.set_transformations(png::Transformations::EXPAND);
    // Nothing here uses them, and a few bytes may unpack to many.
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = reader.info().size();
    let (kind, depth) = reader.output_color_type();
    let is_wide = depth == png::BitDepth::Sixteen;
    // By what is stored, in bits: a mask of one bit becomes eight times as much.
    check_size(bytes, width, height, reader.info().bits_per_pixel())?;
    // The decoder looks three bytes at a time.
    if reader.info().palette.as_ref().is_some_and(|palette| palette.len() % 3 != 0) {
        return Err(broken("its palette is cut short"));
    }
    let mut texels = vec![0; reader.output_buffer_size().ok_or("is larger than memory")?];
    reader.next_frame(&mut texels).map_err(broken)?;
    let texels = if is_wide {
        Texels::Words(texels.as_chunks().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect())
    } else {
        Texels::Bytes(texels)
    };
    Ok(Image { width, height, channels: kind.samples(), texels })
}

fn decode_jpeg(bytes: &[u8]) -> Result<Image, String> {
    let any_size = DecoderOptions::default().set_max_width(usize::MAX).set_max_height(usize::MAX);
    // As viewers do: what follows the image, or is missing of its end mark, matters to nobody.
    let options = any_size.set_strict_mode(false);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let size = decoder.dimensions().ok_or("has no size")?;
    let (width, height) = (size.0 as u32, size.1 as u32);
    let is_grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let (space, channels) = if is_grey { (ColorSpace::Luma, 1) } else { (ColorSpace::RGB, 3) };
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    check_size(bytes, width, height, 8 * channels)?;
    Ok(Image { width, height, channels, texels: Texels::Bytes(decoder.decode().map_err(broken)?) })
}

fn has_jpeg_end(bytes: &[u8]) -> bool {
    bytes[bytes.len().saturating_sub(JPEG_TAIL)..].windows(JPEG_END.len()).any(|pair| pair == JPEG_END)
}

fn broken(error: impl std::fmt::Display) -> String {
    format!("is not a whole, valid image: {error}")
}

/// What a file is believed to unpack to.
fn most_bytes(file: &[u8]) -> usize {
    ALWAYS_BELIEVED.max(file.len().saturating_mul(BEST_COMPRESSION))
}

/// Whether the file can hold so many texels of `bits_each`.
fn check_size(file: &[u8], width: u32, height: u32, bits_each: usize) -> Result<(), String> {
    let texels = u64::from(width) * u64::from(height);
    if texels > MOST_TEXELS {
        return Err(format!("claims {width} x {height} texels; at most {MOST_TEXELS} are read"));
    }
    if texels * bits_each as u64 / 8 > most_bytes(file) as u64 {
        return Err(format!("claims {width} x {height} texels, but the file has only {} bytes", file.len()));
    }
    Ok(())
}

fn decode_exr(bytes: &[u8]) -> Result<Image, String> {
    let image = exr_read::decode_colours(Cursor::new(bytes), bytes.len() as u64)?;
    let [r, g, b] = image.rgb();
    let alpha = image.channel("A");
    let mut values = Vec::with_capacity(r.len() * if alpha.is_some() { 4 } else { 3 });
    for i in 0..r.len() {
        values.extend([r[i], g[i], b[i]]);
        values.extend(alpha.map(|plane| plane[i]));
    }
    let channels = if alpha.is_some() { 4 } else { 3 };
    Ok(Image { width: image.width, height: image.height, channels, texels: Texels::Floats(values) })
}
