//! Lamps that lie in one another.

use super::{Material, Scene};
use glam::DVec3;
use std::collections::HashMap;

/// How far, of its distance to the edge that both have, the third vertex of one triangle may be from the plane of the other.
const FLAT: f64 = 1e-6;

/// Where more triangles emit nobody looks: lamps made for two sides by hand have few, and every load would pay for it.
const MOST: usize = 4096;

/// A vertex, as bits: the same place is the same key.
type Place = [u32; 3];

/// Two triangles that emit and cover each other, with an edge in common. Rays that run into what both cover find one of them alone,
/// whichever way it faces, while light samples find both. Where they face opposite ways, as those of a lamp that is to shine to both
/// sides, light is lost; where they face the same way, it counts twice. Quads that are cut along different diagonals are found,
/// too; lamps that overlap without an edge in common, and those among more than [`MOST`], are not. The first such pair, by the
/// numbers of its triangles.
fn lamps(scene: &Scene) -> Option<[usize; 2]> {
    let mesh = &scene.mesh;
    let emits: Vec<bool> = scene.materials.iter().map(Material::emits).collect();
    if !emits.contains(&true) {
        return None;
    }
    let emitting = || mesh.triangles.iter().zip(&mesh.material).enumerate().filter(|(_, (_, m))| emits[**m as usize]);
    if emitting().nth(MOST).is_some() {
        return None;
    }
    let mut beside: HashMap<[Place; 2], Vec<(usize, [f32; 3])>> = HashMap::new();
    for (i, (triangle, _)) in emitting() {
        // −0 is where 0 is.
        let corners = triangle.map(|corner| mesh.positions[corner as usize].map(|x| x + 0.0));
        for k in 0..3 {
            let [third, a, b] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let mut edge = [a, b].map(|p| p.map(f32::to_bits));
            edge.sort_unstable();
            let others = beside.entry(edge).or_default();
            if let Some((other, _)) = others.iter().find(|(_, other)| cover(a, b, third, *other)) {
                return Some([*other, i]);
            }
            others.push((i, third));
        }
    }
    None
}

/// Do the triangles from an edge to each of two vertices lie in one plane, to one side of the edge?
fn cover(a: [f32; 3], b: [f32; 3], one: [f32; 3], other: [f32; 3]) -> bool {
    let [a, b, one, other] = [a, b, one, other].map(|p| DVec3::from(p.map(f64::from)));
    let (along, one, other) = (b - a, one - a, other - a);
    let (n, m) = (along.cross(one), along.cross(other));
    n.dot(m) > 0.0 && n.cross(m).length() <= FLAT * n.dot(m)
}

/// Warns of them.
pub(super) fn warn(scene: &Scene) {
    if let Some([first, second]) = lamps(scene) {
        log::warn!(
            "{}: triangles {first} and {second} both emit and cover each other: a ray that meets them finds one alone, so that \
             light is lost or counts twice; remove one, or, where they shine to opposite sides, move each to its own side by a \
             hundred-thousandth of the scene's size",
            scene.name
        );
    }
}
