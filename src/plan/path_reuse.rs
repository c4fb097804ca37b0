//! Can the pixels of a scene share paths?

use crate::scene::{IntegratorKind, Material, PathReuse, Scene};

/// With the reason. `light_paths` are traced; `used` are the materials that some primitive wears.
pub(super) fn decide<'a>(
    scene: &Scene,
    mut used: impl Iterator<Item = &'a Material>,
    light_paths: bool,
) -> (bool, String) {
    let integrator = &scene.integrator;
    let said = |why: &str| (false, why.to_string());
    if integrator.path_reuse == PathReuse::Off {
        return said("asked to be off");
    }
    if integrator.kind != IntegratorKind::Path || integrator.max_bounces < 2 {
        return said("only beside the integrator path, of two bounces or more");
    }
    if light_paths {
        return said("not beside paths from the lights, whose weights know of one camera path alone");
    }
    if used.any(Material::is_cut_out) {
        return said("not with surfaces that rays may pass");
    }
    if integrator.roulette.after < 2 {
        return said("not where roulette may end a path before its second vertex");
    }
    (true, format!("{} bounces", integrator.max_bounces))
}
