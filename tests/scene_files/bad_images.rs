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
