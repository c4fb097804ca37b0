//! Glossy lobes: point sets about the mirror direction, one family for each lobe of the scene.
//!
//! p is the lobe itself for Phong, cosⁿα, and g = L·cosθ·const is as smooth as the light. Of a GGX metal p has the shape
//! of the lobe seen from above; what its f·cosθ has besides (masking, Fresnel, the narrowing at grazing angles) stays in g,
//! so that nothing is left out by the choice of p. A rough coat has a metal's; its base is what the coat alone leaves.

use super::Vertex;
use crate::estimate::bmc::Measure;
use crate::kernel::material::{AllModels, MaterialAt};
use crate::lane::{Mask, Real, Vec3, math};
use crate::plan::{Plan, Shading};
use crate::sampling::Frame;
use crate::sampling::dimensions::ROTATION;
use crate::scene::{Bsdf, Material};

/// The largest exponent of [`Measure::PowerCosine`], and the largest sharpness of the lobes on the whole sphere: narrower
/// ones are sampled by these, a little too broadly.
const MOST_COSINE: f64 = 256.0;
const MOST_SHARPNESS: f64 = 1e4;

/// What a hit's material has besides Lambert.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Glossy {
    /// A Phong lobe of this exponent.
    Phong(f32),
    /// A rough metal's or coat's.
    Facets(f32),
}

impl Glossy {
    /// p about the mirror direction.
    pub fn measure(self) -> Measure {
        match self {
            Glossy::Phong(n) if f64::from(n) <= MOST_COSINE => Measure::PowerCosine { exponent: f64::from(n) },
            // cosⁿα ≤ exp(n(cosα − 1)), and alike where it counts.
            Glossy::Phong(n) => Measure::Lobe { sharpness: f64::from(n).min(MOST_SHARPNESS), amplitude: 1.0 },
            Glossy::Facets(alpha) => {
                Measure::Microfacet { kappa: (0.5 / f64::from(alpha).powi(2)).min(MOST_SHARPNESS) }
            }
        }
    }

    /// How unlike they are, as p of one serves the other: in octaves of sharpness.
    fn distance(self, other: Self) -> f32 {
        match (self, other) {
            (Glossy::Phong(a), Glossy::Phong(b)) => ((1.0 + a) / (1.0 + b)).log2().abs(),
            (Glossy::Facets(a), Glossy::Facets(b)) => 2.0 * (a / b).log2().abs(),
            _ => f32::INFINITY,
        }
    }

    /// The place of the lobe nearest to this one.
    pub fn nearest(self, lobes: &[Self]) -> Option<usize> {
        let nearer = |a: &(usize, f32), b: &(usize, f32)| a.1.total_cmp(&b.1);
        let known = lobes.iter().map(|&lobe| self.distance(lobe)).enumerate();
        known.min_by(nearer).filter(|(_, distance)| distance.is_finite()).map(|(i, _)| i)
    }
}

/// The lobes that get sets of their own: those of the materials, and where an image changes roughness two a factor of
/// ten, from a mirror's to 1.
pub(super) fn lobes_of(materials: &[Material]) -> Vec<Glossy> {
    const STEPS: [f32; 7] = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0];
    let mut lobes: Vec<Glossy> = Vec::new();
    for material in materials {
        let facets = matches!(material.bsdf, Bsdf::Conductor { .. } | Bsdf::Coated { .. });
        let facets = facets || material.maps.metallic.is_some();
        let mapped = material.maps.roughness.is_some() || material.maps.metallic.is_some();
        let own = match material.bsdf {
            Bsdf::Phong { exponent, .. } => Some(Glossy::Phong(exponent)),
            Bsdf::Conductor { alpha, .. } | Bsdf::Coated { alpha, .. } if alpha >= crate::bsdf::ALPHA_MIN => {
                Some(Glossy::Facets(alpha))
            }
            _ => None,
        };
        let steps = STEPS.map(Glossy::Facets).into_iter().filter(|_| facets && mapped);
        for lobe in own.into_iter().chain(steps) {
            if !lobes.contains(&lobe) {
                lobes.push(lobe);
            }
        }
    }
    lobes
}

/// A hit's material as it is gathered: a base by the cosine and a lobe about the mirror direction.
pub(super) struct Parts<R: Real> {
    pub base: Option<MaterialAt<R>>,
    pub lobe: Option<(MaterialAt<R>, Glossy)>,
    /// The base scatters what the lobe by itself does not: it is that of a coat, which cannot be taken off.
    pub below: bool,
}

impl<R: Real> Parts<R> {
    /// Of a material that is the same in every lane.
    pub fn of(material: &MaterialAt<R>, plan: &Plan) -> Self {
        let all = || material.in_all_lanes(0);
        match material.glossy(plan) {
            None => Parts { base: Some(all()), lobe: None, below: false },
            Some(lobe @ Glossy::Facets(_)) if material.is_coated().any() => {
                Parts { base: Some(all()), lobe: Some((material.coat_alone(), lobe)), below: true }
            }
            Some(lobe @ Glossy::Facets(_)) => Parts { base: None, lobe: Some((all(), lobe)), below: false },
            Some(lobe @ Glossy::Phong(_)) => {
                let [base, specular] = material.split_phong();
                let reflects = |m: &MaterialAt<R>| m.albedo().max_component().gt(R::zero()).any();
                let lobe = Some(specular).filter(reflects).map(|m| (m, lobe));
                Parts { base: Some(base).filter(reflects), lobe, below: false }
            }
        }
    }
}

impl<R: Real> MaterialAt<R> {
    /// The lobe of lane 0; `None` where it is a delta or there is none.
    fn glossy(&self, plan: &Plan) -> Option<Glossy> {
        if plan.shading == Shading::Lambert || self.is_delta::<AllModels>().any() {
            return None;
        }
        if self.is_phong().any() {
            return Some(Glossy::Phong(self.phong_exponent().lane(0)));
        }
        let facets = self.is_conductor() | (self.is_coated() & self.gathers());
        facets.any().then(|| Glossy::Facets(self.alpha().lane(0)))
    }
}

/// About the mirror direction, in the local frame; turned about it as the sample's number says.
pub(super) fn mirror_frame<R: Real>(vertex: &Vertex<R>, rotate: bool) -> Frame<R> {
    let Vec3 { x, y, z } = vertex.wo;
    let frame = Frame::from_normal(Vec3::new(-x, -y, z));
    if !rotate {
        return frame;
    }
    let (sin, cos) = math::sincos_2pi(R::splat(vertex.u[ROTATION]));
    let Frame { tangent, bitangent, normal } = frame;
    Frame { tangent: tangent.mul_add(cos, bitangent * sin), bitangent: bitangent.mul_add(cos, tangent * -sin), normal }
}
