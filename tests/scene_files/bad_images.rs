//! Environment images: what is read, and what is refused.

use super::{CAMERA, Files};
use exr::prelude::{Encoding, WritableImage};
use octolux::scene::{Environment, EnvironmentImage, SceneError};
use proptest::prelude::*;

type Texel = fn(usize, usize) -> [f32; 3];

fn pattern(x: usize, y: usize) -> [f32; 3] {
    [x as f32, y as f32, 0.5]
}

fn exr_bytes(width: usize, height: usize, encoding: Encoding, texel: Texel) -> Vec<u8> {
    let channels = exr::prelude::SpecificChannels::rgb(move |at: exr::prelude::Vec2<usize>| {
        let [r, g, b] = texel(at.x(), at.y());
        (r, g, b)
    });
    let mut image = exr::prelude::Image::from_channels((width, height), channels);
    image.layer_data.encoding = encoding;
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).expect("an image in memory");
    bytes.into_inner()
}

fn load_bytes(bytes: &[u8], radiance: &str) -> Result<EnvironmentImage, SceneError> {
    let files = Files::new(&[("scene.toml", &format!("{CAMERA}[environment]\nfile = \"e.exr\"\n{radiance}\n"))]);
    std::fs::write(files.path("e.exr"), bytes).expect("a file");
    let scene = files.load("scene.toml").inspect_err(|error| {
        assert!(!error.to_string().contains('\n'));
        assert_eq!(error.file, files.path("e.exr"));
    })?;
    match scene.environment {
        Some(Environment::Image(image)) => Ok(image),
        other => panic!("not an image: {other:?}"),
    }
}

#[test]
fn every_encoding_is_read_and_scaled() {
    for encoding in
        [Encoding::UNCOMPRESSED, Encoding::FAST_LOSSLESS, Encoding::SMALL_LOSSLESS, Encoding::SMALL_FAST_LOSSLESS]
    {
        let bytes = exr_bytes(17, 9, encoding, pattern);
        let image = load_bytes(&bytes, "radiance = [2, 1, 4]").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((image.width, image.height, image.texels.len()), (17, 9, 17 * 9));
        for (i, texel) in image.texels.iter().enumerate() {
            assert_eq!(*texel, [2.0 * (i % 17) as f32, (i / 17) as f32, 2.0], "texel {i}");
        }
    }
}

/// Directions go by the display window: data that fill a part of it, or more than it, stay where they belong.
#[test]
fn a_data_window_lies_in_its_display_window() {
    let read = |size: (usize, usize), position: (i32, i32), display: [i32; 4]| {
        let channels = exr::prelude::SpecificChannels::rgb(|at: exr::prelude::Vec2<usize>| {
            (1.0f32 + at.x() as f32, 1.0f32 + at.y() as f32, 1.0f32)
        });
        let mut image = exr::prelude::Image::from_channels(size, channels);
        image.layer_data.encoding = Encoding::FAST_LOSSLESS;
        image.layer_data.attributes.layer_position = exr::prelude::Vec2(position.0, position.1);
        let [x, y, width, height] = display;
        image.attributes.display_window = exr::prelude::IntegerBounds::new((x, y), (width as usize, height as usize));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).expect("an image in memory");
        load_bytes(&bytes.into_inner(), "")
    };
    for (size, position, display) in [
        ((16, 8), (0, 0), [0, 0, 16, 8]),
        ((5, 3), (4, 2), [0, 0, 16, 8]),
        ((5, 3), (-6, 18), [-10, 17, 16, 8]),
        ((40, 50), (-3, -20), [0, 0, 16, 8]),
        ((5, 20), (13, -1), [0, 0, 16, 8]),
        ((5, 20), (-4, 7), [0, 0, 16, 8]),
    ] {
        let image = read(size, position, display).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((image.width, image.height), (16, 8));
        for (i, texel) in image.texels.iter().enumerate() {
            let x = i as i32 % 16 + display[0] - position.0;
            let y = i as i32 / 16 + display[1] - position.1;
            let is_held = (0..size.0 as i32).contains(&x) && (0..size.1 as i32).contains(&y);
            let expected = if is_held { [1.0 + x as f32, 1.0 + y as f32, 1.0] } else { [0.0; 3] };
            assert_eq!(*texel, expected, "texel {i} of {size:?} at {position:?} in {display:?}");
        }
    }
    for (position, display) in [((16, 0), [0, 0, 16, 8]), ((0, -3), [0, 0, 16, 8]), ((0, 0), [5, 0, 16, 8])] {
        let error = read((5, 3), position, display).expect_err("nothing of it is seen");
        assert!(error.message.contains("display window"), "{error}");
    }
    let error = read((5, 3), (0, 0), [0, 0, 60_000, 60_000]).expect_err("a display window of 40 GB");
    assert!(error.message.contains("60000x60000"), "{error}");
}

#[test]
fn the_colours_of_a_layer_are_read() {
    let read = |names: &[&str]| {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let path = folder.path().join("e.exr");
        octolux::film::exr_write::write_rows(&path, (2, 1), names, &[], |_, planes| {
            planes.iter_mut().enumerate().for_each(|(i, value)| *value = i as f32);
        })
        .expect("an image");
        load_bytes(&std::fs::read(&path).expect("the image"), "").map(|image| image.texels)
    };
    let of_first = [[0.0, 2.0, 4.0], [1.0, 3.0, 5.0]];
    assert_eq!(read(&["sky.R", "sky.G", "sky.B"]).ok(), Some(of_first.to_vec()));
    assert_eq!(read(&["R", "G", "B", "a.R", "a.G", "a.B"]).ok(), Some(of_first.to_vec()));
    assert_eq!(
        read(&["V.Combined.R", "V.Combined.G", "V.Combined.B", "V.AO.R", "V.AO.G", "V.AO.B"]).ok(),
        Some(of_first.to_vec())
    );
    assert_eq!(read(&["Y"]).ok(), Some(vec![[0.0; 3], [1.0; 3]]));
    let error = read(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"]).expect_err("which of the two?");
    assert!(error.message.contains("several layers have R, G and B (a, b)"), "{error}");
    let error = read(&["R", "G"]).expect_err("no blue");
    assert!(error.message.contains("R, G, B"), "{error}");
}

#[test]
fn texels_that_are_no_radiance_are_named() {
    let bad: [Texel; 3] = [
        |x, y| [0.0, if (x, y) == (3, 5) { -1.0 } else { 0.0 }, 0.0],
        |x, y| [if (x, y) == (3, 5) { f32::NAN } else { 1.0 }, 0.0, 0.0],
        |x, y| [0.0, 0.0, if (x, y) == (3, 5) { f32::INFINITY } else { 1.0 }],
    ];
    for texel in bad {
        let error = load_bytes(&exr_bytes(8, 8, Encoding::UNCOMPRESSED, texel), "").expect_err("bad texels");
        assert!(error.to_string().contains("column 3, row 5"), "{error}");
    }
    let bright = exr_bytes(2, 1, Encoding::UNCOMPRESSED, |_, _| [1e30; 3]);
    let error = load_bytes(&bright, "radiance = 1e30").expect_err("overflow");
    assert!(error.to_string().contains("column 0, row 0"), "{error}");
    // Scaling by zero does not excuse them.
    let infinite = exr_bytes(2, 1, Encoding::UNCOMPRESSED, |_, _| [f32::INFINITY; 3]);
    load_bytes(&infinite, "radiance = 0").expect_err("an infinite texel");
}

#[test]
fn files_that_are_no_such_image() {
    let good = exr_bytes(16, 8, Encoding::FAST_LOSSLESS, pattern);
    load_bytes(&[], "").expect_err("an empty file");
    load_bytes(b"not an image at all", "").expect_err("text");
    load_bytes(&good[..good.len() / 2], "").expect_err("half a file");
}

#[test]
fn a_claim_of_huge_size_is_not_believed() {
    let good = exr_bytes(16, 8, Encoding::UNCOMPRESSED, pattern);
    let name = b"dataWindow\0box2i\0";
    let at = good.windows(name.len()).position(|window| window == name).expect("the attribute") + name.len() + 4;
    for (x_max, y_max) in [(i32::MAX / 2, i32::MAX / 2), (30_000, 15_000), (1 << 20, 1 << 20), (i32::MAX, 7), (-1, -1)]
    {
        let mut claimed = good.clone();
        claimed[at + 8..at + 12].copy_from_slice(&x_max.to_le_bytes());
        claimed[at + 12..at + 16].copy_from_slice(&y_max.to_le_bytes());
        let error = load_bytes(&claimed, "").expect_err("a claim the file cannot keep");
        println!("{}", error.message);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_of_an_image_panics(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), cut in any::<prop::sample::Index>(), truncate in any::<bool>()) {
        let mut bytes = exr_bytes(16, 8, Encoding::SMALL_LOSSLESS, pattern);
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if truncate {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = load_bytes(&bytes, "");
    }
}
