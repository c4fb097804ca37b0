//! Changes of a scene that must not change its image at all.

use super::{assert_same, scenes};
use crate::renders;
use octolux::plan::Force;
use octolux::sampling::SamplerKind;
use octolux::scene::{DeltaLight, Scene};

const SAMPLES: u64 = 4;
const SEED: u64 = 22;

/// The scene with all lengths multiplied by 2ᵏ, exactly.
fn scaled(scene: &Scene, k: i32) -> Scene {
    let s = (k as f32).exp2();
    let mut scene = scene.clone();
    let camera = &mut scene.camera;
    let lengths = scene.mesh.positions.iter_mut().chain([&mut camera.position, &mut camera.look_at]);
    lengths.chain(scene.spheres.iter_mut().map(|sphere| &mut sphere.center)).flatten().for_each(|x| *x *= s);
    scene.spheres.iter_mut().for_each(|sphere| sphere.radius *= s);
    (scene.camera.lens_radius, scene.camera.focus_distance) =
        (scene.camera.lens_radius * s, scene.camera.focus_distance * s);
    for light in &mut scene.delta_lights {
        if let DeltaLight::Point { position, intensity } | DeltaLight::Spot { position, intensity, .. } = light {
            position.iter_mut().for_each(|x| *x *= s);
            intensity.iter_mut().for_each(|x| *x *= s * s);
        }
    }
    scene
}

/// Radiance has no length in it: emitters keep theirs, and nothing over- or underflows between 1e-20 and 1e20.
#[test]
fn powers_of_two_do_not_show() {
    for (name, scene) in scenes::all() {
        let expected = renders::film(&renders::world(&scene, SEED), SAMPLES);
        // An intensity goes with the square of lengths, which is out of f32's range at 2¹³².
        let intensities = !scene.delta_lights.is_empty();
        for k in [-66, -24, 3, 66].into_iter().filter(|k: &i32| k.abs() < 60 || !intensities) {
            let found = renders::film(&renders::world(&scaled(&scene, k), SEED), SAMPLES);
            assert_same(&format!("{name}, scaled by 2^{k}"), &found, &expected);
        }
    }
}

#[test]
fn powers_of_two_do_not_show_with_sobol_points_either() {
    for (name, scene) in [("lambert room", scenes::lambert_room()), ("sky", scenes::spheres_under_a_sky())] {
        let of = |scene: &Scene| {
            renders::film(&renders::sampled(scene, SEED, Force::default(), SamplerKind::Sobol), SAMPLES)
        };
        let expected = of(&scene);
        for k in [-66, -1, 24] {
            assert_same(&format!("{name}, scaled by 2^{k}"), &of(&scaled(&scene, k)), &expected);
        }
    }
}

/// Doubling all light doubles the image, exactly.
#[test]
fn light_is_linear() {
    let scene = scenes::lambert_room();
    let mut brighter = scene.clone();
    brighter.materials.iter_mut().for_each(|m| m.emission = m.emission.map(|e| 4.0 * e));
    let a = renders::film(&renders::world(&scene, SEED), SAMPLES);
    let b = renders::film(&renders::world(&brighter, SEED), SAMPLES);
    for (x, y) in (0..a.height()).flat_map(|y| (0..a.width()).map(move |x| (x, y))) {
        assert_eq!(a.mean(x, y).map(|m| 4.0 * m), b.mean(x, y), "pixel {x}, {y}");
    }
}

/// Vertices and materials may be stored in any order, as long as triangles keep theirs.
#[test]
fn order_of_storage_does_not_show() {
    let scene = scenes::everything();
    let mut shuffled = scene.clone();
    let last = scene.mesh.positions.len() as u32 - 1;
    shuffled.mesh.positions.reverse();
    shuffled.mesh.triangles.iter_mut().flatten().for_each(|v| *v = last - *v);
    let last = scene.materials.len() as u32 - 1;
    shuffled.materials.reverse();
    shuffled.mesh.material.iter_mut().for_each(|m| *m = last - *m);
    shuffled.spheres.iter_mut().for_each(|s| s.material = last - s.material);
    let expected = renders::film(&renders::world(&scene, SEED), SAMPLES);
    assert_same("reversed storage", &renders::film(&renders::world(&shuffled, SEED), SAMPLES), &expected);
}
