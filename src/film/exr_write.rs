//! Film to OpenEXR: float32, one part, scan lines, written row by row from the film without a copy of the image.
//!
//! Channels: `R G B`; `variance.R/G/B` = s²/n where every pixel has two samples or more; with AOVs `albedo.R/G/B`,
//! `N.X/Y/Z` and `Z`, `samples` where pixels have different numbers of them, and `bmc.variance.R/G/B` where a Gaussian process has a belief about its estimates. Extra channels live inside the one part (`Layer.R`), as several readers cannot open others.

use std::io::{Cursor, Seek, Write};
use std::path::Path;
use std::time::Instant;

use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::BlockDescription;
use exr::meta::attribute::{AttributeValue, ChannelDescription, LineOrder, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::{Compression, SmallVec};
use rayon::prelude::*;

use super::beside::{is_stream, write_beside};
use super::error::FilmError;
use super::metadata::{Attribute, NAME_PREFIX, VARIANCE_VALIDITY, VarianceValidity};
use super::sheet::Film;

/// Run lengths: as fast as no compression, and flat parts (background, depth) still shrink. Noise does not compress: for
/// white noise, 1920×1080 with variance on two cores, none took .09 s for 49.8 MB, RLE .12 s for 49.8 MB, ZIP1 .6 s for
/// 49.3 MB, PIZ .5 to .9 s for 42.8 MB, ZIP16 1.6 s for 48.5 MB.
const COMPRESSION: Compression = Compression::RLE;

/// Blocks formed in parallel before they are written: bounds the memory that writing takes.
const BLOCKS_IN_FLIGHT: usize = 64;

const COLOUR: [&str; 3] = ["R", "G", "B"];
const VARIANCE: [&str; 3] = ["variance.R", "variance.G", "variance.B"];
const AOVS: [&str; 7] = ["albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z", "Z"];
const SAMPLES: &str = "samples";
const POSTERIOR: [&str; 3] = ["bmc.variance.R", "bmc.variance.G", "bmc.variance.B"];

/// Writes the film to `path` (beside it first, then renamed). `attributes` go to the header, together with
/// `variance_validity`, each stored as `octolux.NAME` (the format keeps some names, as `version`, for itself) and read as `NAME`.
/// Works in the current rayon pool.
///
/// # Errors
/// The file cannot be written, or an attribute's name is not allowed in a header; the message names `path`.
pub fn write_exr(
    film: &Film,
    path: &Path,
    attributes: &[(String, Attribute)],
    validity: VarianceValidity,
) -> Result<(), FilmError> {
    let names = channel_names(film);
    let with_variance = film.samples() >= 2;
    let mut attributes = attributes.to_vec();
    let validity = if with_variance { validity.text() } else { "absent: one sample has no variance" };
    attributes.push((VARIANCE_VALIDITY.to_owned(), validity.into()));
    let size = (film.width() as usize, film.height() as usize);
    write_rows(path, size, &names, &attributes, |y, planes| fill_row(film, with_variance, y, planes))
}

/// Seconds and bytes of encoding the uppermost `rows` rows of the film in the current rayon pool: a measure of what
/// [`write_exr`] will take.
pub fn trial(film: &Film, rows: u32) -> (f64, usize) {
    let start = Instant::now();
    let (names, with_variance) = (channel_names(film), film.samples() >= 2);
    let mut sink = Cursor::new(Vec::new());
    let size = (film.width() as usize, rows.min(film.height()) as usize);
    let header = header(size, sorted(&names).iter().map(|&c| names[c]), &[]);
    // What fails here fails again, and is reported, when the file is written.
    let _ = header.map(|h| encode(&mut sink, h, size.0, &names, |y, planes| fill_row(film, with_variance, y, planes)));
    (start.elapsed().as_secs_f64(), sink.into_inner().len())
}

fn channel_names(film: &Film) -> Vec<&'static str> {
    let channels = film.channels();
    let mut names = COLOUR.to_vec();
    names.extend(VARIANCE.iter().filter(|_| film.samples() >= 2));
    names.extend(AOVS.iter().filter(|_| channels.has_aovs()));
    names.extend(film.is_uneven().then_some(SAMPLES));
    names.extend(POSTERIOR.iter().filter(|_| channels.has_posterior()));
    names
}

/// Row `y` in the order of [`channel_names`].
fn fill_row(film: &Film, with_variance: bool, y: usize, planes: &mut [f32]) {
    let (width, uneven) = (film.width() as usize, film.is_uneven());
    for x in 0..film.width() {
        let pixel = film.pixel(x, y as u32);
        let mut values =
            pixel.mean().into_iter().chain(pixel.variance_of_mean().filter(|_| with_variance).into_iter().flatten());
        let mut place = x as usize;
        let mut put = |value: f64| {
            planes[place] = to_f32(value);
            place += width;
        };
        values.by_ref().for_each(&mut put);
        if let Some(aovs) = pixel.aovs() {
            aovs.albedo.into_iter().chain(aovs.normal).for_each(&mut put);
            put(aovs.depth);
        }
        uneven.then_some(pixel.samples as f64).into_iter().for_each(&mut put);
        pixel.posterior_variance().into_iter().flatten().for_each(&mut put);
    }
}

/// Rounds; what is too large for f32 (a variance can be) becomes the largest, so that no file holds an infinity.
fn to_f32(value: f64) -> f32 {
    value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

/// Writes any float32 image. `row(y, planes)` fills `planes[channel · width + x]` in the order of `names`; it is called
/// once for each row, from several threads.
///
/// # Errors
/// As [`write_exr`]; also for duplicate channel names or an empty image.
pub fn write_rows(
    path: &Path,
    (width, height): (usize, usize),
    names: &[&str],
    attributes: &[(String, Attribute)],
    row: impl Fn(usize, &mut [f32]) + Sync,
) -> Result<(), FilmError> {
    let header = header((width, height), sorted(names).iter().map(|&c| names[c]), attributes)
        .map_err(|why| FilmError::write(path, why))?;
    write_beside(path, |file| {
        if !is_stream(path) {
            return encode(file, header, width, names, row);
        }
        // A pipe cannot go back to where the table of blocks belongs.
        let mut whole = Cursor::new(Vec::new());
        encode(&mut whole, header, width, names, row)?;
        Ok(file.write_all(whole.get_ref())?)
    })
}

/// The format wants channels sorted by name.
fn sorted(names: &[&str]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|&c| names[c]);
    order
}

fn encode(
    file: impl Write + Seek,
    header: Header,
    width: usize,
    names: &[&str],
    row: impl Fn(usize, &mut [f32]) + Sync,
) -> exr::error::UnitResult {
    let order = sorted(names);
    let form_block = |index: BlockIndex| {
        let mut planes = vec![0.0f32; names.len() * width];
        let mut data = Vec::with_capacity(index.pixel_size.area() * names.len() * size_of::<f32>());
        for y in 0..index.pixel_size.height() {
            row(index.pixel_position.y() + y, &mut planes);
            for &channel in &order {
                let line = &planes[channel * width..(channel + 1) * width];
                data.extend(line.iter().flat_map(|value| value.to_ne_bytes()));
            }
        }
        UncompressedBlock { index, data }
    };
    exr::block::write(file, SmallVec::from_iter([header]), true, |meta, chunks| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        for batch in blocks.chunks(BLOCKS_IN_FLIGHT) {
            let formed: Vec<_> = batch
                .par_iter()
                .map(|&(place, index)| (place, form_block(index).compress_to_chunk(&meta.headers)))
                .collect();
            for (place, chunk) in formed {
                chunks.write_chunk(place, chunk?)?;
            }
        }
        Ok(())
    })
}

fn header<'a>(
    size: (usize, usize),
    names: impl Iterator<Item = &'a str>,
    attributes: &[(String, Attribute)],
) -> Result<Header, String> {
    let channels = names.map(|name| ChannelDescription::named(name, SampleType::F32)).collect();
    let software = text(concat!("octolux ", env!("CARGO_PKG_VERSION")));
    let mut own = LayerAttributes { software_name: Some(software), ..LayerAttributes::default() };
    for (name, value) in attributes {
        let stored = format!("{NAME_PREFIX}{name}");
        if name.is_empty() || stored.len() > 255 || name.contains('\0') {
            let most = 255 - NAME_PREFIX.len();
            return Err(format!("`{name}` cannot name an attribute: 1 to {most} bytes are needed"));
        }
        own.other.insert(text(&stored), attribute_value(value));
    }
    Ok(Header::new(Text::default(), size, channels)
        .with_encoding(COMPRESSION, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(own))
}

fn attribute_value(value: &Attribute) -> AttributeValue {
    match value {
        Attribute::Text(value) => AttributeValue::Text(text(value)),
        Attribute::Float(value) => AttributeValue::F32(*value),
        Attribute::Integer(value) => match i32::try_from(*value) {
            Ok(value) => AttributeValue::I32(value),
            Err(_) => AttributeValue::Text(text(&value.to_string())),
        },
    }
}

fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}
