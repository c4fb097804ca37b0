//! Primitives that emit.

use std::f64::consts::PI;

/// A primitive that emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Triangles in file order, then spheres.
    pub primitive: u32,
    /// In the kernel's unit.
    pub shape: EmitterShape,
    /// Linear RGB, finite and ≥ 0.
    pub radiance: [f32; 3],
}

/// Where an emitter is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // fields: as the variant says
pub enum EmitterShape {
    /// Emits from its counter-clockwise side, where `e1` × `e2` points.
    Triangle { p0: [f32; 3], e1: [f32; 3], e2: [f32; 3] },
    /// Emits outwards.
    Sphere { center: [f32; 3], radius: f32 },
}

impl Emitter {
    /// Area in square units of the scene, in f64.
    pub fn area(&self) -> f64 {
        match self.shape {
            EmitterShape::Triangle { e1, e2, .. } => 0.5 * length(cross(e1, e2)),
            EmitterShape::Sphere { radius, .. } => 4.0 * PI * f64::from(radius) * f64::from(radius),
        }
    }

    /// π · area · radiance, the mean over the channels: what the light is chosen by. The mean, not luminance, because
    /// errors are measured per channel: a blue lamp deserves its samples.
    pub fn power(&self) -> f64 {
        let mean = self.radiance.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
        PI * self.area() * mean
    }

    pub(super) fn is_sphere(&self) -> bool {
        matches!(self.shape, EmitterShape::Sphere { .. })
    }
}

pub(super) fn cross(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    let ([a0, a1, a2], [b0, b1, b2]) = (a.map(f64::from), b.map(f64::from));
    [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]
}

pub(super) fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
