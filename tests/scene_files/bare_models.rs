//! A model alone: where the camera stands, what lights it, and that it is said.

use super::references::check_invariants;
use super::{Files, TRIANGLE};
use octolux::scene::{Environment, Scene};
use std::fmt::Write;

fn load(obj: &str) -> Scene {
    let files = Files::new(&[("a.obj", obj), ("a.mtl", "newmtl lamp\nKd 0 0 0\nKe 5 5 5\nnewmtl wall\nKd .5 .5 .5\n")]);
    let scene = files.load("a.obj").unwrap_or_else(|error| panic!("{error}"));
    check_invariants(&scene);
    scene
}

/// A box; its fronts look out, or in.
fn cuboid(low: [f32; 3], high: [f32; 3], inwards: bool) -> String {
    let mut obj = String::new();
    for i in 0..8 {
        let at = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        writeln!(obj, "v {} {} {}", at(0), at(1), at(2)).expect("writing to a String");
    }
    for mut quad in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        if inwards {
            quad.reverse();
        }
        writeln!(obj, "f {} {} {} {}", quad[0] - 9, quad[1] - 9, quad[2] - 9, quad[3] - 9)
            .expect("writing to a String");
    }
    obj
}

fn is_inside(scene: &Scene, low: [f32; 3], high: [f32; 3]) -> bool {
    (0..3).all(|i| low[i] < scene.camera.position[i] && scene.camera.position[i] < high[i])
}

/// Are all of the model's vertices in a square picture?
fn frames_all(scene: &Scene) -> bool {
    let vector = |p: [f32; 3]| glam::DVec3::from(p.map(f64::from));
    let [eye, target, up] = [scene.camera.position, scene.camera.look_at, scene.camera.up].map(vector);
    let forward = (target - eye).normalize();
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let slope = (f64::from(scene.camera.vfov) / 2.0).to_radians().tan();
    scene.mesh.positions.iter().all(|&p| {
        let seen = vector(p) - eye;
        let depth = seen.dot(forward);
        depth > 0.0 && seen.dot(right).abs() < slope * depth && seen.dot(up).abs() < slope * depth
    })
}

fn says(scene: &Scene, words: &str) -> bool {
    scene.assumptions.iter().any(|sentence| sentence.contains(words))
}

#[test]
fn a_solid_is_framed_from_outside_under_a_constant_sky() {
    let (low, high) = ([1.0, 2.0, 3.0], [4.0, 9.0, 5.0]);
    let scene = load(&cuboid(low, high, false));
    assert!(!is_inside(&scene, low, high) && frames_all(&scene));
    assert!(matches!(scene.environment, Some(Environment::Constant([1.0, 1.0, 1.0]))));
    assert!(scene.spheres.is_empty());
    assert!(says(&scene, "outside") && says(&scene, "nothing emits") && says(&scene, "0.8"), "{:?}", scene.assumptions);
}

#[test]
fn any_extent_is_framed() {
    for obj in [
        TRIANGLE.to_owned(),
        cuboid([-1e-9; 3], [1e-9; 3], false),
        cuboid([-1e30; 3], [1e30; 3], false),
        cuboid([1e3; 3], [1e3 + 1.0; 3], false),
        cuboid([0.0, 0.0, -100.0], [0.1, 0.1, 100.0], false),
        cuboid([-50.0, 0.0, 0.0], [50.0, 0.0, 0.0], false),
        "v 3 3 3\nf 1 1 1\n".to_owned(),
    ] {
        let scene = load(&obj);
        assert!(frames_all(&scene), "{:?}", scene.camera);
    }
}

#[test]
fn a_room_is_seen_from_inside_by_a_panel_below_the_ceiling() {
    for (high, axis) in [([6.0, 3.0, 4.0], 0), ([4.0, 3.0, 6.0], 2), ([3.0, 30.0, 4.0], 2)] {
        let low = [0.0; 3];
        let scene = load(&cuboid(low, high, true));
        assert!(is_inside(&scene, low, high), "{:?}", scene.camera);
        let along: Vec<f32> = (0..3).map(|i| scene.camera.look_at[i] - scene.camera.position[i]).collect();
        assert!((0..3).all(|i| (along[i] != 0.0) == (i == axis)), "{along:?} is not along axis {axis}");
        assert!(scene.environment.is_none());
        assert!(scene.spheres.is_empty());
        let [first, second] = scene.mesh.triangles[12..] else { panic!("one panel of two triangles") };
        let height = scene.mesh.positions[first[0] as usize][1];
        assert!(height > scene.camera.position[1] && height < high[1], "{height} below {high:?}");
        for corners in [first, second] {
            let [a, b, c] = corners.map(|i| glam::Vec3::from(scene.mesh.positions[i as usize]));
            assert!([a, b, c].iter().all(|p| p.y == height
                && p.x > low[0]
                && p.x < high[0]
                && p.z > low[2]
                && p.z < high[2]));
            assert!((b - a).cross(c - a).y < 0.0, "it faces the floor");
        }
        let emits: Vec<bool> = scene.mesh.material.iter().map(|&m| scene.materials[m as usize].emits()).collect();
        assert_eq!(emits.iter().filter(|&&emits| emits).count(), 2);
        assert!(emits[12] && emits[13]);
        assert!(says(&scene, "inside") && says(&scene, "panel"), "{:?}", scene.assumptions);
    }
}

#[test]
fn a_room_with_thick_walls_and_a_table_in_the_middle_is_a_room() {
    let (low, high) = ([0.0; 3], [6.0, 3.0, 4.0]);
    let table = cuboid([2.0, 0.1, 1.5], [4.0, 2.0, 2.5], false);
    assert!(is_inside(&load(&(cuboid(low, high, true) + &table)), low, high));
    let thick = cuboid([-0.2; 3], [6.2, 3.2, 4.2], false) + &cuboid(low, high, true);
    assert!(is_inside(&load(&thick), low, high));
}

#[test]
fn a_room_without_a_ceiling_is_not_closed() {
    let (low, high) = ([0.0; 3], [6.0, 3.0, 4.0]);
    let mut open = cuboid(low, high, true);
    // The quad of the high y side is the fourth face.
    let ceiling = open.lines().filter(|line| line.starts_with('f')).nth(3).expect("six faces").to_owned();
    open = open.replace(&format!("{ceiling}\n"), "");
    let scene = load(&open);
    assert!(!is_inside(&scene, low, high));
    assert!(scene.environment.is_some());
}

#[test]
fn a_model_that_emits_gets_no_light() {
    let lit = |obj: String| load(&format!("mtllib a.mtl\nusemtl wall\n{obj}usemtl lamp\nf -1 -2 -3\n"));
    for scene in [lit(cuboid([0.0; 3], [1.0; 3], false)), lit(cuboid([0.0; 3], [1.0; 3], true))] {
        assert!(scene.environment.is_none() && scene.mesh.triangles.len() == 13);
        assert!(!says(&scene, "nothing emits"));
    }
}

#[test]
fn a_model_too_far_away_to_be_framed_is_an_error() {
    let files = Files::new(&[("a.obj", "v 1e12 0 0\nf 1 1 1\n")]);
    assert!(files.error("a.obj").to_string().contains("precision"));
}
