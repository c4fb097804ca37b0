//! The reference scenes and models hold what counting their lines says they hold.

use super::{load, shared};
use octolux::scene::{Bsdf, Environment, IntegratorKind, NO_NORMAL, Scene};
use std::collections::BTreeSet;
use std::path::Path;

/// Triangles (a face of n corners makes n − 2), names of materials worn, faces whose corners all have normals.
struct Counted {
    triangles: usize,
    worn: BTreeSet<String>,
    smooth: usize,
}

fn count_obj(path: &Path) -> Counted {
    let text = std::fs::read_to_string(path).expect("a readable model");
    let mut counted = Counted { triangles: 0, worn: BTreeSet::new(), smooth: 0 };
    let mut material = String::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["usemtl", name] => material = name.to_owned(),
            ["f", ref corners @ ..] => {
                counted.triangles += corners.len() - 2;
                counted.worn.insert(material.clone());
                if corners.iter().all(|corner| corner.split('/').count() == 3) {
                    counted.smooth += corners.len() - 2;
                }
            }
            _ => {}
        }
    }
    counted
}

fn count_lines(text: &str, start: &str) -> usize {
    text.lines().filter(|line| line.starts_with(start)).count()
}

/// The invariants of the scene types that every loaded scene must have.
pub fn check_invariants(scene: &Scene) {
    let mesh = &scene.mesh;
    assert_eq!(mesh.triangles.len(), mesh.material.len());
    assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
    assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()));
    assert!(mesh.material.iter().all(|&m| (m as usize) < scene.materials.len()));
    assert!(scene.spheres.iter().all(|s| (s.material as usize) < scene.materials.len()));
    assert_eq!(mesh.normal_indices.len(), if mesh.normals.is_empty() { 0 } else { mesh.triangles.len() });
    for triangle in &mesh.normal_indices {
        let absent = triangle.iter().filter(|&&i| i == NO_NORMAL).count();
        assert!(absent == 0 || absent == 3, "a triangle has normals at all corners or at none");
        assert!(absent == 3 || triangle.iter().all(|&i| (i as usize) < mesh.normals.len()));
    }
    for normal in &mesh.normals {
        let length = normal.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt();
        // Three components rounded once each, by at most half an ulp of 1.
        assert!((length - 1.0).abs() <= f64::from(f32::EPSILON), "{normal:?} is not a unit vector");
    }
}

#[test]
fn every_reference_scene_loads_with_all_it_holds() {
    let Some(shared) = shared() else { return };
    let mut seen = 0;
    for entry in std::fs::read_dir(shared.join("refs")).expect("the reference folder") {
        let folder = entry.expect("an entry").path();
        let file = folder.join("scene.toml");
        if !file.is_file() {
            continue;
        }
        seen += 1;
        let scene = load(&file).unwrap_or_else(|error| panic!("{error}"));
        check_invariants(&scene);
        let text = std::fs::read_to_string(&file).expect("a readable scene");
        let obj = folder.join("geometry.obj");
        let nothing = Counted { triangles: 0, worn: BTreeSet::new(), smooth: 0 };
        let counted = if obj.is_file() { count_obj(&obj) } else { nothing };
        assert_eq!(scene.mesh.triangles.len(), counted.triangles, "{}", file.display());
        assert_eq!(scene.spheres.len(), count_lines(&text, "[[sphere]]"), "{}", file.display());
        assert_eq!(scene.materials.len(), count_lines(&text, "[materials."), "{}", file.display());
        let lamps = scene.materials.iter().filter(|m| m.emission != [0.0; 3]).count();
        assert_eq!(lamps, count_lines(&text, "emission"), "{}", file.display());
        let conductors = scene.materials.iter().filter(|m| matches!(m.bsdf, Bsdf::Conductor { .. })).count();
        assert_eq!(conductors, count_lines(&text, "type = \"conductor\""), "{}", file.display());
        assert!(scene.mesh.normals.is_empty(), "none of them has vertex normals");
        assert!(scene.assumptions.is_empty());
        assert_eq!(scene.name, file.display().to_string());
    }
    assert!(seen >= 10, "only {seen} reference scenes were found");
}

#[test]
fn cornell_is_what_its_file_says() {
    let Some(shared) = shared() else { return };
    let scene = load(&shared.join("refs/cornell/scene.toml")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.camera.position, [278.0, 273.0, -800.0]);
    assert_eq!(scene.camera.vfov, 39.307_648);
    assert_eq!((scene.film.width, scene.film.height), (256, 256));
    assert_eq!((scene.integrator.kind, scene.integrator.max_bounces), (IntegratorKind::Path, 7));
    assert!(scene.environment.is_none());
    let light = scene.materials.iter().find(|m| m.name == "light_light").expect("the lamp");
    assert_eq!(light.emission, [18.387, 13.9873, 6.75357]);
    let worn = scene.mesh.material.iter().filter(|&&m| scene.materials[m as usize].name == "light_light").count();
    assert_eq!(worn, 2, "the lamp is two triangles");
}

#[test]
fn the_environment_image_is_read_at_full_size() {
    let Some(shared) = shared() else { return };
    let scene = load(&shared.join("refs/env/scene.toml")).unwrap_or_else(|error| panic!("{error}"));
    let Some(Environment::Image(image)) = scene.environment else { panic!("an image environment") };
    // An independent read through another interface of the exr crate.
    let read = exr::prelude::read_first_flat_layer_from_file(shared.join("refs/env/env.exr")).expect("env.exr");
    assert_eq!((image.width, image.height), (read.layer_data.size.width(), read.layer_data.size.height()));
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let samples = read.layer_data.channel_data.list.iter().find(|c| c.name.eq(name)).expect("the channel");
        for (i, sample) in samples.sample_data.values_as_f32().enumerate() {
            assert_eq!(image.texels[i][channel], sample, "channel {name} of texel {i}");
        }
    }
}

#[test]
fn the_kitchen_loads_with_materials_and_normals() {
    let Some(shared) = shared() else { return };
    let path = shared.join("models/kitchen.obj");
    let counted = count_obj(&path);
    let scene = load(&path).unwrap_or_else(|error| panic!("{error}"));
    check_invariants(&scene);
    // Nothing in it emits: a panel of two triangles lights it.
    assert_eq!(scene.mesh.triangles.len(), counted.triangles + 2);
    let named: BTreeSet<String> =
        scene.materials.iter().map(|m| m.name.clone()).filter(|name| name != "panel").collect();
    assert_eq!(named, counted.worn);
    let smooth = scene.mesh.normal_indices.iter().filter(|t| t[0] != NO_NORMAL).count();
    assert_eq!(smooth, counted.smooth);
    for assumption in &scene.assumptions {
        println!("{assumption}");
    }
    println!("{:?} {:?}", scene.camera, scene.spheres);
}

#[test]
fn the_statues_load() {
    let Some(shared) = shared() else { return };
    for name in ["ogre.obj", "stanford-bunny.obj"] {
        let path = shared.join("models").join(name);
        let scene = load(&path).unwrap_or_else(|error| panic!("{error}"));
        check_invariants(&scene);
        assert_eq!(scene.mesh.triangles.len(), count_obj(&path).triangles);
        assert!(
            matches!(scene.environment, Some(Environment::Constant([1.0, 1.0, 1.0]))),
            "{name} is seen from outside"
        );
        println!("{name}: {:?} {:?}", scene.camera, scene.assumptions);
    }
}
