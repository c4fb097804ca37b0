//! `render --ladder`: the sheet's tiles are the renders of so many samples.

use super::{Scratch, text};
use octolux::report::font;
use std::path::Path;

/// Width, height and RGB bytes.
fn read_png(path: &Path) -> (usize, usize, Vec<u8>) {
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    (info.width as usize, info.height as usize, bytes)
}

/// The bytes of a 120 × 80 tile whose corner is at (x, y).
fn cut((width, _, bytes): &(usize, usize, Vec<u8>), x: usize, y: usize) -> Vec<u8> {
    (y..y + 80).flat_map(|row| bytes[3 * (row * width + x)..3 * (row * width + x + 120)].to_vec()).collect()
}

#[test]
fn tiles_are_the_renders_and_labels_say_their_error() {
    let scratch = Scratch::new();
    let size = ["--size", "120x80", "--quiet"];
    let run = |arguments: &[&str]| {
        let output = scratch.run(&[&["render", "scene.toml"], arguments, &size].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
    };
    run(&["-o", "ref.exr", "--spp", "200", "--seed", "9"]);
    run(&["--png", "sheet.png", "--ladder", "64,1,4,4", "--reference", "ref.exr", "-o", "last.exr"]);
    let sheet = read_png(&scratch.path("sheet.png"));
    // Two columns; the pitch is a tile, or its label where that is wider, and 8 pixels.
    let label_rows = 2 * font::ADVANCE.1 + 3;
    let pitch = ((sheet.0 - 8) / 2, 80 + label_rows + 8);
    assert_eq!(sheet.1, 2 * pitch.1 + 8);
    for (spp, column, row) in [("1", 0, 0), ("4", 1, 0), ("64", 0, 1)] {
        run(&["--png", "one.png", "--spp", spp]);
        let one = read_png(&scratch.path("one.png"));
        assert!(cut(&one, 0, 0) == cut(&sheet, 8 + column * pitch.0, 8 + row * pitch.1), "{spp} spp");
    }
    let label = |column: usize, row: usize| {
        let (left, top) = (8 + column * pitch.0, 8 + row * pitch.1 + 80 + 3);
        read_label(&sheet, left, top)
    };
    assert_eq!((label(0, 0), label(1, 0), label(0, 1)), ("1 spp".into(), "4 spp".into(), "64 spp".into()));
    // The last rung's image is the EXR, and its label the error that `compare` finds.
    let json = scratch.run(&["compare", "last.exr", "ref.exr", "--json", "-"]);
    let compared: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    let relmse = compared["relmse"].as_f64().unwrap();
    let said = read_label(&sheet, 8, 8 + pitch.1 + 80 + 3 + font::ADVANCE.1);
    assert_eq!(said, format!("relMSE {relmse:.2e}"));
}

/// Letters back from pixels: what `font::draw` would have drawn.
fn read_label((width, _, bytes): &(usize, usize, Vec<u8>), left: usize, top: usize) -> String {
    let dark = |x: usize, y: usize| left + x < *width && bytes[3 * ((top + y) * width + left + x)] < 128;
    let letter = |place: usize| {
        let alphabet = "0123456789.,-EMSabcdefghijklmnopqrstuvwxyz ".chars();
        alphabet.into_iter().find(|letter| {
            let mut glyph = [[false; 6]; 8];
            font::draw(&letter.to_string(), |x, y| glyph[y][x] = true);
            (0..48).all(|i| glyph[i / 6][i % 6] == dark(place * font::ADVANCE.0 + i % 6, i / 6))
        })
    };
    (0..40).map_while(letter).collect::<String>().trim_end().to_string()
}

#[test]
fn a_ladder_without_a_reference_estimates_and_needs_a_png() {
    let scratch = Scratch::new();
    assert!(scratch.run(&["render", "scene.toml", "--png", "s.png", "--ladder", "1,2,8"]).status.success());
    let (width, height, _) = read_png(&scratch.path("s.png"));
    assert!(width > 24 * 2 && height > 16 * 2);
    for bad in
        [&["--ladder", "1,2"][..], &["--png", "x.png", "--ladder", "0"], &["--png", "x.png", "--reference", "a.exr"]]
    {
        assert_eq!(scratch.run(&[&["render", "scene.toml"], bad].concat()).status.code(), Some(2), "{bad:?}");
    }
    let said = scratch.run(&["render", "scene.toml", "-o", "r.exr", "--spp", "1", "--size", "8x8"]);
    assert!(said.status.success());
    let foreign = ["render", "scene.toml", "--png", "x.png", "--ladder", "1", "--reference", "r.exr"];
    let output = scratch.run(&foreign);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("--size 8x8"));
    let alone = ["render", "scene.toml", "--png", "x.png", "--spp", "1", "--size", "8x8", "--reference", "r.exr"];
    let output = scratch.run(&alone);
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains("--ladder"), "{}", text(&output.stderr));
}

/// A rung that is not whole is no rung; without any there is no sheet, and a script is told.
#[test]
fn a_ladder_interrupted_before_its_first_rung_is_an_error() {
    let scratch = Scratch::new();
    let output = scratch.interrupted(&["render", "scene.toml", "--png", "a.png", "--ladder", "1000000000", "--quiet"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("first rung") && said.lines().count() == 1 && !scratch.path("a.png").exists(), "{said}");
}
