//! Whatever is done to a valid file, loading answers with a scene or with an error of one line.

use super::references::check_invariants;
use super::{Files, load};
use proptest::prelude::*;

const SCENE: &str = r#"# a scene with everything in it
[camera]
position = [0, 1.5, 4]
look_at = [0, 0.5, 0]
up = [0, 1, 0]
vfov = 39.3077

[film]
width = 64
height = 32

[integrator]
kind = "path"
max_bounces = 7
max_depth = 5.0

[environment]
radiance = [1, 0.5, 0.25]

[[mesh]]
file = "a.obj"
flat = false
transform = [-1, 0, 0, 1,  0, 2, 0, 2,  0, 0, 1, 3,  0, 0, 0, 1]

[[sphere]]
center = [0, 1, 0]
radius = 0.5
material = "glass"

[materials.red]
type = "diffuse"
reflectance = [0.57, 0.04, 0.04]
emission = [1, 2, 3]

[materials.gold]
type = "conductor"
alpha = 0.2
masking = "separable"
eta = [0.143, 0.375, 1.442]
k = [3.98, 2.39, 1.60]

[materials.glass]
type = "dielectric"
ior = 1.5
"#;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0 .1 .2 .3\nvt 0 0\nvt 1 1\nvn 0 0 1\nvn 0 1 1\no thing\n\
                   usemtl red\ns 1\nf 1/1/1 2/2/2 3/1/1\nusemtl gold\nf 1//1 2//2 3//1 4//2\nusemtl glass\nf -1 -2 -3\nl 1 2\n";

const MTL: &str = "newmtl red\nKd .5 .5 .5\nKe 1 0 0\nKs .1 .1 .1\nNs 10\nd .5\nillum 2\n\
                   newmtl gold\nKd 1 .8 .2\nPm 1\nPr .4\nnewmtl glass\nillum 7\nNi 1.5\nmap_Kd a.png\n";

/// A replacement of some bytes.
#[derive(Clone, Debug)]
struct Edit {
    at: prop::sample::Index,
    remove: usize,
    insert: String,
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let snippets = prop::sample::select(vec![
        "",
        "0",
        "-",
        "1e39",
        "nan",
        "inf",
        "-1",
        "[",
        "]",
        "\"",
        "=",
        "\n",
        "/",
        "//",
        " ",
        "#",
        "\0",
        "é",
        "[[",
        ".",
        "9",
        "f 1 2 3\n",
        "v 0 0 0\n",
        "usemtl x\n",
        "99999999999999999999",
        "-9223372036854775808",
        "f 1 2\n",
        "\\\n",
        "{",
        "true",
        "newmtl x\n",
        "Kd 1\n",
        "vn nan 0 0\n",
        "f 1//1 2//1 3//1\n",
        "\t",
        "\r",
    ])
    .prop_map(str::to_owned);
    let text = prop_oneof![4 => snippets, 1 => "\\PC{0,6}"];
    let edit =
        (any::<prop::sample::Index>(), 0usize..12, text).prop_map(|(at, remove, insert)| Edit { at, remove, insert });
    prop::collection::vec(edit, 1..5)
}

fn apply(text: &str, edits: &[Edit]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for edit in edits {
        let start = edit.at.index(bytes.len() + 1);
        let end = (start + edit.remove).min(bytes.len());
        bytes.splice(start..end, edit.insert.bytes());
    }
    bytes
}

/// Loads both ways in; what loads keeps the invariants, what does not is refused in one line.
fn check(files: &Files) -> Result<(), TestCaseError> {
    for name in ["scene.toml", "a.obj"] {
        match load(&files.path(name)) {
            Ok(scene) => check_invariants(&scene),
            Err(error) => {
                let shown = error.to_string();
                prop_assert!(!shown.contains(char::is_control), "{shown:?}");
                prop_assert!(!error.message.is_empty() && !error.mend.is_empty());
                prop_assert!(error.line != Some(0));
            }
        }
    }
    Ok(())
}

#[test]
fn the_files_to_mutate_load() {
    let files = Files::new(&[("scene.toml", SCENE), ("a.obj", OBJ), ("a.mtl", MTL)]);
    for name in ["scene.toml", "a.obj"] {
        check_invariants(&files.load(name).unwrap_or_else(|error| panic!("{error}")));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_panics(edits in edits(), which in 0usize..3) {
        let names = ["scene.toml", "a.obj", "a.mtl"];
        let files = Files::new(&[("scene.toml", SCENE), ("a.obj", OBJ), ("a.mtl", MTL)]);
        let text = [SCENE, OBJ, MTL][which];
        std::fs::write(files.path(names[which]), apply(text, &edits)).expect("a file");
        check(&files)?;
    }
}
