//! Emitting surfaces: which there are, and points on them.

use super::geometry::Geometry;
use super::vec3::V3;
use crate::stats::Rng;
use octolux::scene::{DeltaLight, Scene};

pub struct Emitters {
    /// (primitive, cumulative probability), by area times mean emission.
    table: Vec<(usize, f64)>,
    power: f64,
    /// The part of all surface area that emits.
    pub area_fraction: f64,
}

/// A point on an emitter.
pub struct LightPoint {
    pub p: V3,
    pub ng: V3,
    pub emission: V3,
    /// Per unit area.
    pub pdf_area: f64,
}

impl Emitters {
    pub fn new(scene: &Scene, geometry: &Geometry) -> Self {
        let (mut table, mut power, mut emitting, mut all) = (Vec::new(), 0.0, 0.0, 0.0);
        for prim in 0..geometry.len() {
            let area = geometry.area(prim);
            let strength = mean(emission(scene, geometry.material(prim)));
            all += area;
            if area * strength > 0.0 {
                power += area * strength;
                emitting += area;
                table.push((prim, power));
            }
        }
        table.iter_mut().for_each(|e| e.1 /= power);
        Emitters { table, power, area_fraction: if all > 0.0 { emitting / all } else { 0.0 } }
    }

    /// A point chosen by area and mean emission; None where nothing emits.
    pub fn sample(&self, scene: &Scene, geometry: &Geometry, rng: &mut Rng) -> Option<LightPoint> {
        let (choice, u) = (rng.f64(), [rng.f64(), rng.f64()]);
        let i = self.table.partition_point(|e| e.1 <= choice).min(self.table.len().checked_sub(1)?);
        let prim = self.table[i].0;
        let emission = emission(scene, geometry.material(prim));
        let (p, ng) = geometry.point_on(prim, u);
        Some(LightPoint { p, ng, emission, pdf_area: mean(emission) / self.power })
    }
}

pub fn emission(scene: &Scene, material: usize) -> V3 {
    V3::of(scene.materials[material].emission)
}

fn mean(v: V3) -> f64 {
    v.0.iter().sum::<f64>() / 3.0
}

/// What a light without extent sends through `p`: where it comes from, how far that is (None: infinitely), and how much
/// arrives per unit of area across it.
pub fn delta_light(light: &DeltaLight, p: V3) -> (V3, Option<f64>, V3) {
    let from = |position: [f32; 3], intensity: [f32; 3]| {
        let to = V3::of(position) - p;
        let d = to.length();
        (to * (1.0 / d), Some(d), V3::of(intensity) * (1.0 / (d * d)))
    };
    match *light {
        DeltaLight::Point { position, intensity } => from(position, intensity),
        DeltaLight::Directional { direction, irradiance } => (-V3::of(direction), None, V3::of(irradiance)),
        DeltaLight::Spot { position, direction, intensity, angle } => {
            let (wi, d, arriving) = from(position, intensity);
            let off = wi.cross(V3::of(direction)).length().atan2(-wi.dot(V3::of(direction)));
            (wi, d, if off.to_degrees() <= angle.into() { arriving } else { V3::default() })
        }
    }
}
