//! Lamps that lie in one another.

use super::{Material, Scene};
use std::collections::HashMap;

/// Two triangles of one place, both of which emit: rays that run into that place find one of them alone, whichever way it
/// faces, while light samples find both. Where they face opposite ways, as those of a lamp that is to shine to both sides, light is
/// lost; where they face the same way, it counts twice. The first such pair, by the numbers of its triangles.
pub(super) fn lamps(scene: &Scene) -> Option<[usize; 2]> {
    let mesh = &scene.mesh;
    let emits: Vec<bool> = scene.materials.iter().map(Material::emits).collect();
    if !emits.contains(&true) {
        return None;
    }
    let mut seen = HashMap::new();
    for (i, (corners, &material)) in mesh.triangles.iter().zip(&mesh.material).enumerate() {
        if !emits[material as usize] {
            continue;
        }
        // −0 is where 0 is.
        let mut place = corners.map(|corner| mesh.positions[corner as usize].map(|x| (x + 0.0).to_bits()));
        place.sort_unstable();
        if let Some(first) = seen.insert(place, i) {
            return Some([first, i]);
        }
    }
    None
}

/// Warns of them.
pub(super) fn warn(scene: &Scene) {
    if let Some([first, second]) = lamps(scene) {
        log::warn!(
            "{}: triangles {first} and {second} both emit and lie in one place: a ray that meets them finds one alone, so that \
             light is lost or counts twice; remove one, or move it by a hundred-thousandth of the scene's size",
            scene.name
        );
    }
}
