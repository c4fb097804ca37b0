//! Keys that are read but not honoured: one warning a key.

use super::{CAMERA, Files, TRIANGLE};
use std::cell::RefCell;

thread_local! {
    static HEARD: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Keeps what a thread logs with that thread: tests run side by side.
struct Ear;

impl log::Log for Ear {
    fn enabled(&self, _: &log::Metadata) -> bool {
        true
    }

    fn log(&self, record: &log::Record) {
        if record.level() == log::Level::Warn && record.target().starts_with("octolux") {
            HEARD.with_borrow_mut(|heard| heard.push(record.args().to_string()));
        }
    }

    fn flush(&self) {}
}

/// The warnings of loading `name`.
fn warnings(files: &Files, name: &str) -> Vec<String> {
    static EAR: Ear = Ear;
    static SET: std::sync::Once = std::sync::Once::new();
    SET.call_once(|| {
        log::set_logger(&EAR).expect("no other logger in the test binary");
        log::set_max_level(log::LevelFilter::Warn);
    });
    HEARD.with_borrow_mut(Vec::clear);
    files.load(name).unwrap_or_else(|error| panic!("{error}"));
    HEARD.with_borrow(Vec::clone)
}

#[test]
fn each_key_once() {
    let obj = "mtllib a.mtl\nv 0 0 0 .1 .2 .3\nv 1 0 0 .1 .2 .3\nv 0 1 0\ns 1\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n\
               s off\nf 1 2 3\nl 1 2\nl 2 3\ncurv 1\n";
    let mtl = "newmtl a\nKa 1 1 1\nKd 1 1 1\nKs 1 1 1\nNs 5\nmap_Ka a.png\nnewmtl b\nKa 1 1 1\nKd 1 1 1\nd .5\nKs 1 1 1\nNs 5\n\
               Tf 1 1 1\ndisp b.png\nnewmtl unworn\nPr .5\nmap_Ke c.png\n";
    let heard = warnings(&Files::new(&[("a.obj", obj), ("a.mtl", mtl)]), "a.obj");
    for (key, place) in [
        ("v", "a.obj:2"),
        ("s", "a.obj:7"),
        ("l", "a.obj:12"),
        ("curv", "a.obj:14"),
        ("Ka", "a.mtl:2"),
        ("Ks", "a.mtl:4"),
        ("map_Ka", "a.mtl:6"),
        ("Tf", "a.mtl:13"),
        ("disp", "a.mtl:14"),
    ] {
        let of_key: Vec<_> = heard.iter().filter(|warning| warning.contains(&format!("`{key}`"))).collect();
        assert_eq!(of_key.len(), 1, "{key}: {heard:#?}");
        assert!(of_key[0].contains(&format!("{place}:")), "{}", of_key[0]);
    }
    assert_eq!(heard.len(), 9, "{heard:#?}");
}

#[test]
fn values_that_change_nothing_are_honoured() {
    let obj =
        format!("mtllib a.mtl\nusemtl a\no name\ng group\ns off\nvt 0 0\nvn 0 0 1\n{TRIANGLE}s 1\nf 1//1 2//1 3//1\n");
    let mtl = "newmtl a\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nNs 5\nd 1\nTr 0\nKe 0 0 0\nillum 2\nNi 1.5\nPs 0\naniso 0\n";
    let heard = warnings(&Files::new(&[("a.obj", &obj), ("a.mtl", mtl)]), "a.obj");
    assert!(heard.is_empty(), "{heard:#?}");
}

#[test]
fn materials_defined_in_vain_and_libraries_not_needed() {
    let toml = format!(
        "{CAMERA}[[mesh]]\nfile = \"a.obj\"\n[materials.a]\ntype = \"diffuse\"\nreflectance = 1\n\
         [materials.typo]\ntype = \"diffuse\"\nreflectance = 1\n"
    );
    let obj = format!("mtllib none.mtl\nusemtl a\n{TRIANGLE}");
    let heard = warnings(&Files::new(&[("scene.toml", &toml), ("a.obj", &obj)]), "scene.toml");
    assert_eq!(heard.len(), 2, "{heard:#?}");
    assert!(heard[0].contains("none.mtl") && heard[1].contains("`typo`"), "{heard:#?}");
}

/// A lamp that is to shine to both sides, made of the same triangle or quad twice, is told of, whatever the diagonals; two with a
/// gap, neighbours, a lamp on what does not emit, and twice the same of what does not are not.
#[test]
fn lamps_in_one_another() {
    let lamps = |faces: &str| {
        let obj = format!(
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -0 0 0\nv 1 0 -.001\nv 1 1 -.001\nv 0 0 -.001\nv .5 0 1\n\
             usemtl lamp\n{faces}"
        );
        let mtl = "newmtl lamp\nKd 0 0 0\nKe 1 1 1\nnewmtl wall\nKd 1 1 1\n";
        warnings(&Files::new(&[("a.obj", &obj), ("a.mtl", mtl)]), "a.obj")
    };
    for (faces, pair) in [
        ("f 1 2 3\nf 3 2 1\n", [0, 1]),
        ("f 1 2 3\nf 2 3 5\n", [0, 1]),
        ("usemtl wall\nf 1 2 3\nusemtl lamp\nf 1 2 3\nf 3 2 5\n", [1, 2]),
        ("f 1 2 3 4\nf 4 3 2 1\n", [0, 2]),
        ("f 1 2 3 4\nf 3 2 1 4\n", [0, 2]),
    ] {
        let heard = lamps(faces);
        let wanted = format!("a.obj: triangles {} and {} both emit", pair[0], pair[1]);
        assert!(heard.len() == 1 && heard[0].contains(&wanted), "{faces}: {heard:#?}");
    }
    for faces in [
        "f 1 2 3\nf 7 6 8\n",
        "f 1 2 3 4\n",
        "f 1 2 3\nf 2 1 9\n",
        "f 1 2 3\nusemtl wall\nf 3 2 1\n",
        "usemtl wall\nf 1 2 3\nf 3 2 1\n",
    ] {
        assert_eq!(lamps(faces), [""; 0], "{faces}");
    }
}
