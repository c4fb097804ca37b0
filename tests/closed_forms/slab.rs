//! Views through glass, and the area of a silhouette.

use super::TESTS;
use crate::renders::{self, Set, assert_image_mean};
use crate::stats;
use octolux::scene::{Bsdf, IntegratorKind, Masking};

/// A plane-parallel slab before a lamp: all internal reflections together let (1 − R)/(1 + R) through.
#[test]
fn slab_of_glass() {
    for (id, degrees) in [("F.slab_T_0deg", 0f64), ("F.slab_T_60deg", 60.0)] {
        let Some(case) = stats::oracle(id) else { return };
        let (s, c) = degrees.to_radians().sin_cos();
        let mut set = Set::new([10.0 * s, 0.0, 1.0 + 10.0 * c], [0.0, 0.0, 1.0], 0.01, 32).bounces(60);
        let glass = set.material(Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior: 1.5 }, [0.0; 3]);
        let lamp = set.grey(0.0, 1.0);
        set.block(glass, [-20.0, -20.0, 0.0], [20.0, 20.0, 1.0]);
        set.quad(lamp, [[-40.0, -40.0, -0.5], [40.0, -40.0, -0.5], [40.0, 40.0, -0.5], [-40.0, 40.0, -0.5]]);
        let film = renders::film(&renders::world(&set.finish(), 15), 1024);
        // The view is a cone of .01°: T changes by less than 1e-4 across it, and evenly.
        assert_image_mean(id, &film, [case.value; 3], 1e-6, TESTS);
    }
}

/// The silhouette of a sphere off the axis is an ellipse of known area on the image plane.
#[test]
fn silhouette_of_a_sphere() {
    let Some(case) = stats::oracle("L.sphere_silhouette_phi30") else { return };
    // The film reaches ±2 at distance 1: 16 of area.
    let vfov = 2.0 * 2f64.atan().to_degrees();
    let mut set = Set::new([0.0; 3], [0.0, 0.0, -1.0], vfov, 64).integrator(IntegratorKind::Hit);
    let any = set.grey(0.5, 0.0);
    let (s, c) = 30f64.to_radians().sin_cos();
    set.sphere(any, [3.0 * s, 0.0, -3.0 * c], 1.0);
    let film = renders::film(&renders::world(&set.finish(), 16), 512);
    // vfov is an f32 of degrees: 1e-5 of the area.
    let expected = case.value / 16.0;
    assert_image_mean("silhouette", &film, [expected; 3], 1e-5 * expected, TESTS);
}
