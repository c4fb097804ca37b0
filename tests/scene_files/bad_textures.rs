//! Texture files: what is read, and what is refused, in one line at the key that names the file.

use super::{CAMERA, Files};
use exr::prelude::WritableImage;
use jpeg_encoder::{ColorType as JpegColour, Encoder as JpegEncoder};
use octolux::scene::{Channel, Scene, SceneError, Texels};
use proptest::prelude::*;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";

fn png(width: u32, height: u32, channels: usize) -> Vec<u8> {
    use png::ColorType::{Grayscale, GrayscaleAlpha, Rgb, Rgba};
    let kind = [Grayscale, GrayscaleAlpha, Rgb, Rgba][channels - 1];
    let texels: Vec<u8> = (0..width as usize * height as usize * channels).map(|i| (i * 37 % 251) as u8).collect();
    encode_png([width, height], kind, png::BitDepth::Eight, &texels)
}

fn encode_png([width, height]: [u32; 2], kind: png::ColorType, depth: png::BitDepth, texels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(kind);
    encoder.set_depth(depth);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(texels)).expect("an image in memory");
    bytes
}

fn jpeg(width: u16, height: u16) -> Vec<u8> {
    encode_jpeg([width, height], JpegColour::Rgb, &vec![200; usize::from(width) * usize::from(height) * 3])
}

fn encode_jpeg([width, height]: [u16; 2], kind: JpegColour, texels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    JpegEncoder::new(&mut bytes, 90).encode(texels, width, height, kind).expect("an image in memory");
    bytes
}

/// Loads a model whose material has this MTL text and this file under the name it uses.
fn load(mtl: &str, name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    let files = Files::new(&[("a.obj", OBJ), ("a.mtl", &format!("newmtl a\nKd 1 1 1\n{mtl}\n"))]);
    std::fs::write(files.path(name), bytes).expect("a file");
    files.load("a.obj").inspect_err(|error| assert!(!error.to_string().contains('\n'), "{error}"))
}

/// It fails at line 3 of the MTL file, saying so much.
#[track_caller]
fn refused(mtl: &str, name: &str, bytes: &[u8], words: &str) {
    let error = load(mtl, name, bytes).expect_err("this texture must not load");
    assert!(error.to_string().contains("a.mtl:3: `map_Kd`") && error.message.contains(words), "{error}");
}

#[test]
fn what_is_read() {
    for channels in 1..=4 {
        let scene = load("map_Kd t.png", "t.png", &png(5, 3, channels)).unwrap_or_else(|error| panic!("{error}"));
        let texture = scene.materials[0].maps.colour.as_ref().expect("a texture");
        assert_eq!((texture.image.width, texture.image.height, texture.image.channels), (5, 3, channels));
        assert!(matches!(&texture.image.texels, Texels::Bytes(b) if b.len() == 15 * channels && b[1] == 37));
        assert!(texture.srgb);
        assert_eq!(scene.mesh.texcoords, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(scene.mesh.texcoord_indices, [[0, 1, 2]]);
    }
    let scene = load("map_Kd t.jpg", "t.jpg", &jpeg(16, 8)).unwrap_or_else(|error| panic!("{error}"));
    let image = &scene.materials[0].maps.colour.as_ref().expect("a texture").image;
    assert!(matches!(&image.texels, Texels::Bytes(b) if b.iter().all(|&b| b.abs_diff(200) < 4)));
    assert_eq!((image.width, image.height, image.channels), (16, 8, 3));
}

/// Sixteen bits stay sixteen, in the order of this machine; a grey photo has one channel.
#[test]
fn words_and_grey_photos() {
    let words: Vec<u16> = (0..18).map(|i| 0x0102 + 0x0301 * i).collect();
    // The file's words are big-endian (PNG, third edition, §7.1).
    let raw: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    let file = encode_png([3, 2], png::ColorType::Rgb, png::BitDepth::Sixteen, &raw);
    let scene = load("map_Kd t.png", "t.png", &file).unwrap_or_else(|error| panic!("{error}"));
    let image = &scene.materials[0].maps.colour.as_ref().expect("a texture").image;
    assert!(matches!(&image.texels, Texels::Words(found) if *found == words) && image.channels == 3);

    let file = encode_jpeg([8, 8], JpegColour::Luma, &[90; 64]);
    let scene = load("map_Kd t.jpg", "t.jpg", &file).unwrap_or_else(|error| panic!("{error}"));
    let image = &scene.materials[0].maps.colour.as_ref().expect("a texture").image;
    let is_grey = matches!(&image.texels, Texels::Bytes(b) if b.len() == 64 && b.iter().all(|&b| b.abs_diff(90) < 4));
    assert!(is_grey && image.channels == 1);
}

/// Entries of a palette are looked up, and one of them may be transparent; two bits a texel fill a byte's range.
#[test]
fn palettes_and_few_bits() {
    let file = |kind, bits, transparent: &[u8], rows: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 4, 1);
        encoder.set_color(kind);
        encoder.set_depth(bits);
        if kind == png::ColorType::Indexed {
            encoder.set_palette(vec![9, 8, 7, 60, 50, 40, 255, 0, 1]);
        }
        if !transparent.is_empty() {
            encoder.set_trns(transparent.to_vec());
        }
        encoder.write_header().and_then(|mut writer| writer.write_image_data(rows)).expect("an image in memory");
        bytes
    };
    use png::{BitDepth::Two, ColorType::Grayscale, ColorType::Indexed};
    let rgb = [255, 0, 1, 60, 50, 40, 9, 8, 7, 9, 8, 7];
    let rgba = [255, 0, 1, 255, 60, 50, 40, 128, 9, 8, 7, 0, 9, 8, 7, 0];
    for (bytes, expected) in [
        (file(Indexed, Two, &[], &[0b10_01_00_00]), &rgb[..]),
        (file(Indexed, Two, &[0, 128], &[0b10_01_00_00]), &rgba),
        (file(Grayscale, Two, &[], &[0b11_10_01_00]), &[255, 170, 85, 0]),
    ] {
        let scene = load("map_Kd t.png", "t.png", &bytes).unwrap_or_else(|error| panic!("{error}"));
        let image = &scene.materials[0].maps.colour.as_ref().expect("a texture").image;
        assert!(matches!(&image.texels, Texels::Bytes(found) if found == expected), "{:?}", image.texels);
        assert_eq!(image.channels * 4, expected.len());
    }
}

/// Alpha of an image that has one is its opacity; the file is read once for both uses, and numbers are not decoded.
#[test]
fn one_file_for_colour_and_opacity() {
    let scene = load("map_Kd t.png\nmap_d t.png", "t.png", &png(4, 4, 4)).unwrap_or_else(|error| panic!("{error}"));
    let maps = &scene.materials[0].maps;
    let (colour, opacity) = (maps.colour.as_ref().expect("a map"), maps.opacity.as_ref().expect("a map"));
    assert!(std::sync::Arc::ptr_eq(&colour.image, &opacity.image));
    assert_eq!((opacity.channel, opacity.srgb), (Channel::Alpha, false));
}

#[test]
fn options_of_a_statement() {
    let mtl = "map_Kd -blendu on -s 2 3 1 -o .5 -bm 2 -texres 512 my wood.png\nmap_Pr -imfchan g my wood.png\nPm 1";
    let scene = load(mtl, "my wood.png", &png(4, 4, 3)).unwrap_or_else(|error| panic!("{error}"));
    let maps = &scene.materials[0].maps;
    let colour = maps.colour.as_ref().expect("a map");
    assert_eq!((colour.scale, colour.offset), ([2.0, 3.0], [0.5, 0.0]));
    assert_eq!(maps.roughness.as_ref().expect("a map").channel, Channel::Green);
    let windows = load("map_Kd .\\t.png", "t.png", &png(4, 4, 3));
    assert!(windows.is_ok(), "{windows:?}");
    refused("map_Kd -s two t.png", "t.png", &png(4, 4, 3), "`-s` takes");
    refused("map_Kd -nonsense 1 t.png", "t.png", &png(4, 4, 3), "unknown option");
    refused("map_Kd -s 1 1 1", "t.png", &png(4, 4, 3), "names no file");
}

#[test]
fn files_that_are_no_texture() {
    let good = png(64, 64, 3);
    refused("map_Kd other.png", "t.png", &good, "cannot be read");
    refused("map_Kd .", "t.png", &good, "is a folder");
    refused("map_Kd t.png", "t.png", b"", "neither PNG, JPEG nor OpenEXR");
    refused("map_Kd t.png", "t.png", b"GIF89a and so on", "neither PNG, JPEG nor OpenEXR");
    refused("map_Kd t.png", "t.png", &good[..good.len() / 2], "not a whole, valid image");
    let photo = jpeg(64, 64);
    refused("map_Kd t.jpg", "t.jpg", &photo[..photo.len() / 2], "not a whole, valid image");
    refused("map_Kd t.exr", "t.exr", &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0], "not a whole, valid EXR");
}

/// Sizes in the header that the file cannot hold: refused before anything of that size is asked for.
#[test]
fn claims_of_huge_size_are_not_believed() {
    let good = png(16, 16, 4);
    for (width, height) in [(u32::MAX / 2, u32::MAX / 2), (60_000, 60_000), (1 << 20, 1000), (0, 0), (1 << 30, 1)] {
        let mut claimed = good.clone();
        claimed[16..20].copy_from_slice(&width.to_be_bytes());
        claimed[20..24].copy_from_slice(&height.to_be_bytes());
        let checksum = crc(&claimed[12..29]);
        claimed[29..33].copy_from_slice(&checksum.to_be_bytes());
        refused("map_Kd t.png", "t.png", &claimed, "");
    }
    let mut photo = jpeg(16, 16);
    let frame = photo.windows(2).position(|w| w == [0xff, 0xc0]).expect("a frame header") + 5;
    photo[frame..frame + 4].copy_from_slice(&[0xff; 4]);
    refused("map_Kd t.jpg", "t.jpg", &photo, "");
}

/// CRC-32 of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

/// Floats may hold what no reflectance is.
#[test]
fn floats_are_held_to_what_they_stand_for() {
    let exr = |value: f32| {
        let channels = exr::prelude::SpecificChannels::rgb(move |_| (value, value, value));
        let image = exr::prelude::Image::from_channels((4, 4), channels);
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).expect("an image in memory");
        bytes.into_inner()
    };
    assert!(load("map_Kd t.exr", "t.exr", &exr(0.75)).is_ok());
    refused("map_Kd t.exr", "t.exr", &exr(1.5), "holds 1.5 at column 0, row 0");
    refused("map_Kd t.exr", "t.exr", &exr(f32::NAN), "holds NaN");
    let lamp = load("map_Ke t.exr", "t.exr", &exr(1.5)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(lamp.materials[0].emission, [1.0; 3]);
}

/// In a scene file, at the key's line; unused materials read nothing.
#[test]
fn scene_files_name_textures_too() {
    let scene = |extra: &str| {
        let toml = format!(
            "{CAMERA}[[mesh]]\nfile = \"a.obj\"\n[materials.a]\ntype = \"diffuse\"\nreflectance = \"t.png\"\n{extra}\n\
             [materials.unused]\ntype = \"diffuse\"\nreflectance = \"nowhere.png\"\n"
        );
        let files = Files::new(&[("scene.toml", &toml), ("a.obj", OBJ)]);
        std::fs::write(files.path("t.png"), png(4, 4, 4)).expect("a file");
        files.load("scene.toml")
    };
    let loaded = scene("emission = \"t.png\"\nopacity = \"t.png\"\nnormal_map = \"t.png\"").expect("a scene");
    let Some(material) = loaded.materials.first() else { panic!("one material") };
    assert!(material.maps.colour.is_some() && material.maps.emission.is_some() && material.maps.normal.is_some());
    assert_eq!(material.maps.opacity.as_ref().expect("a map").channel, Channel::Alpha);
    assert_eq!((material.emission, material.opacity), ([1.0; 3], 1.0));
    assert_eq!(scene("opacity = 0.25").expect("a scene").materials[0].opacity, 0.25);
    for (extra, words) in [
        ("opacity = \"no.png\"", "scene.toml:9: `opacity`"),
        ("normal_map = \"no.png\"", "scene.toml:9: `normal_map`"),
        ("opacity = [1, 0, 1]", "scene.toml:9: `opacity` has no colour"),
        ("opacity = 1.5", "scene.toml:9: `opacity` = 1.5 is out of range"),
    ] {
        let error = scene(extra).expect_err("a bad scene");
        assert!(error.to_string().contains(words), "{error}");
    }
}

/// What MTL says without images: d, Tr, and what glass makes of them.
#[test]
fn opacity_of_a_model() {
    let opacity = |mtl: &str| load(mtl, "t.png", &png(4, 4, 1)).expect("a model").materials[0].opacity;
    assert_eq!(opacity("d .25"), 0.25);
    assert_eq!(opacity("Tr .25"), 0.75);
    assert_eq!(opacity("d .25\nTr .75"), 0.25);
    assert_eq!(opacity("d .25\nillum 7"), 1.0);
    assert_eq!(opacity("d 0\nmap_d t.png"), 1.0);
    assert_eq!(opacity("d .5\nmap_d t.png"), 0.5);
}

/// Coordinates only where an image is worn, across meshes and groups of faces.
#[test]
fn texture_coordinates_where_they_are_needed() {
    let mtl = "newmtl a\nKd 1 1 1\nmap_Kd t.png\nnewmtl b\nKd 1 1 1\n";
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nusemtl b\nf 1/1 2/2 3/1\nusemtl a\n\
               vt 1 1\nvt nan 1\nf 1/1 2/2 3/-2 4/-1\nf 1 2 3\nusemtl b\nf 1/1 2/2 3/1\n";
    let files = Files::new(&[("a.obj", obj), ("a.mtl", mtl)]);
    std::fs::write(files.path("t.png"), png(4, 4, 3)).expect("a file");
    let mesh = files.load("a.obj").expect("a model").mesh;
    const NONE: [u32; 3] = [octolux::scene::NO_TEXCOORD; 3];
    assert_eq!(mesh.texcoords, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(mesh.texcoord_indices, [NONE, [0, 1, 2], [0, 2, 3], NONE, NONE]);
    let files = Files::new(&[("a.obj", OBJ), ("a.mtl", "newmtl a\nKd 1 1 1\n")]);
    let mesh = files.load("a.obj").expect("a model").mesh;
    assert!(mesh.texcoords.is_empty() && mesh.texcoord_indices.is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_of_a_texture_panics(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), photo in any::<bool>(), cut in any::<prop::sample::Index>(), truncate in any::<bool>()) {
        let mut bytes = if photo { jpeg(24, 16) } else { png(24, 16, 3) };
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if truncate {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = load("map_Kd t.png", "t.png", &bytes);
    }
}

/// The decoder reads palettes three bytes at a time, and panicked where there is a rest.
#[test]
fn palettes_that_are_cut_short() {
    for length in [4, 5, 7, 13] {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(vec![100; length]);
        encoder.write_header().and_then(|mut writer| writer.write_image_data(&[0; 4])).expect("an image in memory");
        refused("map_Kd t.png", "t.png", &bytes, "palette");
    }
}

/// What a file can hold is counted as it is stored: an even mask of one bit a texel takes an eighth of a thousandth of its bytes.
#[test]
fn masks_of_one_bit_may_be_large() {
    let side = 4800;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_compression(png::Compression::High);
    let texels = vec![0xff; 600 * 4800];
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&texels)).expect("an image in memory");
    let scene = load("map_Kd t.png", "t.png", &bytes).unwrap_or_else(|error| panic!("{error}"));
    let image = &scene.materials[0].maps.colour.as_ref().expect("a texture").image;
    // As bytes a texel it would be more than deflate can make of the file.
    assert!(2048 * bytes.len() < (side * side) as usize && image.width == side, "{} bytes", bytes.len());
    assert!(matches!(&image.texels, Texels::Bytes(texels) if texels.iter().all(|&texel| texel == 255)));
}
