//! Preparing a [`World`]: tree, rows and tables, from a [`Scene`] as its [`Plan`] says and nothing more.

use super::camera::Camera;
use super::gather::{self, GatherReport};
use super::light_paths::LightPaths;
use super::material_table::MaterialTable;
use super::pattern::mean_radiance;
use super::roulette::Roulette;
use super::texture::TextureTable;
use super::world::World;
use crate::accel::{Accel, BuildOptions, BuildReport, Preset};
use crate::geometry::{Rows, SphereRows, TriangleRows};
use crate::lane::{array, float_mode};
use crate::light::{Emitter, EmitterShape, EnvironmentMap, Extent, LightError, Lights, Receivers, SkySamples};
use crate::plan::Plan;
use crate::sampling::SamplerKind;
use crate::scene::{DeltaLight, Integrator, IntegratorKind, NO_NORMAL, NO_TEXCOORD, Scene};
use std::time::Instant;

/// Seconds and bytes of what was built.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Setup {
    /// To build the tree.
    pub tree_seconds: f64,
    /// To build the rest, most of it at the same time.
    pub tables_seconds: f64,
    /// What was built.
    pub tree: BuildReport,
    /// Of the rows of primitives.
    pub row_bytes: usize,
    /// Of images, counted as often as used.
    pub texture_bytes: usize,
    /// `None` unless the integrator gathers.
    pub gather: Option<GatherReport>,
}

/// Options of preparation that do not belong to the scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Prepare {
    /// Of every random number.
    pub seed: u64,
    /// How the samples of a pixel relate.
    pub sampler: SamplerKind,
    /// Quality of the tree.
    pub build: Preset,
}

impl World {
    /// Builds what the plan keeps.
    ///
    /// # Errors
    /// The lights cannot be tabulated: there are too many, or an intensity is out of range at the kernel's scale.
    pub fn new(scene: &Scene, plan: Plan, options: Prepare) -> Result<World, LightError> {
        let start = Instant::now();
        if !float_mode::is_default() {
            log::warn!(
                "the calling thread has another floating-point mode than IEEE 754's default (subnormals flushed, or \
                 another rounding): bits may differ from those of other programs; prepare scenes on a thread without it"
            );
        }
        let scale = power_of_two_scale(scene);
        let positions: Vec<[f32; 3]> = scene.mesh.positions.iter().map(|p| array::map(*p, |x| x * scale)).collect();
        let spheres: Vec<([f32; 3], f32)> =
            scene.spheres.iter().map(|s| (s.center.map(|x| x * scale), s.radius * scale)).collect();
        let build = if plan.geometry.has_tree() { BuildOptions::trees(options.build) } else { BuildOptions::lists() };
        let ((accel, tree_seconds), (triangles, lights, lights_seconds)) = rayon::join(
            || {
                let accel = Accel::build(&positions, &scene.mesh.triangles, &spheres, build);
                (accel, start.elapsed().as_secs_f64())
            },
            || {
                let triangles = TriangleRows::new(&positions, &scene.mesh.triangles);
                let lights = plan.light_transport.then(|| build_lights(scene, &plan, scale, &positions, &spheres));
                (triangles, lights, start.elapsed().as_secs_f64())
            },
        );
        let lights = lights.transpose()?.flatten();

        let start = Instant::now();
        let tags = if plan.light_transport || plan.cutouts { tag_rows(scene, lights.as_ref()) } else { Rows::new(&[]) };
        let normals = Rows::new(&if plan.vertex_normals { normal_rows(scene) } else { Vec::new() });
        let texcoords = Rows::new(&if plan.texcoords { texcoord_rows(scene) } else { Vec::new() });
        let textures = TextureTable::new(if plan.textures || plan.cutouts || plan.patterned_lights {
            &scene.materials
        } else {
            &[]
        });
        let materials = MaterialTable::new(if plan.light_transport { &scene.materials } else { &[] });
        let setup = Setup {
            tree_seconds,
            tables_seconds: lights_seconds + start.elapsed().as_secs_f64(),
            tree: accel.report().clone(),
            row_bytes: triangles.bytes() + tags.bytes() + normals.bytes() + texcoords.bytes(),
            texture_bytes: textures.bytes(),
            gather: None,
        };
        let mut world = World {
            camera: Camera::new(&scene.camera, scene.film, scale),
            film: scene.film,
            integrator: scene.integrator,
            max_bounces: max_bounces(&scene.integrator),
            roulette: Roulette::of(&scene.integrator),
            seed: options.seed,
            sampler: sampler(&scene.integrator, options.sampler),
            numbers: None,
            accel,
            triangles,
            tags,
            normals,
            texcoords,
            textures,
            spheres: SphereRows::new(&spheres),
            triangle_count: scene.mesh.triangles.len() as u32,
            materials,
            reach: lights.as_ref().filter(|_| plan.last_by_lights).and_then(Lights::reach),
            lights,
            light_paths: None,
            gather: None,
            unit: scale.recip(),
            plan,
            setup,
        };
        world.light_paths = LightPaths::of(&world);
        if scene.integrator.kind == IntegratorKind::Gather {
            gather::prepare(&mut world, &scene.materials);
            world.setup.gather = world.gather.as_ref().map(|tables| tables.report.clone());
        }
        Ok(world)
    }
}

/// Gather rays draw from keys of their own, by points that the scene chooses; the rest is independent.
fn sampler(integrator: &Integrator, wanted: SamplerKind) -> SamplerKind {
    if integrator.kind == IntegratorKind::Gather { SamplerKind::Independent } else { wanted }
}

/// `direct` is a path of one scattering event.
fn max_bounces(integrator: &Integrator) -> f32 {
    match integrator.kind {
        IntegratorKind::Direct => integrator.max_bounces.min(1) as f32,
        _ => integrator.max_bounces as f32,
    }
}

/// The power of two that brings the largest coordinate of scene, lights and camera into [1, 2) (invariant 10).
fn power_of_two_scale(scene: &Scene) -> f32 {
    let vertices = scene.mesh.positions.iter().flatten().copied();
    let spheres = scene.spheres.iter().flat_map(|s| s.center.map(|c| c.abs() + s.radius));
    let lights = scene.delta_lights.iter().filter_map(DeltaLight::position).flatten();
    let largest = vertices.chain(spheres).chain(lights).chain(scene.camera.position).fold(0f32, |m, x| m.max(x.abs()));
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
    scale: f32,
    positions: &[[f32; 3]],
    spheres: &[([f32; 3], f32)],
) -> Result<Option<Lights>, LightError> {
    let emits = |m: u32| scene.materials[m as usize].emits();
    let radiance = |primitive: usize, material: u32| match plan.patterned_lights {
        true => mean_radiance(scene, primitive),
        false => scene.materials[material as usize].emission,
    };
    let triangle = |i: usize| {
        let [a, b, c] = scene.mesh.triangles[i].map(|v| positions[v as usize]);
        EmitterShape::Triangle { p0: a, e1: difference(b, a), e2: difference(c, a) }
    };
    let mut emitters = Vec::new();
    if plan.area_lights {
        for (i, &material) in scene.mesh.material.iter().enumerate().filter(|(_, m)| emits(**m)) {
            let radiance = radiance(i, material);
            emitters.push(Emitter { primitive: i as u32, shape: triangle(i), radiance });
        }
        for (i, sphere) in scene.spheres.iter().enumerate().filter(|(_, s)| emits(s.material)) {
            let primitive = (scene.mesh.triangles.len() + i) as u32;
            let shape = EmitterShape::Sphere { center: spheres[i].0, radius: spheres[i].1 };
            emitters.push(Emitter { primitive, shape, radiance: radiance(primitive as usize, sphere.material) });
        }
    }
    let environment = scene.environment.as_ref().filter(|_| plan.environment);
    let delta = if plan.delta_lights { &scene.delta_lights[..] } else { &[] };
    let samples = if plan.compensated_sky { SkySamples::Compensated } else { SkySamples::Alone };
    let sky = environment.and_then(|sky| EnvironmentMap::sampled(sky, samples));
    let mut lights = Lights::with_delta(emitters, sky, delta, extent(scale, positions, spheres))?;
    if plan.sloped_lamps {
        lights.add_slopes();
    }
    if plan.light_grid {
        lights.add_grid(&Receivers { positions, triangles: &scene.mesh.triangles, spheres });
    }
    Ok(Some(lights).filter(|lights| !lights.is_empty()))
}

/// Of the primitives.
fn extent(scale: f32, positions: &[[f32; 3]], spheres: &[([f32; 3], f32)]) -> Extent {
    let (mut low, mut high) = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
    let points = positions.iter().map(|&p| (p, 0.0)).chain(spheres.iter().copied());
    for (p, r) in points {
        (low, high) = (low.min(glam::Vec3::from(p) - r), high.max(glam::Vec3::from(p) + r));
    }
    let diagonal = (high.as_dvec3() - low.as_dvec3()).length();
    Extent { scale, radius: if diagonal.is_finite() { 0.5 * diagonal } else { 0.0 } }
}

/// Primitive by primitive: triangles, then spheres.
fn tag_rows(scene: &Scene, lights: Option<&Lights>) -> Rows<2> {
    let materials = scene.mesh.material.iter().copied().chain(scene.spheres.iter().map(|s| s.material));
    let light_row = |primitive: usize| lights.map_or(0.0, |lights| lights.emitter_pdf_row(primitive as u32));
    // One that no sample finds (its mean is 0, or next to nothing beside others') is told from what is dark.
    let least = |material: u32| if scene.materials[material as usize].emits() { f32::MIN_POSITIVE } else { 0.0 };
    let row = |(i, material)| [material as f32, light_row(i).max(least(material))];
    Rows::new(&materials.enumerate().map(row).collect::<Vec<_>>())
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// u and v of three vertices a triangle; (0, 0) where it has none.
fn texcoord_rows(scene: &Scene) -> Vec<[f32; 8]> {
    let mesh = &scene.mesh;
    let corner = |i: u32| if i == NO_TEXCOORD { [0.0; 2] } else { mesh.texcoords[i as usize] };
    let row = |indices: &[u32; 3]| {
        let [a, b, c] = indices.map(corner);
        [a[0], a[1], b[0], b[1], c[0], c[1], 0.0, 0.0]
    };
    mesh.texcoord_indices.iter().map(row).collect()
}

/// Three unit normals a triangle, zeros where it is shaded flat: [`Surface`](super::surface::Surface) then
/// takes the geometric normal.
fn normal_rows(scene: &Scene) -> Vec<[f32; 9]> {
    let mesh = &scene.mesh;
    let corner = |n: u32| if n == NO_NORMAL { [0.0; 3] } else { mesh.normals[n as usize] };
    let row = |indices: &[u32; 3]| {
        let [a, b, c] = indices.map(corner);
        [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
    };
    mesh.normal_indices.iter().map(row).collect()
}
