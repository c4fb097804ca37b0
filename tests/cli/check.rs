//! `octolux check` and `octolux replay`.

use super::{Scratch, text};
use octolux::kernel::Stage;

#[test]
fn check_finds_all_bits_equal() {
    let scratch = Scratch::new();
    let output = scratch.run(&["check", "scene.toml"]);
    let said = text(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("all bits equal"), "{said}");
    for setting in ["1 lanes", "8 lanes", "16 lanes", "specialised", "brute force"] {
        assert!(said.contains(setting), "{setting} was compared: {said}");
    }
}

#[test]
fn an_injected_fault_is_found_at_every_stage_that_the_scene_has() {
    let scratch = Scratch::new();
    for stage in Stage::ALL {
        let output = scratch.run(&["check", "scene.toml", "--inject-fault", stage.name(), "--spp", "2"]);
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{}: {said}", stage.name());
        let first = said.lines().find(|l| l.contains("first:")).unwrap_or_default();
        assert!(first.contains(&format!("stage {}", stage.name())), "{}: {said}", stage.name());
        // Roulette begins at the second event.
        let bounce = if stage == Stage::Roulette { "bounce 1" } else { "bounce 0" };
        assert!(first.contains(bounce) && first.contains("lane"), "{said}");
        assert!(said.contains("octolux replay"), "{said}");
    }
}

/// Nothing that stayed equal because nothing was disturbed.
#[test]
fn a_fault_that_no_path_meets_is_no_proof() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    std::fs::write(scratch.path("one.toml"), format!("{scene}\n[integrator]\nmax_bounces = 1\n")).unwrap();
    let output = scratch.run(&["check", "one.toml", "--inject-fault", "roulette"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("no such value"), "{}", text(&output.stderr));
}

#[test]
fn replay_prints_the_path_that_check_names() {
    let scratch = Scratch::new();
    let replay = |more: &[&str]| {
        let arguments = [&["replay", "scene.toml", "--pixel", "12,9", "--sample", "1", "--bits"], more].concat();
        text(&scratch.run(&arguments).stdout)
    };
    let (one, eight) = (replay(&[]), replay(&["--lanes", "8"]));
    assert_eq!(one, eight);
    for word in ["vertex 0", "hit-t", "random", "radiance"] {
        assert!(one.contains(word), "{one}");
    }
}

#[test]
fn the_numerics_catalogue_is_a_table_and_json() {
    let scratch = Scratch::new();
    let output = scratch.run(&["check", "--numerics", "--quick", "--only", "lane maths"]);
    let said = text(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("| lane maths: exp |") && said.contains("all cases pass"), "{said}");
    let json = scratch.json(&["check", "--numerics", "--quick", "--only", "two", "--json"]);
    assert_eq!(json["pass"], true);
    assert!(json["rows"].as_array().unwrap().iter().all(|row| row["worst"].is_number() && row["count"] != 0));
}

#[test]
fn numerics_take_no_scene_and_a_scene_no_effort() {
    let scratch = Scratch::new();
    for bad in [
        &["check", "--numerics", "scene.toml"][..],
        &["check", "scene.toml", "--full"],
        &["check", "--quick"],
        &["check"],
    ] {
        assert_eq!(scratch.run(bad).status.code(), Some(2), "{bad:?}");
    }
    let output = scratch.run(&["check", "--numerics", "--only", "nonsense"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("lane maths"), "{}", text(&output.stderr));
}
