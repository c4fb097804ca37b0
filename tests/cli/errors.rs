//! Bad input: one clear line, exit code 2, nothing written.

use super::{Scratch, text};

/// Runs a command that must be refused, and returns its one line.
fn refused(scratch: &Scratch, arguments: &[&str]) -> String {
    let output = scratch.run(arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

#[test]
fn a_missing_scene_is_named() {
    let scratch = Scratch::new();
    let said = refused(&scratch, &["render", "nowhere.toml", "-o", "a.exr"]);
    assert_eq!(said.trim().lines().count(), 1, "{said}");
    assert!(said.contains("nowhere.toml"), "{said}");
}

#[test]
fn an_unknown_key_is_an_error_with_its_line() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap().replace("vfov", "fov");
    let line = 1 + scene.lines().position(|l| l.starts_with("fov")).unwrap();
    std::fs::write(scratch.path("bad.toml"), scene).unwrap();
    let said = refused(&scratch, &["render", "bad.toml", "-o", "a.exr"]);
    assert!(said.contains(&format!("bad.toml:{line}")), "line {line}: {said}");
    assert!(!scratch.path("a.exr").exists());
}

#[test]
fn a_missing_output_folder_is_found_before_rendering() {
    let scratch = Scratch::new();
    let start = std::time::Instant::now();
    let said = refused(&scratch, &["render", "scene.toml", "-o", "no/such/a.exr", "--spp", "1000000"]);
    assert!(said.contains("no/such"), "{said}");
    assert!(start.elapsed().as_secs_f64() < 10.0);
}

#[test]
fn a_failed_render_leaves_the_old_image() {
    let scratch = Scratch::new();
    assert!(scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "1"]).status.success());
    let before = std::fs::read(scratch.path("a.exr")).unwrap();
    std::fs::write(scratch.path("floor.obj"), "v 0 0 nonsense\n").unwrap();
    refused(&scratch, &["render", "scene.toml", "-o", "a.exr", "--spp", "1"]);
    assert_eq!(std::fs::read(scratch.path("a.exr")).unwrap(), before);
}

#[test]
fn arguments_out_of_range_are_refused() {
    let scratch = Scratch::new();
    for arguments in [
        &["render", "scene.toml", "--lanes", "4"][..],
        &["render", "scene.toml", "--size", "0x10"],
        &["render", "scene.toml", "--spp", "0"],
        &["render", "scene.toml", "--time", "-1"],
        &["render", "scene.toml", "--time", "nan"],
        &["render", "scene.toml", "--unbiased"],
        &["render", "scene.toml", "--threads", "0"],
        &["replay", "scene.toml", "--pixel", "99,99"],
        &["check", "scene.toml", "--inject-fault", "nonsense"],
        &["bench"],
        &["compare", "scene.toml", "floor.obj"],
    ] {
        refused(&scratch, arguments);
    }
}
