//! `--mode`: how rays find geometry is the user's to choose, and leaves no trace.

use super::{Scratch, text};
use octolux::film::read_exr;
use octolux::plan::BRUTE_FORCE_MOST;

const MODES: [&str; 3] = ["brute", "packet", "stream"];

/// Beside the small scene one with so many triangles that it has a tree.
fn scenes() -> (Scratch, [&'static str; 2]) {
    let scratch = Scratch::new();
    let corner = |i: u32| format!("v {} {} {}\n", i % 13 % 5, i % 7 % 3, i % 11 % 4);
    let face = |i: u32| format!("f {} {} {}\n", i + 1, i + 2, i + 3);
    let rubble: String = (0..102).map(corner).chain(["usemtl floor\n".to_string()]).chain((0..100).map(face)).collect();
    std::fs::write(scratch.path("rubble.obj"), rubble).unwrap();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    std::fs::write(scratch.path("tree.toml"), format!("{scene}\n[[mesh]]\nfile = \"rubble.obj\"\n")).unwrap();
    (scratch, ["scene.toml", "tree.toml"])
}

#[test]
fn every_mode_gives_the_same_image_at_every_width() {
    let (scratch, names) = scenes();
    for name in names {
        let image = |arguments: &[&str]| {
            let run = scratch.run(&[&["render", name, "--spp", "4", "-o", "a.exr", "--quiet"][..], arguments].concat());
            assert!(run.status.success(), "{}", text(&run.stderr));
            read_exr(&scratch.path("a.exr")).unwrap().rgb().map(|c| c.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
        };
        let expected = image(&[]);
        for mode in MODES {
            for lanes in ["1", "8", "16"] {
                assert!(image(&["--mode", mode, "--lanes", lanes]) == expected, "{name}, {mode}, {lanes} lanes");
            }
        }
    }
}

/// The plan says what is done, and a tree is there only where it is walked.
#[test]
fn plans_and_reports_name_the_mode() {
    let (scratch, names) = scenes();
    for (name, planned) in names.into_iter().zip(["brute", "tree"]) {
        for mode in [None, Some("brute"), Some("packet"), Some("stream")] {
            let asked: Vec<&str> = mode.into_iter().flat_map(|mode| ["--mode", mode]).collect();
            let info = scratch.json(&[&["info", name, "--json", "-", "--quiet"][..], &asked].concat());
            let expected = mode.unwrap_or(planned);
            assert_eq!(info["plan"]["geometry"], expected, "{name}");
            let has_tree = info["memory"]["tree_bytes"].as_u64().is_some_and(|bytes| bytes > 0);
            assert_eq!(has_tree, expected != "brute", "{name}, {mode:?}");
            let bench = ["bench", name, "--windows", "1", "--seconds", "0.001", "--threads", "1", "--json", "-"];
            assert_eq!(scratch.json(&[&bench[..], &["--quiet"], &asked].concat())["geometry"], expected, "{name}");
        }
        let said = text(&scratch.run(&["info", name, "--mode", "packet"]).stdout);
        let tree = said.lines().find(|line| line.split_whitespace().nth(1) == Some("tree")).unwrap_or_default();
        assert!(tree.contains("kept") && tree.contains("asked for"), "{said}");
    }
}

/// What is measured, checked and replayed can be told how, too.
#[test]
fn other_commands_take_it() {
    let (scratch, names) = scenes();
    for name in names {
        let replay = |more: &[&str]| {
            let arguments = ["replay", name, "--pixel", "12,9", "--sample", "1", "--bits", "--lanes", "16"];
            text(&scratch.run(&[&arguments[..], more].concat()).stdout)
        };
        let expected = replay(&[]);
        assert!(expected.contains("radiance"), "{expected}");
        for mode in MODES {
            assert_eq!(replay(&["--mode", mode]), expected, "{name}, {mode}");
        }
    }
    for (mode, label) in [("packet", "packets alone"), ("stream", "streams alone"), ("brute", "brute force")] {
        let output = scratch.run(&["check", "tree.toml", "--mode", mode, "--spp", "1", "--quiet"]);
        let said = text(&output.stdout);
        assert!(output.status.success() && said.contains(label) && said.contains("all bits equal"), "{said}");
    }
    let study =
        ["converge", "tree.toml", "-o", "study", "--spp", "1,2", "--seeds", "2", "--reference-spp", "8", "--quiet"];
    let variants = ["--variants", "packets: --mode packet; streams: --mode stream"];
    let output = scratch.run(&[&study[..], &variants].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn estimates_at_a_point_are_the_same() {
    let (scratch, names) = scenes();
    for name in names {
        let means = |more: &[&str]| {
            let study =
                ["estimate", "illumination", "--scene", name, "--samples", "1,4", "--repeats", "8", "--json", "-"];
            let report = scratch.json(&[&study[..], more].concat());
            let cells = report["rows"].as_array().unwrap().iter().flat_map(|row| row["cells"].as_array().unwrap());
            let means: Vec<_> = cells.map(|cell| cell["mean"]["value"].as_f64().unwrap()).collect();
            (report["quantity"]["exact"].as_f64().unwrap(), means)
        };
        let expected = means(&[]);
        assert!(expected.0 > 0.0 && expected.1.iter().any(|mean| *mean > 0.0), "{expected:?}");
        for mode in MODES {
            assert_eq!(means(&["--mode", mode]), expected, "{name}, {mode}");
        }
    }
}

/// States of different modes are of one render.
#[test]
fn states_of_different_modes_merge() {
    let (scratch, [_, name]) = scenes();
    let run = |arguments: &[&str]| {
        let output = scratch.run(&[arguments, &["--quiet"]].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
    };
    run(&["render", name, "--samples", "0..64", "--state", "a.state", "-o", "a.exr", "--mode", "packet"]);
    run(&["render", name, "--samples", "64..80", "--state", "b.state", "-o", "b.exr", "--mode", "stream"]);
    run(&["merge", "a.state", "b.state", "-o", "merged.exr"]);
    run(&["render", name, "--resume", "a.state", "--spp", "80", "-o", "resumed.exr", "--mode", "brute"]);
    run(&["render", name, "--spp", "80", "-o", "whole.exr"]);
    let image = |name: &str| read_exr(&scratch.path(name)).unwrap().rgb().map(<[f32]>::to_vec);
    let whole = image("whole.exr");
    assert!(image("merged.exr") == whole && image("resumed.exr") == whole);
}

#[test]
fn too_many_primitives_for_brute_force_are_refused_in_a_line() {
    let scratch = Scratch::new();
    let floor = std::fs::read_to_string(scratch.path("floor.obj")).unwrap();
    std::fs::write(scratch.path("floor.obj"), floor + &"f 1 2 3\n".repeat(BRUTE_FORCE_MOST)).unwrap();
    for arguments in [&["render", "scene.toml", "-o", "a.exr"][..], &["bench", "scene.toml"], &["info", "scene.toml"]] {
        let output = scratch.run(&[arguments, &["--mode", "brute", "--quiet"]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        let names_the_limit = said.contains(&BRUTE_FORCE_MOST.to_string()) && said.contains("--mode packet");
        assert!(names_the_limit && said.trim().lines().count() == 1, "{said}");
    }
    assert_eq!(scratch.run(&["info", "scene.toml", "--mode", "tree"]).status.code(), Some(2), "what is not offered");
}
