//! `octolux info` and `octolux completions`.

use super::{Scratch, text};

#[test]
fn info_counts_what_the_scene_holds() {
    let scratch = Scratch::new();
    let info = scratch.json(&["info", "scene.toml", "--json", "-"]);
    assert_eq!((&info["triangles"], &info["vertices"], &info["spheres"]), (&2.into(), &4.into(), &2.into()));
    assert_eq!((&info["width"], &info["height"]), (&24.into(), &16.into()));
    assert_eq!(info["bounds"], serde_json::json!([[-3.0, 0.0, -3.0], [3.0, 3.3, 3.0]]));
    assert_eq!(info["lights"]["emitting_primitives"], 1);
    assert_eq!(info["memory"]["film_bytes"], 24 * 16 * 48);
    assert_eq!(info["memory"]["tree_bytes"], 0, "four primitives need no tree");
    let of = |name: &str| {
        let materials = info["materials"].as_array().unwrap();
        materials.iter().find(|m| m["name"] == name).unwrap_or_else(|| panic!("{name} in {info}")).clone()
    };
    assert_eq!((&of("floor")["model"], &of("floor")["primitives"]), (&"diffuse".into(), &2.into()));
    assert_eq!((&of("metal")["model"], &of("lamp")["emits"]), (&"conductor".into(), &true.into()));

    let said = text(&scratch.run(&["info", "scene.toml"]).stdout);
    for word in ["2 triangles", "2 spheres", "conductor", "plan:", "left out tree", "1 emitting"] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn completions_know_the_commands_and_flags() {
    let scratch = Scratch::new();
    for shell in ["bash", "zsh", "fish"] {
        let output = scratch.run(&["completions", shell]);
        let script = text(&output.stdout);
        assert!(output.status.success(), "{shell}");
        assert!(["merge", "replay", "resume", "ladder"].iter().all(|word| script.contains(word)), "{shell}");
    }
}
