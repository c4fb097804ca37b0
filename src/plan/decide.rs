//! The decisions themselves, each with its reason.

use super::{BRUTE_FORCE_LIMIT, Decision, Feature, Force, GeometryMode, Plan, Shading};
use crate::light::{FEW_EMITTERS, MANY_LIGHTS};
use crate::scene::{Bsdf, Environment, IntegratorKind, Material, NO_NORMAL, Scene};
use std::collections::BTreeSet;

impl Plan {
    /// Decides for a scene, but keeps `feature`, needed or not.
    pub fn keeping(feature: Option<Feature>, scene: &Scene, force: Force, albedo: bool) -> Self {
        let on = |which: Feature| feature == Some(which);
        // What the general kernel keeps.
        let forced = |which: Feature| force.general || on(which);
        let light_transport = scene.integrator.kind.transports_light() || albedo || force.general;
        let primitives = scene.mesh.triangles.len() + scene.spheres.len();
        let mut decisions = Vec::new();
        let mut decide = |what, kept: bool, why: String| {
            decisions.push(Decision { what, kept, why });
            kept
        };

        let small = primitives <= BRUTE_FORCE_LIMIT;
        let geometry =
            force.geometry.unwrap_or(if small && !force.general { GeometryMode::Brute } else { GeometryMode::Tree });
        let why = match force.geometry {
            Some(mode) => format!("{primitives} primitives; asked for: {}", mode.describe()),
            None if small => format!("{primitives} primitives, at most {BRUTE_FORCE_LIMIT}"),
            None => format!("{primitives} primitives, more than {BRUTE_FORCE_LIMIT}"),
        };
        decide("tree", geometry.has_tree(), why);

        let used = used_materials(scene);
        let count = |is: fn(&Material) -> bool| used.iter().filter(|&&m| is(&scene.materials[m])).count();
        let mut model = |which: Feature, is: fn(&Material) -> bool| {
            let wearing = count(is);
            let why = format!("{wearing} of {} used materials scatter so", used.len());
            decide(which.name(), light_transport && (wearing > 0 || forced(which)), why)
        };
        let microfacets = model(Feature::Microfacets, |m| {
            matches!(m.bsdf, Bsdf::Conductor { .. } | Bsdf::Dielectric { .. }) || m.maps.metallic.is_some()
        });
        let phong = model(Feature::Phong, |m| matches!(m.bsdf, Bsdf::Phong { .. }));
        let coated = model(Feature::Coated, |m| matches!(m.bsdf, Bsdf::Coated { .. }));
        let general = microfacets || phong || coated;

        let sphere_count = scene.spheres.len();
        let spheres = decide("spheres", sphere_count > 0 || on(Feature::Spheres), format!("{sphere_count} spheres"));
        let images = Images::of(scene, &used);
        let smooth = scene.mesh.normal_indices.iter().filter(|n| n[0] != NO_NORMAL).count();
        let vertex_normals = decide(
            "vertex normals",
            smooth > 0,
            format!("{smooth} of {} triangles are smooth", scene.mesh.triangles.len()),
        );
        let bent = if light_transport { images.bent } else { 0 };
        let why = format!("{bent} of {} used materials have images of them", used.len());
        let shading_normals = decide("shading normals", vertex_normals || bent > 0, why);
        let (lit, why) = match &scene.environment {
            None => (false, "none in the scene".to_string()),
            Some(Environment::Constant(c)) => (c.iter().any(|&x| x > 0.0), format!("constant {c:?}")),
            Some(Environment::Image(i)) => (true, format!("{}×{} image", i.width, i.height)),
        };
        let environment = decide("environment", (lit || on(Feature::Environment)) && light_transport, why);
        let by_path = matches!(scene.integrator.kind, IntegratorKind::Path | IntegratorKind::Direct);
        let compensated_sky = decide(
            "compensated sky",
            environment && by_path && matches!(scene.environment, Some(Environment::Image(_))),
            "for images whose samples stand beside those of materials".to_string(),
        );
        let emitters = used.iter().filter(|&&m| scene.materials[m].emission.iter().any(|&e| e > 0.0)).count();
        let area_lights = decide(
            "area lights",
            (emitters > 0 || on(Feature::AreaLights)) && light_transport,
            format!("{emitters} used materials emit"),
        );
        let lamps = emitting_primitives(scene);
        let light_grid = decide(
            "lights chosen by place",
            area_lights && by_path && lamps >= MANY_LIGHTS,
            format!("{lamps} primitives emit, {MANY_LIGHTS} are many"),
        );
        let shining = scene.delta_lights.iter().filter(|l| l.strength().iter().any(|&c| c > 0.0)).count();
        let why = format!("{shining} in the scene");
        let delta_lights =
            decide("lights without extent", (shining > 0 || on(Feature::DeltaLights)) && light_transport, why);
        let (wanted, why) = super::light_paths::decide(scene, &used, lamps);
        let light_paths = decide("paths from the lights", wanted, why);
        let last_by_lights = decide(
            "last vertex by lights",
            by_path && lamps > 0 && lamps <= FEW_EMITTERS && !lit && !light_paths && images.patterned == 0,
            format!(
                "{lamps} primitives emit, {FEW_EMITTERS} are few; the rest of the light and {} patterned ones, which may hide \
                 from the choice of lights, count against it",
                images.patterned
            ),
        );
        let (possible, why) = super::path_reuse::decide(scene, used.iter().map(|&m| &scene.materials[m]), light_paths);
        let path_reuse = decide("path reuse", possible, why);
        let radius = scene.camera.lens_radius;
        let lens = decide("lens", radius > 0.0, format!("its radius is {radius}"));
        let textures = decide(
            "textures",
            light_transport && (images.shading > 0 || forced(Feature::Textures)),
            format!("{} of {} used materials have images", images.shading, used.len()),
        );
        let cutouts = decide(
            "cut-outs",
            images.cut_out > 0 || forced(Feature::CutOuts),
            format!("{} used materials let rays pass", images.cut_out),
        );
        let patterned_lights = decide(
            "patterned lights",
            area_lights && (images.patterned > 0 || forced(Feature::PatternedLights)),
            format!("{} used materials emit unevenly", images.patterned),
        );
        let mapped = scene.mesh.texcoords.len();
        let events = scene.integrator.max_bounces;
        let sloped_lamps = decide(
            "lamps by their slope",
            area_lights && scene.integrator.kind == IntegratorKind::Path && events > 1 && images.patterned == 0,
            format!("{events} bounces: from the second on, paths come close to lamps; {} patterned", images.patterned),
        );
        let texcoords = decide(
            "texture coordinates",
            mapped > 0 && (textures || cutouts),
            format!("{mapped} in meshes that wear images"),
        );
        decide("light transport", light_transport, format!("integrator {:?}", scene.integrator.kind).to_lowercase());

        let gather = Some(&scene.integrator).filter(|i| i.kind == IntegratorKind::Gather).map(|i| &i.gather);
        // One direction alone says nothing of a variance.
        let believes = gather.is_some_and(|g| g.method.is_bayesian() && g.samples > 1);
        let why = if albedo { "features are written" } else { "features are not written" }.to_string();
        let posterior = believes && decide("posterior variance", albedo, why);

        let shading = if general { Shading::General } else { Shading::Lambert };
        Plan {
            geometry,
            shading,
            phong,
            coated,
            spheres,
            vertex_normals,
            shading_normals,
            environment,
            compensated_sky,
            area_lights,
            last_by_lights,
            light_grid,
            sloped_lamps,
            delta_lights,
            light_paths,
            path_reuse,
            lens,
            textures,
            cutouts,
            patterned_lights,
            texcoords,
            light_transport,
            posterior,
            decisions,
        }
    }
}

/// How many of the used materials have images or opacity below 1, and for what.
struct Images {
    shading: usize,
    cut_out: usize,
    patterned: usize,
    bent: usize,
}

impl Images {
    fn of(scene: &Scene, used: &BTreeSet<usize>) -> Self {
        let count = |has: fn(&Material) -> bool| used.iter().filter(|&&m| has(&scene.materials[m])).count();
        Images {
            shading: count(|m| m.maps.shade()),
            cut_out: count(Material::is_cut_out),
            patterned: count(Material::is_patterned),
            bent: count(|m| m.maps.normal.is_some()),
        }
    }
}

fn emitting_primitives(scene: &Scene) -> usize {
    let materials = scene.mesh.material.iter().copied().chain(scene.spheres.iter().map(|s| s.material));
    materials.filter(|&m| scene.materials[m as usize].emits()).count()
}

/// Materials that some primitive refers to.
fn used_materials(scene: &Scene) -> BTreeSet<usize> {
    let of_triangles = scene.mesh.material.iter().map(|&m| m as usize);
    of_triangles.chain(scene.spheres.iter().map(|s| s.material as usize)).collect()
}
