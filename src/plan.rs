//! The plan: what this scene needs, decided once, before anything is built.
//!
//! A stage that a scene does not need is not there: its data is not built, its code not entered (invariant 3). The
//! plan is a pure function of the scene and the options; thresholds are compiled constants found by measuring
//! (`benches/README.md`). A kernel specialised to a scene gives the general kernel's bits on it.

mod decide;
mod geometry;
mod light_paths;
mod path_reuse;

use crate::scene::{IntegratorKind, Scene};
pub use geometry::{BRUTE_FORCE_LIMIT, BRUTE_FORCE_MOST, GeometryMode};

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

/// What is forced instead of decided: by `--mode` and `--general`, for `check`, ablations and tests.
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
    /// Do vertices of triangles have normals of their own?
    pub vertex_normals: bool,
    /// Are there normals that are not those of the geometry, of vertices or of images?
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
    /// Are lamps sampled more where they send more to a receiver? The same in the general kernel: it decides on samples.
    pub sloped_lamps: bool,
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
