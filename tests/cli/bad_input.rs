//! Input that cannot be rendered, from the command line: one line, exit code 2, soon, in little memory, and an image that
//! was there before is still there.

use super::{Scratch, text};
use std::os::unix::ffi::OsStrExt;
use std::time::Instant;

const KEPT: &[u8] = b"an image of yesterday";

/// Renders `scene` over an existing file, in 2 GB of address space.
fn refused(scratch: &Scratch, scene: &std::ffi::OsStr) -> String {
    let kept = scratch.path("kept.exr");
    std::fs::write(&kept, KEPT).unwrap();
    let start = Instant::now();
    let output = std::process::Command::new("sh")
        .current_dir(scratch.folder.path())
        .args(["-c", "ulimit -v 2000000; exec \"$0\" render \"$1\" -o kept.exr --spp 1 --threads 1"])
        .arg(assert_cmd::cargo::cargo_bin("octolux"))
        .arg(scene)
        .output()
        .unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{scene:?}: {said}");
    // What is read but not honoured is said before.
    let errors = said.lines().filter(|line| !line.starts_with("octolux: warn: ")).collect::<Vec<_>>();
    assert!(errors.len() == 1 && errors[0].starts_with("octolux: "), "{scene:?}: {said}");
    assert!(!said.contains(|c: char| c.is_control() && c != '\n'), "{said:?}");
    assert!(start.elapsed().as_secs_f64() < 20.0, "{scene:?} took {:?}", start.elapsed());
    assert_eq!(std::fs::read(&kept).unwrap(), KEPT, "{scene:?} wrote over an image");
    println!("{}", said.trim_end());
    said
}

fn refused_text(scratch: &Scratch, name: &str, content: impl AsRef<[u8]>) -> String {
    std::fs::write(scratch.path(name), content).unwrap();
    refused(scratch, name.as_ref())
}

/// The small scene with something replaced.
fn changed(scratch: &Scratch, from: &str, to: &str) -> String {
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    assert!(scene.contains(from), "{from}");
    refused_text(scratch, "bad.toml", scene.replacen(from, to, 1))
}

#[test]
fn numbers_that_make_no_scene() {
    let scratch = Scratch::new();
    assert!(changed(&scratch, "width = 24", "width = 0").contains("width"));
    assert!(changed(&scratch, "width = 24", "width = 99999999999999999999").contains("bad.toml:9"));
    assert!(changed(&scratch, "width = 24\nheight = 16", "width = 65536\nheight = 65536").contains("65536"));
    assert!(changed(&scratch, "look_at = [0, 0.5, 0]", "look_at = [0, 1, 4]").contains("look_at"));
    assert!(changed(&scratch, "radius = 0.5", "radius = -0.5").contains("radius"));
    assert!(changed(&scratch, "0.6, 0.5, 0.4", "0.6, 1.5, 0.4").contains("reflectance"));
    assert!(changed(&scratch, "0.6, 0.5, 0.4", "0.6, -0.5, 0.4").contains("reflectance"));
    assert!(changed(&scratch, "position = [0, 1, 4]", "position = [0, nan, 4]").contains("position"));
    assert!(
        changed(
            &scratch,
            "file = \"floor.obj\"",
            "file = \"floor.obj\"\ntransform = [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1]"
        )
        .contains("singular")
    );
}

#[test]
fn models_that_are_none() {
    let scratch = Scratch::new();
    assert!(refused_text(&scratch, "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n").contains("bad.obj:3"));
    assert!(refused_text(&scratch, "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1e39 0\nf 1 2 3\n").contains("bad.obj:3"));
    assert!(refused_text(&scratch, "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000\n").contains("bad.obj:4"));
    assert!(refused_text(&scratch, "bad.obj", [0u8, 159, 146, 150, b'\n', b'f', b' ', 255]).contains("bad.obj"));
    assert!(refused_text(&scratch, "bad.obj", "").contains("no faces"));
    // Cut in the middle of a number and of a line.
    assert!(refused_text(&scratch, "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2").contains("bad.obj:4"));
    assert!(refused_text(&scratch, "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 -").contains("bad.obj:3"));
}

#[test]
fn files_that_are_not_there_or_not_files() {
    let scratch = Scratch::new();
    std::fs::create_dir(scratch.path("folder.toml")).unwrap();
    std::fs::create_dir(scratch.path("folder.obj")).unwrap();
    std::fs::create_dir(scratch.path("folder.exr")).unwrap();
    assert!(refused(&scratch, "nowhere.toml".as_ref()).contains("nowhere.toml"));
    assert!(refused(&scratch, "folder.toml".as_ref()).contains("folder.toml"));
    assert!(refused(&scratch, "folder.obj".as_ref()).contains("folder.obj"));
    assert!(refused(&scratch, ".".as_ref()).contains('.'));
    assert!(changed(&scratch, "floor.obj", "folder.obj").contains("folder.obj"));
    assert!(changed(&scratch, "radiance = [0.2, 0.3, 0.5]", "file = \"folder.exr\"").contains("folder.exr"));
    // A name that is no UTF-8, of a file that is not there and of one that is.
    let name = std::ffi::OsStr::from_bytes(b"caf\xe9.obj");
    refused(&scratch, name);
    std::fs::write(scratch.folder.path().join(name), "v 0 0 0\nf 1 1 2\n").unwrap();
    assert!(refused(&scratch, name).contains(":2:"));
}

#[test]
fn images_that_lie() {
    let scratch = Scratch::new();
    let lit = |scratch: &Scratch| changed(scratch, "radiance = [0.2, 0.3, 0.5]", "file = \"sky.exr\"");
    // A real image, cut, then one that claims 2³⁰ columns.
    let output = scratch.run(&["render", "scene.toml", "-o", "sky.exr", "--spp", "1", "--size", "16x8"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let whole = std::fs::read(scratch.path("sky.exr")).unwrap();
    for bytes in [&whole[..0], &whole[..40], &whole[..whole.len() / 2]] {
        std::fs::write(scratch.path("sky.exr"), bytes).unwrap();
        assert!(lit(&scratch).contains("sky.exr"));
    }
    let name = b"dataWindow\0box2i\0";
    let at = whole.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    let mut claimed = whole.clone();
    claimed[at + 8..at + 12].copy_from_slice(&(1i32 << 30).to_le_bytes());
    std::fs::write(scratch.path("sky.exr"), claimed).unwrap();
    assert!(lit(&scratch).contains("sky.exr"));
    std::fs::write(scratch.path("sky.exr"), b"\x89PNG\r\n\x1a\n").unwrap();
    assert!(lit(&scratch).contains("sky.exr"));
}

/// Textures: cut, of another kind, a folder, and headers that claim a terabyte.
#[test]
fn textures_that_lie() {
    let scratch = Scratch::new();
    let worn = |scratch: &Scratch, file: &str| {
        let mtl = format!("newmtl a\nKd 1 1 1\nmap_Kd {file}\n");
        std::fs::write(scratch.path("worn.mtl"), mtl).unwrap();
        let obj = "mtllib worn.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
        let said = refused_text(scratch, "worn.obj", obj);
        assert!(said.contains("worn.mtl:3") && said.contains(file), "{said}");
    };
    let output = scratch.run(&["render", "scene.toml", "--png", "t.png", "--spp", "1", "--size", "64x64"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let whole = std::fs::read(scratch.path("t.png")).unwrap();
    for bytes in [&whole[..0], &whole[..20], &whole[..whole.len() / 2]] {
        std::fs::write(scratch.path("t.png"), bytes).unwrap();
        worn(&scratch, "t.png");
    }
    for side in [1u32 << 19, 1 << 20, u32::MAX >> 1] {
        let mut claimed = whole.clone();
        claimed[16..20].copy_from_slice(&side.to_be_bytes());
        claimed[20..24].copy_from_slice(&side.to_be_bytes());
        // With the header's checksum made right: CRC-32 of ISO 3309.
        let crc = !claimed[12..29].iter().fold(!0u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
        });
        claimed[29..33].copy_from_slice(&crc.to_be_bytes());
        std::fs::write(scratch.path("t.png"), claimed).unwrap();
        worn(&scratch, "t.png");
    }
    std::fs::write(scratch.path("t.png"), "<svg/>").unwrap();
    worn(&scratch, "t.png");
    std::fs::create_dir(scratch.path("folder.png")).unwrap();
    worn(&scratch, "folder.png");
    worn(&scratch, "nowhere.png");
}

/// An output that is a folder, and one in a folder that is a file: nothing is rendered, nothing written.
#[test]
fn outputs_that_cannot_be_written() {
    let scratch = Scratch::new();
    std::fs::create_dir(scratch.path("out.exr")).unwrap();
    for output in ["out.exr", "floor.obj/a.exr"] {
        let run = scratch.run(&["render", "scene.toml", "-o", output, "--spp", "1"]);
        assert_eq!(run.status.code(), Some(2), "{output}: {}", text(&run.stderr));
        // No progress bar before it: nothing was rendered.
        assert_eq!(text(&run.stderr).trim_end().lines().count(), 1, "{}", text(&run.stderr));
    }
}

/// It would end in an abort without a word.
#[test]
fn films_that_memory_does_not_hold() {
    let scratch = Scratch::new();
    let large = "width = 24\nheight = 16";
    assert!(changed(&scratch, large, "width = 16384\nheight = 16384").contains("16384x16384 pixels needs"));
}

/// What a decoder makes up for what is missing looks like an image.
#[test]
fn a_jpeg_that_is_cut_short_is_told_of() {
    let scratch = Scratch::new();
    let mut image = Vec::new();
    let texels: Vec<u8> = (0..64 * 64 * 3).map(|i| (i * 89 % 256) as u8).collect();
    jpeg_encoder::Encoder::new(&mut image, 90).encode(&texels, 64, 64, jpeg_encoder::ColorType::Rgb).unwrap();
    std::fs::write(scratch.path("m.mtl"), "newmtl a\nKd 1 1 1\nmap_Kd t.jpg\n").unwrap();
    let model = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";
    std::fs::write(scratch.path("m.obj"), model).unwrap();
    let padded = [&image[..], &[0; 1000]].concat();
    for (bytes, is_told) in [(&image[..], false), (&padded, false), (&image[..image.len() / 2], true)] {
        std::fs::write(scratch.path("t.jpg"), bytes).unwrap();
        let output = scratch.run(&["render", "m.obj", "-o", "m.exr", "--spp", "1", "--size", "8x8"]);
        let said = text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert_eq!(said.contains("t.jpg: has no end mark"), is_told, "{said}");
    }
}
