//! Reads the reference scenes of ../shared/refs, and only those, with a reader of its own: what the format's loader makes
//! of the same file can be held against it. Panics on what it does not know.

use super::image::Estimate;
use octolux::scene::*;
use std::path::Path;
use toml::{Table, Value};

/// The scene of `NAME/scene.toml`. No environment images, no textures, no transforms.
pub fn read_scene(dir: &Path) -> Scene {
    let text = std::fs::read_to_string(dir.join("scene.toml")).expect("a scene file");
    let file: Table = text.parse().expect("TOML");
    let named = file.get("materials").and_then(Value::as_table).expect("materials");
    let names: Vec<&String> = named.keys().collect();
    let index =
        |name: &str| names.iter().position(|n| *n == name).unwrap_or_else(|| panic!("no material {name}")) as u32;
    let materials = named.iter().map(|(name, m)| Material {
        name: name.clone(),
        bsdf: bsdf(m),
        emission: m.get("emission").map_or([0.0; 3], vec3),
        ..Material::default()
    });
    let camera = &file["camera"];
    let size = |key: &str| file["film"][key].as_integer().expect("an integer") as u32;
    let spheres = list(&file, "sphere").map(|s| Sphere {
        center: vec3(&s["center"]),
        radius: number(&s["radius"]),
        material: index(s["material"].as_str().expect("a name")),
    });
    let mut mesh = Mesh::default();
    for entry in list(&file, "mesh") {
        read_obj(&dir.join(entry["file"].as_str().expect("a file name")), &mut mesh, index);
    }
    Scene {
        name: dir.display().to_string(),
        camera: Camera {
            position: vec3(&camera["position"]),
            look_at: vec3(&camera["look_at"]),
            up: vec3(&camera["up"]),
            vfov: number(&camera["vfov"]),
            lens_radius: 0.0,
            focus_distance: 1.0,
        },
        film: FilmSize { width: size("width"), height: size("height") },
        integrator: Integrator {
            kind: IntegratorKind::Path,
            max_bounces: file["integrator"]["max_bounces"].as_integer().expect("an integer") as u32,
            ..Integrator::default()
        },
        environment: file.get("environment").map(|e| Environment::Constant(vec3(&e["radiance"]))),
        delta_lights: Vec::new(),
        mesh,
        spheres: spheres.collect(),
        materials: materials.collect(),
        assumptions: Vec::new(),
        files: Vec::new(),
    }
}

/// The reference image of that name, averaged over blocks of `block` × `block` pixels, with the standard error that its
/// own noise leaves (`rmse_floor`, as if alike in all pixels).
pub fn read_image(refs: &Path, name: &str, block: usize) -> Vec<[Estimate; 3]> {
    let report = std::fs::read_to_string(refs.join(format!("{name}.json"))).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    let std_error = report["rmse_floor"].as_f64().expect("rmse_floor") / block as f64;
    let image = exr::prelude::read_first_rgba_layer_from_file(
        refs.join(format!("{name}.exr")),
        |size, _| (size.width(), vec![[0f32; 3]; size.area()]),
        |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b],
    );
    let (width, pixels) = image.expect("an EXR image").layer_data.channel_data.pixels;
    let across = width / block;
    let mean = |i: usize, c: usize| {
        let (x, y) = (i % across * block, i / across * block);
        let rows = (y..y + block).flat_map(|j| (x..x + block).map(move |k| j * width + k));
        rows.map(|k| f64::from(pixels[k][c])).sum::<f64>() / (block * block) as f64
    };
    let blocks = pixels.len() / (block * block);
    (0..blocks).map(|i| std::array::from_fn(|c| Estimate { mean: mean(i, c), std_error })).collect()
}

fn read_obj(path: &Path, mesh: &mut Mesh, index: impl Fn(&str) -> u32) {
    let text = std::fs::read_to_string(path).expect("an OBJ file");
    let (first, mut material) = (mesh.positions.len() as u32, 0);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => mesh.positions.push(std::array::from_fn(|i| words[i + 1].parse().expect("a coordinate"))),
            Some(&"usemtl") => material = index(words[1]),
            Some(&"f") => {
                assert_eq!(words.len(), 4, "triangles only: {line}");
                mesh.triangles
                    .push(std::array::from_fn(|i| first + words[i + 1].parse::<u32>().expect("an index") - 1));
                mesh.material.push(material);
            }
            _ => {}
        }
    }
}

fn bsdf(m: &Value) -> Bsdf {
    let alpha = || m.get("alpha").map_or(0.0, number);
    let masking = match m.get("masking").and_then(Value::as_str) {
        Some("separable") => Masking::Separable,
        _ => Masking::Correlated,
    };
    match m["type"].as_str() {
        Some("diffuse") => Bsdf::Diffuse { reflectance: vec3(&m["reflectance"]) },
        Some("dielectric") => Bsdf::Dielectric { alpha: alpha(), masking, ior: number(&m["ior"]) },
        Some("conductor") => {
            let fresnel = match m.get("eta") {
                Some(eta) => ConductorFresnel::Exact { eta: vec3(eta), k: vec3(&m["k"]) },
                None => ConductorFresnel::Constant { reflectance: [number(&m["reflectance"]); 3] },
            };
            Bsdf::Conductor { alpha: alpha(), masking, fresnel }
        }
        other => panic!("material type {other:?}"),
    }
}

fn list<'a>(file: &'a Table, key: &str) -> impl Iterator<Item = &'a Value> {
    file.get(key).and_then(Value::as_array).into_iter().flatten()
}

fn number(v: &Value) -> f32 {
    v.as_float().or(v.as_integer().map(|i| i as f64)).expect("a number") as f32
}

fn vec3(v: &Value) -> [f32; 3] {
    let v = v.as_array().expect("three numbers");
    std::array::from_fn(|i| number(&v[i]))
}
