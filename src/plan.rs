//! The plan: what this scene needs, decided once, before anything is built.
//!
//! A stage that a scene does not need is not there: its data is not built, its code not entered (invariant 3). The
//! plan is a pure function of the scene and the options; thresholds are compiled constants found by measuring
//! (`benches/README.md`). A kernel specialised to a scene gives the general kernel's bits on it.

mod light_paths;
mod path_reuse;

use crate::light::{FEW_EMITTERS, MANY_LIGHTS};
use crate::scene::{Bsdf, Environment, IntegratorKind, Material, NO_NORMAL, Scene};
use std::collections::BTreeSet;

/// Up to this many primitives a ray is tested against all of them and no tree is built.
pub const BRUTE_FORCE_LIMIT: usize = 64;

/// How rays find geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GeometryMode {
    /// Every primitive in turn; no tree exists.
    Brute,
    /// An 8-wide tree: camera rays as packets, rays after a bounce one by one against eight children.
    Tree,
}

/// Which scattering models the kernel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Shading {
    /// Lambert alone: no microfacet, Fresnel or delta code.
    Lambert,
    /// All models.
    General,
}

/// One thing the plan decided, for `--explain`.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Decision {
    /// The stage.
    pub what: &'static str,
    /// Is it there?
    pub kept: bool,
    /// What of the scene decided.
    pub why: String,
}

/// A stage that may be kept where a scene does not need it, with the bits unchanged. Shading normals and the lens are
/// none: where a scene has them their arithmetic rounds differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feature {
    /// Conductor and dielectric, and the kernel that holds all models.
    Microfacets,
    /// The Phong model.
    Phong,
    /// The coated model.
    Coated,
    /// Spheres among the primitives.
    Spheres,
    /// Light from outside.
    Environment,
    /// Emission at hits.
    AreaLights,
    /// Lights without extent.
    DeltaLights,
    /// Images that change how materials scatter or emit.
    Textures,
    /// Surfaces that rays may pass.
    CutOuts,
    /// Emitters that an image patterns.
    PatternedLights,
}

impl Feature {
    /// All of them.
    pub const ALL: [Feature; 10] = [
        Feature::Microfacets,
        Feature::Phong,
        Feature::Coated,
        Feature::Spheres,
        Feature::Environment,
        Feature::AreaLights,
        Feature::DeltaLights,
        Feature::Textures,
        Feature::CutOuts,
        Feature::PatternedLights,
    ];

    /// As `--explain` has it.
    pub fn name(self) -> &'static str {
        match self {
            Feature::Microfacets => "conductor and dielectric",
            Feature::Phong => "phong",
            Feature::Coated => "coated",
            Feature::Spheres => "spheres",
            Feature::Environment => "environment",
            Feature::AreaLights => "area lights",
            Feature::DeltaLights => "lights without extent",
            Feature::Textures => "textures",
            Feature::CutOuts => "cut-outs",
            Feature::PatternedLights => "patterned lights",
        }
    }
}

/// What is forced instead of decided: for `check`, ablations and tests.
#[derive(Clone, Copy, Debug, Default)]
pub struct Force {
    /// Keep every stage: the general kernel.
    pub general: bool,
    /// How rays find geometry.
    pub geometry: Option<GeometryMode>,
}

/// What the kernel and the prepared data hold for a scene.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Plan {
    /// How rays find geometry.
    pub geometry: GeometryMode,
    /// Models the kernel holds.
    pub shading: Shading,
    /// Is the Phong model kept, is the coated one? (Conductor and dielectric come with [`Shading::General`].)
    pub phong: bool,
    /// See [`Plan::phong`].
    pub coated: bool,
    /// Are there spheres?
    pub spheres: bool,
    /// Do triangles have normals of their own, or images of them?
    pub shading_normals: bool,
    /// Does light come from outside?
    pub environment: bool,
    /// Do light samples leave the even part of the sky to the materials' own? The same in the general kernel: it decides on
    /// samples.
    pub compensated_sky: bool,
    /// Do primitives emit?
    pub area_lights: bool,
    /// Do light samples alone light the last vertex of a path, where they suffice? The same in the general kernel: it decides on
    /// samples.
    pub last_by_lights: bool,
    /// Is there a table of them for each part of the scene? The same in the general kernel: it decides on samples.
    pub light_grid: bool,
    /// Point, spot and directional lights.
    pub delta_lights: bool,
    /// Are paths traced from the lights, too? The same in the general kernel: it decides on samples.
    pub light_paths: bool,
    /// Do pixels share what their paths find after the first bounce? The same in the general kernel: it decides on samples.
    pub path_reuse: bool,
    /// Does the camera have a lens of some size?
    pub lens: bool,
    /// Images that change how materials scatter or emit.
    pub textures: bool,
    /// Surfaces that rays may pass.
    pub cutouts: bool,
    /// Emitters whose radiance is not the same all over.
    pub patterned_lights: bool,
    /// Texture coordinates of triangles.
    pub texcoords: bool,
    /// Materials, emission and lights: absent in the views `normals`, `depth` and `hit`.
    pub light_transport: bool,
    /// What a Gaussian process believes of its estimates' variance.
    pub posterior: bool,
    /// All of the above, with reasons.
    pub decisions: Vec<Decision>,
}

impl IntegratorKind {
    /// Does it estimate radiance (rather than show geometry)?
    pub fn transports_light(self) -> bool {
        !matches!(self, IntegratorKind::Normals | IntegratorKind::Depth | IntegratorKind::Hit)
    }
}

impl Plan {
    /// Decides for a scene. `albedo` says whether first-hit features are written too.
    pub fn new(scene: &Scene, force: Force, albedo: bool) -> Self {
        Self::keeping(None, scene, force, albedo)
    }

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
        let order = if small { "at most" } else { "more than" };
        decide("tree", geometry == GeometryMode::Tree, format!("{primitives} primitives, {order} {BRUTE_FORCE_LIMIT}"));

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
        let smooth = scene.mesh.normal_indices.iter().filter(|n| n[0] != NO_NORMAL).count();
        let shading_normals = decide(
            "shading normals",
            smooth > 0,
            format!("{smooth} of {} triangles are smooth", scene.mesh.triangles.len()),
        );
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
        let (wanted, why) = light_paths::decide(scene, &used, lamps);
        let light_paths = decide("paths from the lights", wanted, why);
        let last_by_lights = decide(
            "last vertex by lights",
            by_path && lamps > 0 && lamps <= FEW_EMITTERS && !lit && !light_paths,
            format!("{lamps} primitives emit, {FEW_EMITTERS} are few; the rest of the light counts against it"),
        );
        let (possible, why) = path_reuse::decide(scene, used.iter().map(|&m| &scene.materials[m]), light_paths);
        let path_reuse = decide("path reuse", possible, why);
        let radius = scene.camera.lens_radius;
        let lens = decide("lens", radius > 0.0, format!("its radius is {radius}"));
        let images = Images::of(scene, &used);
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
            shading_normals,
            environment,
            compensated_sky,
            area_lights,
            last_by_lights,
            light_grid,
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

    /// The same for light samples that stand alone, or beside those of materials that are not the scene's and may not reach all
    /// that they scatter.
    pub fn with_light_samples_alone(self) -> Self {
        Plan { compensated_sky: false, last_by_lights: false, path_reuse: false, ..self }
    }

    /// Is a feature kept?
    pub fn keeps(&self, feature: Feature) -> bool {
        self.decisions.iter().any(|decision| decision.what == feature.name() && decision.kept)
    }

    /// The plan as a person reads it, one line a decision.
    pub fn explain(&self) -> String {
        let lines = self
            .decisions
            .iter()
            .map(|d| format!("  {:8} {:26} {}\n", if d.kept { "kept" } else { "left out" }, d.what, d.why));
        format!("plan: geometry {:?}, shading {:?}\n{}", self.geometry, self.shading, lines.collect::<String>())
    }
}

/// How many of the used materials have images or opacity below 1, and for what.
struct Images {
    shading: usize,
    cut_out: usize,
    patterned: usize,
}

impl Images {
    fn of(scene: &Scene, used: &BTreeSet<usize>) -> Self {
        let count = |has: fn(&Material) -> bool| used.iter().filter(|&&m| has(&scene.materials[m])).count();
        Images {
            shading: count(|m| m.maps.shade()),
            cut_out: count(Material::is_cut_out),
            patterned: count(Material::is_patterned),
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
