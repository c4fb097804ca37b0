//! Are the numbers of a scene in their domains? What a file says has been looked at where it was read; this is for scenes
//! made or changed in code.

use super::domain::{
    Domain, EXPONENT, EXTINCTION, FIELD_OF_VIEW, FINITE, HALF_ANGLE, METAL_INDEX, NON_NEGATIVE, POSITIVE, UNIT,
};
use super::{
    Bsdf, Camera, ConductorFresnel, DeltaLight, Environment, FilmSize, MOST_BOUNCES, Material, Mesh, NO_NORMAL,
    NO_TEXCOORD, Scene, Sphere,
};
use crate::geometry::MOST_PRIMITIVES;
use glam::DVec3;

/// How far a unit vector's length may be off 1.
const UNIT_LENGTH_ERROR: f64 = 1e-4;
/// How far kd + ks may be above 1: rounding.
const ENERGY_ERROR: f32 = 1e-5;

/// What of a scene is out of its domain, said in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{part}: {what}")]
pub struct InvalidScene {
    /// Which part, by its index.
    pub part: String,
    /// What is wrong with it, and what it must be.
    pub what: String,
}

type Valid = Result<(), InvalidScene>;

impl Scene {
    /// Looks at every number and index.
    ///
    /// # Errors
    /// The first that would not render as it stands.
    pub fn validate(&self) -> Valid {
        self.camera.validate()?;
        let sides = [self.film.width, self.film.height];
        require(
            self.film.is_possible(),
            || "film".into(),
            || {
                let (longest, most) = (FilmSize::LONGEST_SIDE, FilmSize::MOST_PIXELS);
                format!("{} × {} pixels; each side is in 1 … {longest}, {most} at most in all", sides[0], sides[1])
            },
        )?;
        let bounces = self.integrator.max_bounces;
        require(
            bounces <= MOST_BOUNCES,
            || "integrator".into(),
            || format!("{bounces} bounces; at most {MOST_BOUNCES}"),
        )?;
        for (i, material) in self.materials.iter().enumerate() {
            material.validate(&|| format!("material {i}"))?;
        }
        let primitives = self.mesh.triangles.len() + self.spheres.len();
        require(
            primitives <= MOST_PRIMITIVES,
            || "scene".into(),
            || format!("{primitives} triangles and spheres; at most {MOST_PRIMITIVES}"),
        )?;
        self.mesh.validate(self.materials.len())?;
        for (i, sphere) in self.spheres.iter().enumerate() {
            sphere.validate(self.materials.len(), &|| format!("sphere {i}"))?;
        }
        for (i, light) in self.delta_lights.iter().enumerate() {
            light.validate(&|| format!("light {i}"))?;
        }
        self.environment.as_ref().map_or(Ok(()), Environment::validate)
    }
}

type Part<'a> = &'a dyn Fn() -> String;

fn require(holds: bool, part: impl Fn() -> String, what: impl FnOnce() -> String) -> Valid {
    if holds { Ok(()) } else { Err(InvalidScene { part: part(), what: what() }) }
}

fn within(part: Part, name: &str, values: &[f32], domain: &Domain) -> Valid {
    match values.iter().find(|&&x| !(domain.contains)(x)) {
        None => Ok(()),
        Some(x) => require(false, part, || format!("{name} is {x}; it must be {}", domain.words)),
    }
}

fn unit(part: Part, name: &str, v: [f32; 3]) -> Valid {
    let length = DVec3::from(v.map(f64::from)).length();
    require((length - 1.0).abs() <= UNIT_LENGTH_ERROR, part, || format!("{name} {v:?} is not a unit vector"))
}

fn index(part: Part, name: &str, index: u32, count: usize) -> Valid {
    require((index as usize) < count, part, || format!("{name} {index} of {count}; indices begin at 0"))
}

impl Camera {
    fn validate(&self) -> Valid {
        let part: Part = &|| "camera".to_owned();
        for (name, v) in [("position", self.position), ("look_at", self.look_at), ("up", self.up)] {
            within(part, name, &v, &FINITE)?;
        }
        within(part, "vfov", &[self.vfov], &FIELD_OF_VIEW)?;
        within(part, "lens_radius", &[self.lens_radius], &NON_NEGATIVE)?;
        within(part, "focus_distance", &[self.focus_distance], &POSITIVE)?;
        let v = |a: [f32; 3]| DVec3::from(a.map(f64::from));
        let way = v(self.look_at) - v(self.position);
        let right = way.normalize_or_zero().cross(v(self.up).normalize_or_zero());
        require(right.length() > 1e-6, part, || "`up` is parallel to the viewing direction, or one of them is 0".into())
    }
}

impl Material {
    fn validate(&self, part: Part) -> Valid {
        within(part, "emission", &self.emission, &NON_NEGATIVE)?;
        within(part, "opacity", &[self.opacity], &UNIT)?;
        let index_of_refraction = |ior: f32| within(part, "ior", &[ior], &POSITIVE);
        match self.bsdf {
            Bsdf::Diffuse { reflectance } => within(part, "reflectance", &reflectance, &UNIT),
            Bsdf::Conductor { alpha, fresnel, .. } => {
                within(part, "alpha", &[alpha], &UNIT)?;
                match fresnel {
                    ConductorFresnel::Exact { eta, k } => {
                        within(part, "eta", &eta, &METAL_INDEX)?;
                        within(part, "k", &k, &EXTINCTION)
                    }
                    ConductorFresnel::Schlick { f0 } => within(part, "f0", &f0, &UNIT),
                    ConductorFresnel::Constant { reflectance } => within(part, "reflectance", &reflectance, &UNIT),
                }
            }
            Bsdf::Dielectric { alpha, ior, .. } => {
                within(part, "alpha", &[alpha], &UNIT)?;
                index_of_refraction(ior)
            }
            Bsdf::Phong { diffuse, specular, exponent } => {
                within(part, "diffuse", &diffuse, &UNIT)?;
                within(part, "specular", &specular, &UNIT)?;
                within(part, "exponent", &[exponent], &EXPONENT)?;
                let most = (0..3).map(|c| diffuse[c] + specular[c]).fold(0.0, f32::max);
                require(most <= 1.0 + ENERGY_ERROR, part, || format!("diffuse + specular is {most}, above 1"))
            }
            Bsdf::Coated { reflectance, alpha, ior, .. } => {
                within(part, "reflectance", &reflectance, &UNIT)?;
                within(part, "alpha", &[alpha], &UNIT)?;
                index_of_refraction(ior)
            }
        }
    }
}

impl Mesh {
    fn validate(&self, materials: usize) -> Valid {
        let part: Part = &|| "mesh".to_owned();
        let triangles = self.triangles.len();
        require(self.material.len() == triangles, part, || {
            format!("{} materials for {triangles} triangles", self.material.len())
        })?;
        for (name, held) in [("normal", self.normal_indices.len()), ("texcoord", self.texcoord_indices.len())] {
            require(held == 0 || held == triangles, part, || {
                format!("{held} {name} indices for {triangles} triangles")
            })?;
        }
        for (i, p) in self.positions.iter().enumerate() {
            within(&|| format!("position {i}"), "a coordinate", p, &FINITE)?;
        }
        for (i, n) in self.normals.iter().enumerate() {
            unit(&|| format!("normal {i}"), "it", *n)?;
        }
        for (i, t) in self.texcoords.iter().enumerate() {
            within(&|| format!("texture coordinate {i}"), "a coordinate", t, &FINITE)?;
        }
        for i in 0..triangles {
            let part: Part = &|| format!("triangle {i}");
            index(part, "material", self.material[i], materials)?;
            self.triangles[i].iter().try_for_each(|&corner| index(part, "position", corner, self.positions.len()))?;
            let present = |indices: &[[u32; 3]], none: u32| {
                let corners = indices.get(i).copied().unwrap_or([none; 3]);
                corners.into_iter().filter(move |&corner| corner != none)
            };
            present(&self.normal_indices, NO_NORMAL).try_for_each(|n| index(part, "normal", n, self.normals.len()))?;
            present(&self.texcoord_indices, NO_TEXCOORD)
                .try_for_each(|t| index(part, "texture coordinate", t, self.texcoords.len()))?;
        }
        Ok(())
    }
}

impl Sphere {
    fn validate(&self, materials: usize, part: Part) -> Valid {
        within(part, "center", &self.center, &FINITE)?;
        within(part, "radius", &[self.radius], &POSITIVE)?;
        within(part, "its furthest coordinate", &self.center.map(|c| c.abs() + self.radius), &FINITE)?;
        index(part, "material", self.material, materials)
    }
}

impl DeltaLight {
    fn validate(&self, part: Part) -> Valid {
        within(part, "its strength", &self.strength(), &NON_NEGATIVE)?;
        if let Some(position) = self.position() {
            within(part, "position", &position, &FINITE)?;
        }
        match *self {
            DeltaLight::Point { .. } => Ok(()),
            DeltaLight::Directional { direction, .. } => unit(part, "direction", direction),
            DeltaLight::Spot { direction, angle, .. } => {
                unit(part, "direction", direction)?;
                within(part, "angle", &[angle], &HALF_ANGLE)
            }
        }
    }
}

impl Environment {
    fn validate(&self) -> Valid {
        let part: Part = &|| "environment".to_owned();
        match self {
            Environment::Constant(radiance) => within(part, "radiance", radiance, &NON_NEGATIVE),
            Environment::Image(image) => {
                let (held, wanted) = (image.texels.len(), image.width.saturating_mul(image.height));
                require(held == wanted && held > 0, part, || format!("{held} texels for {wanted} pixels"))?;
                within(part, "rotation", &[image.rotation], &FINITE)?;
                image.texels.iter().try_for_each(|texel| within(part, "a texel", texel, &NON_NEGATIVE))
            }
        }
    }
}
