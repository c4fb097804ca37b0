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

/// Each image once, with its size in memory and who wears it as what.
#[test]
fn info_lists_textures() {
    let scratch = Scratch::new();
    let courtyard = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/courtyard/scene.toml");
    let info = scratch.json(&["info", courtyard, "--json", "-", "--quiet"]);
    let textures = info["textures"].as_array().expect("a list");
    let brick =
        textures.iter().find(|t| t["file"].as_str().expect("a name").ends_with("brick.png")).expect("the bricks");
    let side = |key: &str| brick[key].as_u64().expect("a number");
    assert_eq!(side("bytes"), side("width") * side("height") * side("channels"));
    let worn = |word: &str| textures.iter().any(|t| t["worn_as"].to_string().contains(word));
    assert!(
        ["colour of", "normal of", "opacity of", "emission of", "roughness of", "metallic of"].into_iter().all(worn)
    );
    let said = text(&scratch.run(&["info", courtyard]).stdout);
    assert!(said.contains(&format!("textures: {}", textures.len())) && said.contains("brick_normal.png"), "{said}");
    let plain = text(&scratch.run(&["info", "scene.toml"]).stdout);
    assert!(!plain.contains("textures:"), "{plain}");
}

/// Every stage that the scene has no need of, the other geometry mode and all at once; the bits stay.
#[test]
fn ablations_put_each_left_out_stage_back() {
    let scratch = Scratch::new();
    let fast = ["--ablate", "--windows", "2", "--seconds", "0.001", "--threads", "1", "--quiet"];
    let report = scratch.json(&[&["bench", "scene.toml", "--json", "-"][..], &fast].concat());
    let rows = report["rows"].as_array().expect("rows");
    let names: Vec<_> = rows.iter().map(|row| row["what"].as_str().expect("a name")).collect();
    for left_out in ["phong", "coated", "textures", "cut-outs", "lights without extent", "patterned lights", "a tree"] {
        assert!(names.contains(&left_out), "{left_out}: {names:?}");
    }
    for kept in ["spheres", "environment", "area lights", "conductor and dielectric"] {
        assert!(!names.contains(&kept), "the scene has {kept}");
    }
    for row in rows {
        let number = |key: &str| row[key].as_f64().expect("a number");
        assert_eq!(row["same_bits"], true, "{row}");
        assert!(number("min") > 0.0 && number("min") <= number("ratio") && number("ratio") <= number("max"), "{row}");
    }
    let said = text(&scratch.run(&[&["bench", "scene.toml"][..], &fast].concat()).stdout);
    assert!(said.contains("everything (--general)") && !said.contains("DIFFER"), "{said}");
}
