//! A recorded path as a person reads it: vertices, what was met there, and what each added.

use super::info::first_word;
use crate::geometry::MISS;
use crate::kernel::{Record, Stage};
use crate::scene::Scene;
use std::fmt::Write as _;

/// The records of one vertex.
struct Vertex<'a>(&'a [Record]);

impl Vertex<'_> {
    /// The values of a stage, in the order they were recorded; empty where it was not reached.
    fn values(&self, stage: Stage) -> Vec<f32> {
        self.0.iter().filter(|record| record.stage == stage).map(|record| f32::from_bits(record.bits)).collect()
    }
    fn one(&self, stage: Stage) -> Option<f32> {
        self.values(stage).first().copied()
    }
    fn rgb(&self, stage: Stage) -> Option<[f32; 3]> {
        self.values(stage).first_chunk().copied()
    }
    /// Is what it met for all pixels that share the path, and not for its own alone?
    fn is_shared(&self, stage: Stage) -> bool {
        self.0.iter().any(|record| record.stage == stage && record.for_all)
    }
    fn primitive(&self) -> Option<u32> {
        self.0.iter().find(|record| record.stage == Stage::HitPrimitive).map(|record| record.bits)
    }
}

/// The whole path. `unit` is one length unit of the kernel in the scene's.
pub fn describe(records: &[Record], scene: &Scene, unit: f32) -> String {
    let mut text = String::new();
    let mut beta = [1.0f32; 3];
    let mut total = [0.0f32; 3];
    let of_the_sample = records.iter().position(|r| matches!(r.stage, Stage::Shared | Stage::Radiance));
    let (of_vertices, of_the_sample) = records.split_at(of_the_sample.unwrap_or(records.len()));
    for records in of_vertices.chunk_by(|a, b| a.bounce == b.bounce) {
        let vertex = Vertex(records);
        // Writing into a String cannot fail.
        let _ = writeln!(text, "vertex {}  {}", records[0].bounce, place(&vertex, scene, unit));
        let before = vertex.0.iter().position(|r| r.stage == Stage::LightContribution);
        if let Some(light) = vertex.rgb(Stage::Emission) {
            let gain = gain(&mut total, light, vertex.is_shared(Stage::Emission));
            let _ = writeln!(text, "  emission   {gain}");
        }
        if let Some(pdf) = vertex.one(Stage::LightPdf) {
            let _ = write!(text, "  light      pdf {pdf:.6}");
            let _ = match (before.and(vertex.rgb(Stage::LightContribution)), vertex.one(Stage::Shadow)) {
                (Some(light), Some(0.0)) => {
                    let gain = gain(&mut total, light, vertex.is_shared(Stage::LightContribution));
                    writeln!(text, ", visible, {gain}")
                }
                (Some(light), Some(_)) => writeln!(text, ", in shadow, would have added {}", colour(light)),
                _ => writeln!(text, ", carries nothing here"),
            };
        }
        if let Some(weight) = vertex.rgb(Stage::BsdfWeight) {
            beta = std::array::from_fn(|c| beta[c] * weight[c]);
            let pdf = vertex.one(Stage::BsdfPdf).map_or(String::new(), |pdf| format!("pdf {pdf:.6}, "));
            let _ = writeln!(text, "  scattering {pdf}f·cos/pdf {}, throughput {}", colour(weight), colour(beta));
        }
        if let Some(survival) = vertex.one(Stage::Roulette) {
            beta = beta.map(|b| b / survival);
            let _ = writeln!(text, "  roulette   survives with probability {survival:.6}");
        }
    }
    let sample = Vertex(of_the_sample);
    if let Some(shared) = sample.rgb(Stage::Shared) {
        add(&mut total, shared);
        let _ = writeln!(text, "shared     adds {}: what the paths of its block found", colour(shared));
    }
    let _ = match sample.rgb(Stage::Radiance) {
        Some(radiance) => writeln!(text, "radiance   {} (sum of what was added: {})", colour(radiance), colour(total)),
        None => writeln!(text, "this integrator follows no light"),
    };
    text
}

/// What was hit, and where.
fn place(vertex: &Vertex, scene: &Scene, unit: f32) -> String {
    let t = vertex.one(Stage::HitT).map_or(0.0, |t| t * unit);
    let Some(primitive) = vertex.primitive() else { return "nothing recorded".to_string() };
    if primitive == MISS {
        return "leaves the scene".to_string();
    }
    let worn = |material: u32| {
        let material = &scene.materials[material as usize];
        format!("`{}`, {}", material.name, first_word(&format!("{:?}", material.bsdf)))
    };
    let index = primitive as usize;
    let triangles = scene.mesh.triangles.len();
    if let Some(sphere) = index.checked_sub(triangles).and_then(|i| scene.spheres.get(i)) {
        return format!("sphere {} ({}) at distance {t}", index - triangles, worn(sphere.material));
    }
    let Some(corners) = scene.mesh.triangles.get(index) else { return format!("primitive {index}") };
    let [a, b, c] = corners.map(|corner| scene.mesh.positions[corner as usize]);
    let (u, v) = (vertex.one(Stage::HitU).unwrap_or(0.0), vertex.one(Stage::HitV).unwrap_or(0.0));
    let point: [f32; 3] = std::array::from_fn(|i| a[i] + u * (b[i] - a[i]) + v * (c[i] - a[i]));
    let material = worn(scene.mesh.material[index]);
    format!("triangle {index} ({material}) at ({}, {}, {}), distance {t}", point[0], point[1], point[2])
}

fn add(total: &mut [f32; 3], light: [f32; 3]) {
    total.iter_mut().zip(light).for_each(|(sum, value)| *sum += value);
}

/// Says what becomes of light, and adds it to the sample's if it is its own.
fn gain(total: &mut [f32; 3], light: [f32; 3], shared: bool) -> String {
    if shared {
        return format!("finds for all pixels of the block {}", colour(light));
    }
    add(total, light);
    format!("adds {}", colour(light))
}

fn colour([r, g, b]: [f32; 3]) -> String {
    format!("({r} {g} {b})")
}
