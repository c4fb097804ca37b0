//! `octolux replay`: the path as a person reads it adds up to what the image has.

use super::{Scratch, text};
use octolux::film::read_exr;

/// The three numbers after `word` in `line`.
fn colour(line: &str, word: &str) -> [f32; 3] {
    let rest = line.split_once(word).unwrap_or_else(|| panic!("{word} in {line}")).1;
    let inside = rest.split_once('(').unwrap().1.split_once(')').unwrap().0;
    let numbers: Vec<f32> = inside.split_whitespace().map(|n| n.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

#[test]
fn contributions_add_up_to_the_pixel() {
    let scratch = Scratch::new();
    assert!(scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "1"]).status.success());
    let image = read_exr(&scratch.path("a.exr")).unwrap();
    let (mut surfaces, mut lights, mut shadows) = (0, 0, 0);
    for (x, y) in (0..16).flat_map(|y| (0..24).step_by(3).map(move |x| (x, y))) {
        let pixel = format!("{x},{y}");
        let said = text(&scratch.run(&["replay", "scene.toml", "--pixel", &pixel]).stdout);
        let last = said.lines().last().unwrap();
        let (radiance, sum) = (colour(last, "radiance"), colour(last, "added:"));
        let plane = image.rgb().map(|plane| plane[y * 24 + x]);
        assert_eq!((radiance, sum), (plane, plane), "{said}");
        surfaces += said.matches("sphere 0 (`metal`, conductor)").count() + said.matches("(`floor`, diffuse)").count();
        lights += said.matches(", visible, adds").count();
        shadows += said.matches(", in shadow").count();
        assert!(said.contains("vertex 0"), "{said}");
    }
    assert!(surfaces > 20 && lights > 20 && shadows > 0, "{surfaces} {lights} {shadows}");
}

/// What a path adds is not all that an image has where paths come from the lights, too.
#[test]
fn paths_from_the_lights_are_told_of() {
    let scratch = Scratch::new();
    for (light_paths, told) in [("on", true), ("off", false)] {
        let replay = ["replay", "scene.toml", "--pixel", "12,9", "--light-paths", light_paths];
        let said = text(&scratch.run(&replay).stdout);
        assert_eq!(said.contains("paths from the lights"), told, "{said}");
    }
}
