//! `--path-reuse`, and `path_reuse` of scene files.

use super::{Scratch, text};
use octolux::film::read_exr;

#[test]
fn the_option_and_the_key_say_the_same() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    std::fs::write(scratch.path("off.toml"), format!("{scene}\n[integrator]\npath_reuse = \"off\"\n")).unwrap();
    let image = |name: &str, arguments: &[&str]| {
        let run = scratch.run(&[&["render", name, "--spp", "4", "-o", "a.exr", "--quiet"][..], arguments].concat());
        assert!(run.status.success(), "{}", text(&run.stderr));
        read_exr(&scratch.path("a.exr")).unwrap().rgb().map(<[f32]>::to_vec)
    };
    let (shared, own) = (image("scene.toml", &[]), image("scene.toml", &["--path-reuse", "off"]));
    assert!(shared != own, "it changes nothing");
    assert!(image("off.toml", &[]) == own && image("off.toml", &["--path-reuse", "auto"]) == shared);
    let said = text(&scratch.run(&["render", "scene.toml", "--spp", "1", "-o", "a.exr", "--explain"]).stderr);
    let decided = |said: &str, how: &str| said.lines().any(|line| line.contains("path reuse") && line.contains(how));
    assert!(decided(&said, "kept"), "{said}");
    let said = text(&scratch.run(&["render", "off.toml", "--spp", "1", "-o", "a.exr", "--explain"]).stderr);
    assert!(decided(&said, "left out") && decided(&said, "asked to be off"), "{said}");
    for (name, key) in [("on.toml", "path_reuse = \"on\""), ("one.toml", "path_reuse = 1")] {
        std::fs::write(scratch.path(name), format!("{scene}\n[integrator]\n{key}\n")).unwrap();
        let output = scratch.run(&["render", name, "-o", "b.exr"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(name) && said.trim().lines().count() == 1 && !scratch.path("b.exr").exists(), "{said}");
    }
}

#[test]
fn a_state_goes_on_only_in_its_own_way() {
    let scratch = Scratch::new();
    let render = |arguments: &[&str]| {
        scratch.run(&[&["render", "scene.toml", "-o", "a.exr", "--spp", "64", "--quiet"][..], arguments].concat())
    };
    assert!(render(&["--state", "shared.state"]).status.success());
    assert!(render(&["--state", "own.state", "--path-reuse", "off"]).status.success());
    for (state, way, mend) in [("shared.state", "off", "--path-reuse auto"), ("own.state", "auto", "--path-reuse off")]
    {
        let output = render(&["--resume", state, "--path-reuse", way]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(state) && said.contains(mend) && said.trim().lines().count() == 1, "{said}");
    }
}
