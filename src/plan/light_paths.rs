//! Does a scene need paths from the lights?

use crate::bsdf::ALPHA_MIN;
use crate::scene::{Bsdf, IntegratorKind, LightPaths, Material, NO_NORMAL, Scene};
use std::collections::BTreeSet;

/// With the reason. `lamps` primitives emit; `used` are the materials that some primitive wears.
pub(super) fn decide(scene: &Scene, used: &BTreeSet<usize>, lamps: usize) -> (bool, String) {
    let said = |why: &str| (false, why.to_string());
    if scene.integrator.light_paths == LightPaths::Off {
        return said("asked to be off");
    }
    if scene.integrator.kind != IntegratorKind::Path {
        return said("only beside the integrator path");
    }
    if scene.integrator.max_bounces == 0 {
        return said("not where nothing scatters: the camera sees emitters by paths of its own");
    }
    if lamps == 0 {
        return said("they start at primitives that emit, of which there are none");
    }
    let smooth = scene.mesh.normal_indices.iter().any(|n| n[0] != NO_NORMAL);
    if smooth || used.iter().any(|&m| scene.materials[m].maps.normal.is_some()) {
        return said("not with shading normals, which turn towards the viewer");
    }
    if scene.integrator.light_paths == LightPaths::On {
        return (true, "asked to be on".to_string());
    }
    let focusing = used.iter().filter(|&&m| focuses(&scene.materials[m])).count();
    (focusing > 0, format!("{focusing} of {} used materials focus light", used.len()))
}

/// Does it throw light onto others in a way that those find by chance alone?
fn focuses(material: &Material) -> bool {
    match material.bsdf {
        Bsdf::Dielectric { .. } => true,
        Bsdf::Conductor { alpha, .. } => alpha < ALPHA_MIN,
        _ => false,
    }
}
