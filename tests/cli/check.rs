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
    // Roulette begins after the fifth event: a fault at bounce 0 cannot meet it.
    for stage in Stage::ALL.into_iter().filter(|&s| s != Stage::Roulette) {
        let output = scratch.run(&["check", "scene.toml", "--inject-fault", stage.name(), "--spp", "1"]);
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{}: {said}", stage.name());
        let first = said.lines().find(|l| l.contains("first:")).unwrap_or_default();
        assert!(first.contains(&format!("stage {}", stage.name())), "{}: {said}", stage.name());
        assert!(first.contains("bounce 0") && first.contains("lane"), "{said}");
        assert!(said.contains("octolux replay"), "{said}");
    }
}

#[test]
fn replay_prints_the_path_that_check_names() {
    let scratch = Scratch::new();
    let one = text(&scratch.run(&["replay", "scene.toml", "--pixel", "12,9", "--sample", "1"]).stdout);
    let eight =
        text(&scratch.run(&["replay", "scene.toml", "--pixel", "12,9", "--sample", "1", "--lanes", "8"]).stdout);
    assert_eq!(one, eight);
    for word in ["vertex 0", "hit-t", "random", "radiance"] {
        assert!(one.contains(word), "{one}");
    }
}
