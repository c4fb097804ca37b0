//! What the user writes, validated: the only input of the [plan](crate::plan).
//!
//! World: right-handed. Colours: linear RGB, Rec. 709 primaries. Radiance: W·sr⁻¹·m⁻² per channel. Lengths: the
//! scene's own unit, not yet rescaled (that happens when a scene is prepared for the kernel).

mod bare_model;
mod builder;
mod coincident;
mod domain;
mod draft;
mod environment;
mod error;
mod fingerprint;
mod gather;
mod image_file;
mod integrator;
mod light_paths;
mod load;
mod materials;
mod mesh_file;
mod mtl;
mod mtl_file;
mod mtl_maps;
mod notes;
mod obj;
mod obj_feed;
mod obj_outline;
mod obj_texcoords;
mod obj_words;
mod path_reuse;
mod polygons;
mod roulette;
mod statements;
mod surroundings;
mod texture;
mod toml_file;
mod toml_integrator;
mod toml_light;
mod toml_material;
mod toml_text;
mod transform;
mod validate;

pub use builder::SceneBuilder;
pub use error::SceneError;
pub use gather::{Gather, GatherCovariance, GatherLights, GatherMethod, GatherPdf, GatherShrinkage, GatherWeights};
pub use integrator::{Integrator, IntegratorKind, MOST_BOUNCES};
pub use light_paths::LightPaths;
pub use load::load;
pub use path_reuse::PathReuse;
pub use roulette::Roulette;
pub use texture::{Channel, FileName, Image, Maps, Texels, Texture};
pub use validate::InvalidScene;

/// A validated scene. Every number in it is finite and inside its documented domain; every index is in range.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where it came from: the path as the user gave it.
    pub name: String,
    /// From where it is seen.
    pub camera: Camera,
    /// In pixels.
    pub film: FilmSize,
    /// How light is followed.
    pub integrator: Integrator,
    /// Light from outside.
    pub environment: Option<Environment>,
    /// Lights without extent.
    pub delta_lights: Vec<DeltaLight>,
    /// All meshes, transformed and concatenated in file order.
    pub mesh: Mesh,
    /// Numbered after the triangles.
    pub spheres: Vec<Sphere>,
    /// Indexed by [`Mesh::material`] and [`Sphere::material`].
    pub materials: Vec<Material>,
    /// What was assumed where a bare model left it open, one sentence each, to be printed.
    pub assumptions: Vec<String>,
    /// The files it was read from, images and libraries of materials among them: nothing may be written over these.
    pub files: Vec<std::path::PathBuf>,
}

/// A thin-lens camera. `right = forward × up`; image row 0 is the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The centre of the lens.
    pub position: [f32; 3],
    /// Differs from `position`.
    pub look_at: [f32; 3],
    /// Not parallel to the viewing direction.
    pub up: [f32; 3],
    /// Full vertical field of view in degrees, in (0, 180).
    pub vfov: f32,
    /// ≥ 0; 0 is a pinhole.
    pub lens_radius: f32,
    /// From the lens to the plane that is sharp, along the viewing direction. > 0.
    pub focus_distance: f32,
}

/// Film size in pixels, each side in 1 … [`FilmSize::LONGEST_SIDE`], at most [`FilmSize::MOST_PIXELS`] in all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmSize {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl FilmSize {
    /// Of a film.
    pub const LONGEST_SIDE: u32 = 65_536;
    /// Beyond, a film's sums alone would take tens of gigabytes.
    pub const MOST_PIXELS: u64 = 1 << 28;

    /// Are there pixels, and not too many?
    pub fn is_possible(self) -> bool {
        let sides = [self.width, self.height];
        let pixels = u64::from(self.width) * u64::from(self.height);
        sides.iter().all(|side| (1..=Self::LONGEST_SIDE).contains(side)) && pixels <= Self::MOST_PIXELS
    }
}

/// Radiance that comes in from outside the scene.
#[derive(Clone, Debug)]
pub enum Environment {
    /// The same radiance from everywhere.
    Constant([f32; 3]),
    /// By direction.
    Image(EnvironmentImage),
}

/// A latitude-longitude image. Row 0 looks to +y; texel row j covers v = [j, j+1)/height; u = atan2(x, −z)/2π wrapped
/// to [0, 1). Bilinear between texel centres, wrapping in u, clamped in v.
#[derive(Clone, Debug)]
pub struct EnvironmentImage {
    /// Columns of texels.
    pub width: usize,
    /// Rows of texels.
    pub height: usize,
    /// Row-major RGB radiance, already multiplied by the scene's `radiance`; finite and ≥ 0.
    pub texels: Vec<[f32; 3]>,
    /// Degrees by which the environment is turned about +y, counter-clockwise seen from above.
    pub rotation: f32,
}

/// A light without extent: no ray meets it. Strengths are ≥ 0, directions unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // fields: as the variant says
pub enum DeltaLight {
    /// `intensity` in W·sr⁻¹.
    Point { position: [f32; 3], intensity: [f32; 3] },
    /// `direction` is the way the light travels; `irradiance` in W·m⁻² on a plane perpendicular to it.
    Directional { direction: [f32; 3], irradiance: [f32; 3] },
    /// A point light that is dark outside a cone of half-angle `angle` degrees, in (0, 180], about `direction`.
    Spot { position: [f32; 3], direction: [f32; 3], intensity: [f32; 3], angle: f32 },
}

impl DeltaLight {
    /// Intensity or irradiance.
    pub fn strength(&self) -> [f32; 3] {
        match *self {
            DeltaLight::Point { intensity, .. } | DeltaLight::Spot { intensity, .. } => intensity,
            DeltaLight::Directional { irradiance, .. } => irradiance,
        }
    }

    /// Where it is, unless infinitely far away.
    pub fn position(&self) -> Option<[f32; 3]> {
        match *self {
            DeltaLight::Point { position, .. } | DeltaLight::Spot { position, .. } => Some(position),
            DeltaLight::Directional { .. } => None,
        }
    }

    pub(crate) fn is_directional(&self) -> bool {
        matches!(self, DeltaLight::Directional { .. })
    }
}

/// Triangles after their transform, winding flipped where the transform mirrors.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Of vertices, in the scene's unit.
    pub positions: Vec<[f32; 3]>,
    /// Three indices into `positions` a triangle, in file order: the triangle's index is its identity.
    pub triangles: Vec<[u32; 3]>,
    /// One material a triangle.
    pub material: Vec<u32>,
    /// Unit shading normals; empty where no mesh has any.
    pub normals: Vec<[f32; 3]>,
    /// Three indices into `normals` a triangle, [`NO_NORMAL`] where it has none; empty where `normals` is.
    pub normal_indices: Vec<[u32; 3]>,
    /// Texture coordinates; empty where no material in use has a texture.
    pub texcoords: Vec<[f32; 2]>,
    /// Three indices into `texcoords` a triangle, [`NO_TEXCOORD`] where it has none; empty where `texcoords` is.
    pub texcoord_indices: Vec<[u32; 3]>,
}

/// In [`Mesh::normal_indices`]: this triangle is shaded flat.
pub const NO_NORMAL: u32 = u32::MAX;

/// In [`Mesh::texcoord_indices`]: this corner reads textures at (0, 0).
pub const NO_TEXCOORD: u32 = u32::MAX;

/// A sphere that emits and scatters on its outside; its inside is a surface, too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// In the scene's unit.
    pub center: [f32; 3],
    /// > 0.
    pub radius: f32,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// How a surface scatters, emits and lets rays pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For people.
    pub name: String,
    /// How it scatters.
    pub bsdf: Bsdf,
    /// Radiance from the front side: counter-clockwise triangles, outside of spheres. ≥ 0.
    pub emission: [f32; 3],
    /// The probability with which a ray that arrives sees the surface at all; others go on as if it were not there,
    /// which is not a bounce. In [0, 1].
    pub opacity: f32,
    /// Images that multiply the numbers above.
    pub maps: Maps,
}

impl Default for Material {
    /// Black, opaque, nameless.
    fn default() -> Self {
        Material {
            name: String::new(),
            bsdf: Bsdf::Diffuse { reflectance: [0.0; 3] },
            emission: [0.0; 3],
            opacity: 1.0,
            maps: Maps::default(),
        }
    }
}

impl Material {
    /// May a ray pass through it?
    pub fn is_cut_out(&self) -> bool {
        self.opacity < 1.0 || self.maps.opacity.is_some()
    }

    /// Does radiance times opacity change over what wears it, or differ from its emission?
    pub fn is_patterned(&self) -> bool {
        self.emits() && (self.maps.emission.is_some() || self.is_cut_out())
    }

    /// Does it emit anything?
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&e| e > 0.0)
    }
}

/// How a surface scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // fields: as the variant says
pub enum Bsdf {
    /// Lambert: f = ρ/π, both sides. ρ in [0, 1].
    Diffuse { reflectance: [f32; 3] },
    /// GGX microfacets of a metal, both sides; `alpha` = 0 is a perfect mirror. `alpha` in [0, 1].
    Conductor { alpha: f32, masking: Masking, fresnel: ConductorFresnel },
    /// Reflects and refracts; `alpha` = 0 is smooth. Outside (where the normal points) the index is 1.
    Dielectric { alpha: f32, masking: Masking, ior: f32 },
    /// kd/π + ks (n + 2)/2π cosⁿα, α from the mirror direction; both sides. kd + ks ≤ 1 up to rounding, n in
    /// [0, [`EXPONENT_MAX`](crate::bsdf::EXPONENT_MAX)].
    Phong { diffuse: [f32; 3], specular: [f32; 3], exponent: f32 },
    /// Lambert under a dielectric coat of GGX microfacets; both sides. `alpha` = 0 is a smooth coat.
    Coated { reflectance: [f32; 3], alpha: f32, masking: Masking, ior: f32 },
}

/// Smith masking-shadowing of two directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Masking {
    /// Height-correlated: 1/(1 + Λ(wo) + Λ(wi)).
    Correlated,
    /// G1(wo)·G1(wi).
    Separable,
}

/// Reflectance of a metal by angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // fields: as the variant says
pub enum ConductorFresnel {
    /// Exact unpolarised Fresnel of the complex index η + ik per channel.
    Exact { eta: [f32; 3], k: [f32; 3] },
    /// Schlick's approximation from reflectance at normal incidence.
    Schlick { f0: [f32; 3] },
    /// No Fresnel: a constant reflectance.
    Constant { reflectance: [f32; 3] },
}
