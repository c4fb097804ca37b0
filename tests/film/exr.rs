//! EXR files: what is written is what is read, by our reader and by the library's own.

use super::{filled, rendered, shared};
use exr::prelude::{self as library, WritableImage, f16};
use octolux::film::exr_read;
use octolux::film::exr_write::write_rows;
use octolux::film::{Attribute, Film, FilmChannels, VarianceValidity, read_exr, write_exr};
use std::io::Cursor;
use std::path::Path;

fn attributes() -> Vec<(String, Attribute)> {
    vec![
        ("version".into(), "0.1.0".into()),
        ("scene".into(), "scenes/größe 🌞.toml".into()),
        ("samples".into(), 65u64.into()),
        ("seed".into(), u64::MAX.into()),
        ("seconds".into(), 1.25f32.into()),
        ("stopped_by".into(), "".into()),
        ("octolux.name".into(), "a prefix of its own".into()),
    ]
}

fn bits(plane: &[f32]) -> Vec<u32> {
    plane.iter().map(|value| value.to_bits()).collect()
}

/// One value of a film's pixels as f32 bits, row by row.
fn plane(film: &Film, value: impl Fn(u32, u32) -> f64) -> Vec<u32> {
    let rows = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    rows.map(|(x, y)| (value(x, y) as f32).to_bits()).collect()
}

#[test]
fn every_channel_and_attribute_round_trips() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    // Higher than the blocks that are in flight at once, and no multiple of anything.
    let film = rendered((19, 151), 8, FilmChannels::ColourAndAovs, 65, 65);
    write_exr(&film, &path, &attributes(), VarianceValidity::Independent).unwrap();
    let image = read_exr(&path).unwrap();

    assert_eq!((image.width, image.height, image.channels.len()), (19, 151, 13));
    for c in 0..3 {
        assert_eq!(bits(image.rgb()[c]), plane(&film, |x, y| film.mean(x, y)[c]));
        assert_eq!(bits(image.variance().unwrap()[c]), plane(&film, |x, y| film.variance_of_mean(x, y).unwrap()[c]));
        let albedo = image.channel(["albedo.R", "albedo.G", "albedo.B"][c]).unwrap();
        assert_eq!(bits(albedo), plane(&film, |x, y| film.aovs(x, y).unwrap().albedo[c]));
        let normal = image.channel(["N.X", "N.Y", "N.Z"][c]).unwrap();
        assert_eq!(bits(normal), plane(&film, |x, y| film.aovs(x, y).unwrap().normal[c]));
    }
    assert_eq!(bits(image.channel("Z").unwrap()), plane(&film, |x, y| film.aovs(x, y).unwrap().depth));

    assert_eq!(image.variance_validity(), Some(VarianceValidity::Independent));
    for (name, value) in attributes() {
        let read = image.attribute(&name).unwrap();
        assert_eq!(read.to_string(), value.to_string(), "{name}");
    }
    assert_eq!(image.attribute("samples"), Some(&Attribute::Integer(65)));
    assert_eq!(image.attribute("seconds"), Some(&Attribute::Float(1.25)));
}

#[test]
fn one_sample_writes_no_variance_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.exr");
    let film = rendered((5, 4), 3, FilmChannels::Colour, 1, 1);
    write_exr(&film, &path, &[], VarianceValidity::Independent).unwrap();
    let image = read_exr(&path).unwrap();
    let names: Vec<&str> = image.channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["B", "G", "R"]);
    assert!(image.variance().is_none() && image.variance_validity().is_none());
    assert!(image.attribute("variance_validity").unwrap().to_string().starts_with("absent"));
}

#[test]
fn validities_round_trip() {
    for validity in [VarianceValidity::Independent, VarianceValidity::Correlated, VarianceValidity::Stopped] {
        assert_eq!(VarianceValidity::parse(validity.text()), Some(validity));
    }
    assert_eq!(VarianceValidity::parse("believe me"), None);
}

#[test]
fn values_at_the_ends_of_f32_stay_finite() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ends.exr");
    let film = filled((1, 1), 2, |_, _, s| [f32::MAX, if s == 0 { f32::MAX } else { 0.0 }, f32::MIN_POSITIVE / 8.0]);
    write_exr(&film, &path, &[], VarianceValidity::Independent).unwrap();
    let image = read_exr(&path).unwrap();
    assert_eq!(image.rgb().map(|p| p[0]), [f32::MAX, f32::MAX / 2.0, f32::MIN_POSITIVE / 8.0]);
    assert_eq!(image.variance().unwrap()[1][0], f32::MAX, "a variance beyond f32 is written as the largest f32");
}

#[test]
fn the_librarys_own_reader_sees_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let film = rendered((33, 18), 8, FilmChannels::Colour, 3, 3);
    write_exr(&film, &path, &attributes(), VarianceValidity::Independent).unwrap();
    let image = library::read_first_flat_layer_from_file(&path).unwrap();
    let names: Vec<String> = image.layer_data.channel_data.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "variance.B", "variance.G", "variance.R"]);
    let red: Vec<f32> = image.layer_data.channel_data.list[2].sample_data.values_as_f32().collect();
    assert_eq!(bits(&red), plane(&film, |x, y| film.mean(x, y)[0]));
}

#[test]
fn half_floats_tiles_and_other_layouts_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.exr");
    let value = |x: usize, y: usize| (x * 100 + y) as f32 / 8.0;
    library::write_rgb_file(&path, 70, 65, |x, y| (f16::from_f32(value(x, y)), 2.0f32, (x + y) as u32)).unwrap();
    let image = read_exr(&path).unwrap();
    let [r, g, b] = image.rgb();
    for (i, (x, y)) in (0..65).flat_map(|y| (0..70).map(move |x| (x, y))).enumerate() {
        assert_eq!((r[i], g[i], b[i]), (f16::from_f32(value(x, y)).to_f32(), 2.0, (x + y) as f32));
    }

    for names in [&["Layer.Combined.R", "Layer.Combined.G", "Layer.Combined.B", "Z"][..], &["Y"]] {
        write_rows(&path, (4, 3), names, &[], |y, planes| {
            planes.iter_mut().enumerate().for_each(|(i, v)| *v = (10 * y + i) as f32);
        })
        .unwrap();
        let image = read_exr(&path).unwrap();
        let second = if names.len() == 1 { 11.0 } else { 15.0 };
        assert_eq!((image.rgb()[0][5], image.rgb()[1][5]), (11.0, second), "{names:?}");
    }
}

/// Of a render's layers a texture or sky takes the colours, whatever lies between them.
#[test]
fn colours_are_read_without_the_other_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    let names = ["A", "B", "G", "N.X", "Q", "R", "variance.R", "Z"];
    let value = |channel: usize, y: usize, x: usize| (100 * channel + 10 * y + x) as f32;
    write_rows(&path, (3, 2), &names, &[], |y, planes| {
        planes.iter_mut().enumerate().for_each(|(i, v)| *v = value(i / 3, y, i % 3));
    })
    .unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let (length, all) = (bytes.len() as u64, read_exr(&path).unwrap());
    let image = exr_read::decode_colours(Cursor::new(&bytes), length).unwrap();
    let kept: Vec<&str> = image.channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!((kept, all.channels.len()), (vec!["A", "B", "G", "R"], 8));
    assert_eq!(image.rgb(), all.rgb());
    for (number, name) in names.iter().enumerate() {
        let expected: Vec<f32> = (0..6).map(|i| value(number, i / 3, i % 3)).collect();
        assert_eq!(all.channel(name), Some(&expected[..]), "{name}");
        assert!(image.channel(name).is_none_or(|plane| plane == expected), "{name}");
    }
}

/// A tiled image whose first pixel is at `position`, columns in red and rows in green, seen through a window of 16 × 4 pixels.
fn tiled(path: &Path, position: (i32, i32), size: (usize, usize)) {
    let value = |at: library::Vec2<usize>| (at.x() as f32, at.y() as f32, 1.0f32);
    let encoding = library::Encoding {
        compression: library::Compression::Uncompressed,
        blocks: library::Blocks::Tiles(library::Vec2(8, 8)),
        line_order: library::LineOrder::Increasing,
    };
    let attributes =
        library::LayerAttributes { layer_position: position.into(), ..library::LayerAttributes::default() };
    let layer = library::Layer::new(size, attributes, encoding, library::SpecificChannels::rgb(value));
    let mut image = library::Image::from_layer(layer);
    image.attributes.display_window = library::IntegerBounds::new((0, 0), (16, 4));
    image.write().to_file(path).unwrap();
}

/// Renderers write more than is shown, for filters and camera shake: whole tiles lie beyond the window, on each side.
#[test]
fn tiles_beyond_the_window_are_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("overscan.exr");
    for (position, size) in [((0, 0), (64, 10)), ((-40, -20), (100, 60)), ((9, 1), (80, 20)), ((-30, 0), (37, 2))] {
        tiled(&path, position, size);
        let image = read_exr(&path).unwrap();
        assert_eq!((image.width, image.height), (16, 4));
        for (i, (y, x)) in (0..4).flat_map(|y| (0..16).map(move |x| (y, x))).enumerate() {
            let (column, row) = (x - position.0, y - position.1);
            let inside = (0..size.0 as i32).contains(&column) && (0..size.1 as i32).contains(&row);
            let expected = if inside { [column as f32, row as f32, 1.0] } else { [0.0; 3] };
            assert_eq!(image.rgb().map(|plane| plane[i]), expected, "{position:?} {size:?} {x} {y}");
        }
    }
}

/// Some hundred bytes are not believed to be an image of 800 MB, whatever is said of the window through which they are seen.
#[test]
fn small_files_with_large_windows_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("window.exr");
    let layer = library::SpecificChannels::rgb(|_: library::Vec2<usize>| (1.0f32, 1.0f32, 1.0f32));
    for (side, is_read) in [(64, true), (8_192, false)] {
        let mut image = library::Image::from_channels((1, 1), layer.clone());
        image.attributes.display_window = library::IntegerBounds::new((0, 0), (side, side));
        image.write().to_file(&path).unwrap();
        assert!(std::fs::metadata(&path).unwrap().len() < 1000);
        assert_eq!(read_exr(&path).is_ok(), is_read, "{side}");
    }
    assert!(message(&path).contains("cannot be in"));
}

/// A scan line file of 16 columns, and where its first chunk is.
fn lines(rows: usize, compression: library::Compression, chunks: usize) -> (Vec<u8>, usize) {
    let encoding = library::Encoding {
        compression,
        blocks: library::Blocks::ScanLines,
        line_order: library::LineOrder::Increasing,
    };
    let value = |at: library::Vec2<usize>| {
        let x = f16::from_f32((at.x() * 7 % 5 + at.y()) as f32);
        (x, x, x)
    };
    let attributes = library::LayerAttributes::default();
    let layer = library::Layer::new((16, rows), attributes, encoding, library::SpecificChannels::rgb(value));
    let mut bytes = Cursor::new(Vec::new());
    library::Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    let bytes = bytes.into_inner();
    let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    // The table of offsets ends where the first chunk starts.
    let table = (0..bytes.len() - 8).find(|&at| word(at) == at + 8 * chunks).unwrap();
    (bytes, table + 8 * chunks)
}

fn refused(bytes: &[u8], why: &str) {
    let error = exr_read::decode(Cursor::new(bytes), bytes.len() as u64).expect_err("this must not be readable");
    assert!(error.contains(why), "{error}");
}

/// Each counter of a DWA chunk says for how much memory is made.
#[test]
fn chunks_that_claim_more_than_they_hold_are_refused() {
    for compression in [library::Compression::DWAA(None), library::Compression::DWAB(None)] {
        let (good, chunk) = lines(16, compression, 1);
        assert!(exr_read::decode(Cursor::new(&good), good.len() as u64).is_ok());
        for counter in [1, 6, 7, 8, 9] {
            let mut bad = good.clone();
            bad[chunk + 8 + 8 * counter..][..8].copy_from_slice(&(1u64 << 44).to_le_bytes());
            refused(&bad, "claims more than it can hold");
        }
        let mut empty = good.clone();
        empty[chunk + 4..chunk + 8].fill(0);
        refused(&empty, "a chunk is empty");
    }
}

/// A second copy of a chunk stands for one that is missing, whose pixels would be black.
#[test]
fn a_chunk_that_is_there_twice_is_refused() {
    let (good, chunk) = lines(2, library::Compression::Uncompressed, 2);
    let length = (good.len() - chunk) / 2;
    let mut bad = good.clone();
    bad.copy_within(chunk..chunk + length, chunk + length);
    refused(&bad, "there twice");
}

fn message(path: &Path) -> String {
    let error = read_exr(path).expect_err("this must not be readable").to_string();
    assert!(error.starts_with(&path.display().to_string()) && !error.contains('\n'), "{error}");
    error
}

#[test]
fn unreadable_files_are_one_line_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    message(&path);
    message(folder.path());
    for text in ["", "v/1\u{1}", "this is no image"] {
        std::fs::write(&path, text).unwrap();
        message(&path);
    }
    write_rows(&path, (2, 2), &["U", "V"], &[], |_, planes| planes.fill(0.0)).unwrap();
    assert!(message(&path).contains("it has: U, V"));
}

/// Opening it would wait for ever.
#[test]
fn a_pipe_that_nobody_writes_to_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe.exr");
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    assert!(message(&path).contains("not a regular file"));
    assert!(octolux::render::State::load(&path).is_err());
}

#[test]
fn a_header_that_asks_for_too_much_is_refused_before_memory_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    write_rows(&path, (2, 2), &["R", "G", "B"], &[], |_, planes| planes.fill(0.0)).unwrap();
    let good = std::fs::read(&path).unwrap();
    let key = b"dataWindow\0box2i\0\x10\0\0\0";
    let at = good.windows(key.len()).position(|w| w == key).unwrap() + key.len();
    for (x_max, y_max) in [(65_535, 65_535), (i32::MAX, 1), (1, i32::MAX), (i32::MAX, i32::MAX), (-1, -1), (40_000, 1)]
    {
        let mut bad = good.clone();
        bad[at + 8..at + 12].copy_from_slice(&i32::to_le_bytes(x_max));
        bad[at + 12..at + 16].copy_from_slice(&i32::to_le_bytes(y_max));
        std::fs::write(&path, bad).unwrap();
        message(&path);
    }
}

#[test]
fn damaged_files_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let film = rendered((9, 6), 8, FilmChannels::Colour, 2, 2);
    write_exr(&film, &path, &[], VarianceValidity::Independent).unwrap();
    let good = std::fs::read(&path).unwrap();
    let decode = |bytes: &[u8]| exr_read::decode(Cursor::new(bytes), bytes.len() as u64);
    assert!(decode(&good).is_ok());
    (0..good.len()).for_each(|length| assert!(decode(&good[..length]).is_err(), "cut to {length} bytes"));
    let mut random = super::SplitMix(1);
    for _ in 0..20_000 {
        let mut bad = good.clone();
        for _ in 0..1 + random.next() % 3 {
            let at = random.next() as usize % bad.len();
            bad[at] = random.next() as u8;
        }
        // Some changes only touch pixel values; what counts is that it returns.
        let _ = decode(&bad);
    }
}

#[test]
fn reference_images_have_their_published_means() {
    let Some(shared) = shared() else { return };
    let refs = shared.join("refs");
    let mut seen = 0;
    for entry in std::fs::read_dir(&refs).unwrap() {
        let json = entry.unwrap().path();
        if json.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let facts: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
        let image = read_exr(&json.with_extension("exr")).unwrap();
        for (c, plane) in image.rgb().into_iter().enumerate() {
            let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
            let published = facts["mean_rgb"][c].as_f64().unwrap();
            // The published mean was taken before the pixels were rounded to float32, each by at most half an ulp.
            let tolerance = published * f64::from(f32::EPSILON) / 2.0;
            assert!((mean - published).abs() <= tolerance, "{}: {mean} {published}", json.display());
        }
        seen += 1;
    }
    assert!(seen > 0, "no reference was found in {}", refs.display());
}
