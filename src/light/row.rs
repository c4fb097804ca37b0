//! What is kept of an emitting primitive for its samples.

use super::emitter::{cross, length};
use super::sample::LightPoint;
use super::triangle::Triangle;
use super::{Emitter, EmitterShape, sphere, triangle};
use crate::lane::{Real, Vec3};

/// What a lane needs to sample one emitter: one cache line.
///
/// Triangle: p0, e1, e2, unit front normal, radiance, choice probability / area.
/// Sphere: centre, radius, –, radiance, choice probability.
pub(super) type Row = [f32; 16];

pub(super) const P0: usize = 0;
pub(super) const E1: usize = 3;
pub(super) const E2: usize = 6;
pub(super) const NG: usize = 9;
pub(super) const CENTER: usize = 0;
pub(super) const RADIUS: usize = 3;
pub(super) const RADIANCE: usize = 12;
pub(super) const PDF_ROW: usize = 15;

/// The rows that the lanes look at, a register a field.
pub(super) struct LaneRows<R>(pub [R; 16]);

impl<R: Real> LaneRows<R> {
    #[inline(always)]
    fn field(&self, k: usize) -> R {
        self.0[k]
    }

    #[inline(always)]
    pub fn vector(&self, k: usize) -> Vec3<R> {
        Vec3::new(self.field(k), self.field(k + 1), self.field(k + 2))
    }

    #[inline(always)]
    pub fn sample_triangle(&self, origin: Vec3<R>, weights: [R; 2]) -> LightPoint<R> {
        let light = Triangle { p0: self.vector(P0), e1: self.vector(E1), e2: self.vector(E2), ng: self.vector(NG) };
        triangle::at(&light, self.field(PDF_ROW), origin, weights)
    }

    #[inline(always)]
    pub fn sample_sphere(&self, origin: Vec3<R>, u: [R; 2]) -> LightPoint<R> {
        sphere::sample(self.vector(CENTER), self.field(RADIUS), self.field(PDF_ROW), origin, u)
    }
}

/// `probability` is that of the choice.
pub(super) fn row(emitter: &Emitter, probability: f64) -> Row {
    let mut row = [0.0; 16];
    match emitter.shape {
        EmitterShape::Triangle { p0, e1, e2 } => {
            row[P0..P0 + 3].copy_from_slice(&p0);
            row[E1..E1 + 3].copy_from_slice(&e1);
            row[E2..E2 + 3].copy_from_slice(&e2);
            let normal = cross(e1, e2);
            let twice_area = length(normal);
            for k in 0..3 {
                row[NG + k] = (normal[k] / twice_area) as f32;
            }
            row[PDF_ROW] = (probability / (0.5 * twice_area)) as f32;
        }
        EmitterShape::Sphere { center, radius } => {
            row[CENTER..CENTER + 3].copy_from_slice(&center);
            row[RADIUS] = radius;
            row[PDF_ROW] = probability as f32;
        }
    }
    row[RADIANCE..RADIANCE + 3].copy_from_slice(&emitter.radiance);
    row
}
