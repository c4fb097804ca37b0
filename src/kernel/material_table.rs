//! Materials as they are stored: one row each, fetched by the lanes that hit it.

use super::material::MaterialAt;
use crate::geometry::Rows;
use crate::lane::{Real, Vec3};
use crate::scene::{self, Bsdf, Masking, Material};

/// How models are told apart in a row.
pub(super) const KIND_DIFFUSE: f32 = 0.0;
pub(super) const KIND_CONDUCTOR: f32 = 1.0;
pub(super) const KIND_DIELECTRIC: f32 = 2.0;
pub(super) const KIND_PHONG: f32 = 3.0;
pub(super) const KIND_COATED: f32 = 4.0;

/// How [`ConductorFresnel`](crate::bsdf::ConductorFresnel) is told apart in a row.
pub(super) const FRESNEL_EXACT: f32 = 0.0;
pub(super) const FRESNEL_SCHLICK: f32 = 1.0;
pub(super) const FRESNEL_CONSTANT: f32 = 2.0;

/// All materials of a scene, one row each.
pub struct MaterialTable {
    rows: Rows<16>,
}

impl MaterialTable {
    pub fn new(materials: &[Material]) -> Self {
        Self { rows: Rows::new(&materials.iter().map(row).collect::<Vec<_>>()) }
    }

    /// The rows of the lanes in `valid`; other lanes hold a black diffuse material.
    #[inline(always)]
    pub fn fetch<R: Real>(&self, index: R::Bits, valid: R::Mask) -> MaterialAt<R> {
        let [kind, ax, ay, az, ex, ey, ez, bx, by, bz, alpha, separable, c, ..] = self.rows.fetch::<R>(index, valid);
        let mut material = MaterialAt::from_row([kind, ax, ay, az, bx, by, bz, alpha, separable, c]);
        material.emission = Vec3::new(ex, ey, ez);
        material
    }
}

fn row(material: &Material) -> [f32; 16] {
    let mut row = [0.0; 16];
    row[4..7].copy_from_slice(&material.emission);
    let mut glossy = |alpha: f32, masking: Masking| {
        row[10] = alpha;
        row[11] = if masking == Masking::Separable { 1.0 } else { 0.0 };
    };
    let (kind, a, b, c) = match material.bsdf {
        Bsdf::Diffuse { reflectance } => (KIND_DIFFUSE, reflectance, [0.0; 3], 0.0),
        Bsdf::Conductor { alpha, masking, fresnel } => {
            glossy(alpha, masking);
            let (a, b, c) = match fresnel {
                scene::ConductorFresnel::Exact { eta, k } => (eta, k, FRESNEL_EXACT),
                scene::ConductorFresnel::Schlick { f0 } => (f0, [0.0; 3], FRESNEL_SCHLICK),
                scene::ConductorFresnel::Constant { reflectance } => (reflectance, [0.0; 3], FRESNEL_CONSTANT),
            };
            (KIND_CONDUCTOR, a, b, c)
        }
        Bsdf::Dielectric { alpha, masking, ior } => {
            glossy(alpha, masking);
            (KIND_DIELECTRIC, [1.0; 3], [0.0; 3], ior)
        }
        Bsdf::Phong { diffuse, specular, exponent } => (KIND_PHONG, diffuse, specular, exponent),
        Bsdf::Coated { reflectance, alpha, masking, ior } => {
            glossy(alpha, masking);
            (KIND_COATED, reflectance, [0.0; 3], ior)
        }
    };
    row[0] = kind;
    row[1..4].copy_from_slice(&a);
    row[7..10].copy_from_slice(&b);
    row[12] = c;
    row
}
