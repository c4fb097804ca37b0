//! Prepared data: what the kernel reads, built from a [`Scene`] as its [`Plan`] says and nothing more.

use super::camera::Camera;
use super::material::MaterialTable;
use crate::accel::{Accel, BuildPreset};
use crate::geometry::{Rows, TriangleRows};
use crate::light::{Emitter, EmitterShape, Lights};
use crate::plan::{GeometryMode, Plan};
use crate::scene::{FilmSize, Integrator, NO_NORMAL, Scene};
use std::time::Instant;

/// Everything a kernel needs to render a scene.
pub struct World {
    pub plan: Plan,
    pub camera: Camera,
    pub film: FilmSize,
    pub integrator: Integrator,
    /// Scattering events allowed on a path (the integrator's, with `direct` limited to 1).
    pub max_bounces: f32,
    pub seed: u64,
    pub accel: Accel,
    /// Vertex 0, edges, geometric normal of each triangle.
    pub triangles: TriangleRows,
    /// Material index and, for emitters, choice probability / area, of each triangle.
    pub triangle_tags: Rows<2>,
    /// Three unit normals a triangle; the geometric one where it has none. Empty unless the plan keeps them.
    pub normals: Rows<9>,
    /// Centre, radius and material index of each sphere.
    pub spheres: Rows<5>,
    /// Triangles come first in primitive numbering; this many.
    pub triangle_count: u32,
    pub materials: MaterialTable,
    /// `None` where nothing emits or nothing transports light.
    pub lights: Option<Lights>,
    /// One length unit of the kernel is this many of the scene's: a power of two.
    pub unit: f32,
    pub setup: Setup,
}

/// Seconds and bytes of what was built.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Setup {
    pub tree_seconds: f64,
    pub tables_seconds: f64,
    pub geometry_bytes: usize,
}

/// Options of preparation that do not belong to the scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Prepare {
    pub seed: u64,
    pub build: BuildPreset,
}

impl World {
    /// Builds what the plan keeps.
    pub fn new(scene: &Scene, plan: Plan, options: Prepare) -> World {
        let start = Instant::now();
        let scale = power_of_two_scale(scene);
        let positions: Vec<[f32; 3]> = scene.mesh.positions.iter().map(|p| p.map(|x| x * scale)).collect();
        let spheres: Vec<([f32; 3], f32)> =
            scene.spheres.iter().map(|s| (s.center.map(|x| x * scale), s.radius * scale)).collect();
        let tree = (plan.geometry == GeometryMode::Tree).then_some(options.build);
        let accel = Accel::build(&positions, &scene.mesh.triangles, &spheres, tree);
        let tree_seconds = start.elapsed().as_secs_f64();

        let start = Instant::now();
        let triangles = TriangleRows::new(&positions, &scene.mesh.triangles);
        let lights = plan.light_transport.then(|| build_lights(scene, &plan, &positions, &spheres)).flatten();
        let tag = |primitive: usize, material: u32| {
            [material as f32, lights.as_ref().map_or(0.0, |l| l.emitter_pdf_area(primitive as u32))]
        };
        let triangle_tags = Rows::from_fn(if plan.light_transport { scene.mesh.triangles.len() } else { 0 }, |i| {
            tag(i, scene.mesh.material[i])
        });
        let normals = if plan.shading_normals { normal_rows(scene, &triangles) } else { Rows::from_fn(0, |_| [0.0; 9]) };
        let sphere_rows = Rows::from_fn(spheres.len(), |i| {
            let (c, r) = spheres[i];
            [c[0], c[1], c[2], r, scene.spheres[i].material as f32]
        });
        let materials = MaterialTable::new(if plan.light_transport { &scene.materials } else { &[] });
        let setup = Setup {
            tree_seconds,
            tables_seconds: start.elapsed().as_secs_f64(),
            geometry_bytes: accel.bytes() + triangles.bytes() + normals.bytes(),
        };
        World {
            camera: Camera::new(&scene.camera, scene.film, scale),
            film: scene.film,
            integrator: scene.integrator,
            max_bounces: max_bounces(&scene.integrator),
            seed: options.seed,
            accel,
            triangles,
            triangle_tags,
            normals,
            spheres: sphere_rows,
            triangle_count: scene.mesh.triangles.len() as u32,
            materials,
            lights,
            unit: scale.recip(),
            plan,
            setup,
        }
    }
}

/// `direct` is a path of one scattering event.
fn max_bounces(integrator: &Integrator) -> f32 {
    match integrator.kind {
        crate::scene::IntegratorKind::Direct => integrator.max_bounces.min(1) as f32,
        _ => integrator.max_bounces as f32,
    }
}

/// The power of two that brings the largest coordinate of scene and camera into [1, 2) (invariant 10).
fn power_of_two_scale(scene: &Scene) -> f32 {
    let vertices = scene.mesh.positions.iter().flatten().copied();
    let spheres = scene.spheres.iter().flat_map(|s| s.center.map(|c| c.abs() + s.radius));
    let largest = vertices.chain(spheres).chain(scene.camera.position).fold(0f32, |m, x| m.max(x.abs()));
    if largest == 0.0 {
        return 1.0;
    }
    // Exponents beyond ±126 would leave the normal range; such a scene keeps what scale it can have.
    let exponent = (largest as f64).log2().floor().clamp(-126.0, 126.0) as i32;
    (2f64.powi(-exponent)) as f32
}

fn build_lights(
    scene: &Scene,
    plan: &Plan,
    positions: &[[f32; 3]],
    spheres: &[([f32; 3], f32)],
) -> Option<Lights> {
    let emits = |m: u32| scene.materials[m as usize].emission.iter().any(|&e| e > 0.0);
    let triangle = |i: usize| {
        let [a, b, c] = scene.mesh.triangles[i].map(|v| positions[v as usize]);
        EmitterShape::Triangle { p0: a, e1: difference(b, a), e2: difference(c, a) }
    };
    let mut emitters = Vec::new();
    if plan.area_lights {
        for (i, &material) in scene.mesh.material.iter().enumerate().filter(|(_, m)| emits(**m)) {
            let radiance = scene.materials[material as usize].emission;
            emitters.push(Emitter { primitive: i as u32, shape: triangle(i), radiance });
        }
        for (i, sphere) in scene.spheres.iter().enumerate().filter(|(_, s)| emits(s.material)) {
            let primitive = (scene.mesh.triangles.len() + i) as u32;
            let shape = EmitterShape::Sphere { center: spheres[i].0, radius: spheres[i].1 };
            emitters.push(Emitter { primitive, shape, radiance: scene.materials[sphere.material as usize].emission });
        }
    }
    let environment = scene.environment.as_ref().filter(|_| plan.environment);
    let primitives = scene.mesh.triangles.len() + scene.spheres.len();
    (!emitters.is_empty() || environment.is_some()).then(|| Lights::build(emitters, environment, primitives))
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn normal_rows(scene: &Scene, triangles: &TriangleRows) -> Rows<9> {
    let mesh = &scene.mesh;
    Rows::from_fn(mesh.triangles.len(), |i| {
        let flat = triangles.normal(i);
        let corner = |k: usize| match mesh.normal_indices[i][k] {
            NO_NORMAL => flat,
            n => mesh.normals[n as usize],
        };
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
    })
}
