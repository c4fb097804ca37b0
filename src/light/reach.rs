//! Where light samples need no help from a Lambert surface's own.
//!
//! Of all densities such a surface may scatter with, cosθ/π is at most 1/π. Far enough from every emitter its light samples are
//! denser than that in each direction that meets one: there multiple importance sampling by the larger density (Veach 1997,
//! §9.2.2, maximum heuristic) takes all light from light samples, and what they bring, radiance · f · cosθ/p, is
//! bounded by the radiance (along a [slope](super::Lights::add_slopes), at the end where they are fewest, by nine times that). Where
//! nothing but emission is left to be found, no other ray is then worth tracing.

use super::EmitterShape;
use crate::lane::{Mask, Real, Vec3};
use glam::DVec3;
use std::f64::consts::PI;

/// More emitters than this are not looked at one by one.
pub const FEW_EMITTERS: usize = 16;

/// What rounding, here and where samples are drawn, may take from a distance.
const MARGIN: f64 = 1.0 + 1e-5;

/// The balls around emitters outside of which light samples suffice.
#[derive(Clone, Debug)]
pub struct Reach {
    /// Centre and radius squared.
    balls: Vec<[f32; 4]>,
}

impl Reach {
    /// Of emitters that are each chosen with at least the probability beside them; `None` where they are many, or one may
    /// never be chosen.
    pub(super) fn of(emitters: &[(EmitterShape, f64)]) -> Option<Self> {
        if emitters.len() > FEW_EMITTERS {
            return None;
        }
        let ball = |&(shape, probability): &(EmitterShape, f64)| {
            if probability <= 0.0 {
                return None;
            }
            let (center, radius) = match shape {
                // p t²/(A cos) > 1/π beyond t² = A/πp, and no point of it is nearer than its farthest corner allows.
                EmitterShape::Triangle { p0, e1, e2 } => {
                    let [p0, e1, e2] = [p0, e1, e2].map(|v| glam::Vec3::from(v).as_dvec3());
                    let center = p0 + (e1 + e2) / 3.0;
                    let farthest = [p0, p0 + e1, p0 + e2].map(|p| p.distance(center)).into_iter().fold(0.0, f64::max);
                    let area = 0.5 * e1.cross(e2).length();
                    (center, farthest + (area / (PI * probability)).sqrt())
                }
                // p/2π(1 − cos) > 1/π where 1 − cos < p/2, and 1 − cos is at most sin² = r²/d².
                EmitterShape::Sphere { center, radius } => {
                    (glam::Vec3::from(center).as_dvec3(), f64::from(radius) * (2.0 / probability).sqrt())
                }
            };
            Some(row(center, radius * MARGIN))
        };
        emitters.iter().map(ball).collect::<Option<Vec<_>>>().map(|balls| Reach { balls })
    }

    /// Lanes whose point lies outside of all balls.
    #[inline(always)]
    pub fn beyond<R: Real>(&self, p: Vec3<R>) -> R::Mask {
        let mut beyond = R::Mask::splat(true);
        for &[x, y, z, squared] in &self.balls {
            let off = p - Vec3::splat([x, y, z]);
            beyond = beyond & off.length_squared().gt(R::splat(squared));
        }
        beyond
    }
}

fn row(center: DVec3, radius: f64) -> [f32; 4] {
    let [x, y, z] = center.as_vec3().to_array();
    // Coordinates are below 2: what single precision makes of the centre.
    [x, y, z, (radius + 4.0 * f64::from(f32::EPSILON)).powi(2) as f32]
}
