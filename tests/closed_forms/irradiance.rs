//! Direct light of polygons and spheres on a white Lambert receiver, against `oracles.json`: E = π L of what the
//! camera sees.

use super::TESTS;
use crate::renders::{self, Set, assert_image_mean};
use crate::stats;

type Point = [f64; 3];

const SIDE: u32 = 8;
const SAMPLES: u64 = 2048;

/// What the receiver at `at` (normal +z) reflects towards a camera that comes in so low that no light stands between,
/// of irradiance 1/π for each unit it shows. `light` puts emitters of the given material into the scene.
fn receiver(at: Point, light: impl FnOnce(&mut Set, u32)) -> Set {
    // 1e-4°: the film covers less than 1e-4 of the ground, about a point.
    let mut set = Set::new([at[0] - 2.0, at[1], at[2] + 0.1], at, 1e-4, SIDE).bounces(1);
    let (ground, lamp) = (set.grey(1.0, 0.0), set.grey(0.0, 1.0));
    let corner = |x: f64, y: f64| [at[0] + x, at[1] + y, at[2]];
    set.triangle(ground, [corner(-0.01, -0.01), corner(0.02, -0.01), corner(-0.01, 0.02)]);
    light(&mut set, lamp);
    set
}

/// `tolerance` is relative, for geometry that f32 cannot hold.
fn check(id: &str, set: Set, scale: f64, tolerance: f64) {
    let Some(case) = stats::oracle(id) else { return };
    let expected = case.value * scale;
    let film = renders::film(&renders::world(&set.finish(), 14), SAMPLES);
    assert_image_mean(id, &film, [expected; 3], expected * tolerance, TESTS);
}

/// 1/π turns irradiance into what a white receiver shows.
const WHITE: f64 = std::f64::consts::FRAC_1_PI;
/// Points within 1e-4 of the origin, and their rounding, when the light is at distance 1 or so.
const NEAR: f64 = 1e-5;

/// A polygon of one triangle or quad, turned to face the receiver at the origin.
fn facing<const N: usize>(mut corners: [Point; N]) -> [Point; N] {
    let edge = |i: usize| -> Point { std::array::from_fn(|k| corners[i][k] - corners[0][k]) };
    let (a, b, p) = (edge(1), edge(2), corners[0]);
    let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    if (0..3).map(|k| normal[k] * p[k]).sum::<f64>() > 0.0 {
        corners.reverse();
    }
    corners
}

fn square(corners: [Point; 4]) -> Set {
    receiver([0.0; 3], |set, lamp| set.quad(lamp, facing(corners)))
}

#[test]
fn squares_overhead() {
    let heights = [("0.1", 0.1), ("0.5", 0.5), ("1", 1.0), ("2", 2.0), ("10", 10.0), ("1e3", 1e3)];
    for (name, h) in heights {
        let set = square([[-0.5, -0.5, h], [0.5, -0.5, h], [0.5, 0.5, h], [-0.5, 0.5, h]]);
        check(&format!("A.sq_par_h{name}"), set, WHITE, NEAR / f64::min(h, 1.0));
    }
    let set = square([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]);
    check("A.sq_corner_h1", set, WHITE, 1e-4);
    let set = square([[-5e-4, -5e-4, 1.0], [5e-4, -5e-4, 1.0], [5e-4, 5e-4, 1.0], [-5e-4, 5e-4, 1.0]]);
    // Its corners are f32 numbers near 5e-4 and the receiver's scale is 1: sides within 1e-7 of 1e-3.
    check("A.sq_omega1e-6", set, WHITE, 2e-4);
    let set = receiver([0.0; 3], |set, lamp| {
        set.triangle(lamp, facing([[-0.5, 0.0, 1.0], [0.5, 0.0, 1.0], [0.0, 1e-6, 1.0]]));
    });
    check("A.sliver_1e6", set, WHITE, NEAR);
}

#[test]
fn squares_at_the_horizon() {
    let upright = |lo: f64, hi: f64| square([[1.0, -0.5, lo], [1.0, 0.5, lo], [1.0, 0.5, hi], [1.0, -0.5, hi]]);
    check("A.sq_perp_full", upright(0.0, 1.0), WHITE, NEAR);
    check("A.sq_perp_above", upright(1.0, 2.0), WHITE, NEAR);
    check("A.sq_perp_halfbelow", upright(-0.5, 0.5), WHITE, NEAR);
    // 1e-3 high: the shadow ray starts some 1e-6 above the ground.
    check("A.sq_perp_grazing1e-3", upright(0.0, 1e-3), WHITE, 4e-3);
    let tilt = 89.9f64.to_radians();
    let (s, c) = tilt.sin_cos();
    let corner = |a: f64, b: f64| [5.0 * s + a * c, b, 5.0 * c - a * s];
    let set = square([corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)]);
    check("A.sq_facing_89.9deg", set, WHITE, 1e-4);
}

/// Triangles whose outgoing radiance at ρ = .5 is given, in a world with y up.
#[test]
fn triangles() {
    let cases = [
        ("2", [[0.461963, 0.397843, 0.412747], [-0.0381582, 0.851323, -0.156872], [0.195443, 0.891957, -0.260672]]),
        ("3", [[0.100871, 0.289075, -0.422609], [-0.308386, 0.629587, 0.423966], [-0.373132, 0.237287, 0.351592]]),
        ("4", [[-0.17575, 0.639397, 0.151268], [0.318604, 0.732996, 0.459771], [0.139095, 0.294498, 0.478556]]),
        ("5", [[-0.17487, 0.447916, 0.367201], [-0.405259, 0.249607, -0.354079], [0.356029, 0.0918984, -0.132271]]),
    ];
    for (name, corners) in cases {
        let z_up = corners.map(|[x, y, z]| [z, x, y]);
        let set = receiver([0.0; 3], |set, lamp| set.triangle(lamp, facing(z_up)));
        check(&format!("A.nori_polylum{name}"), set, 2.0, 10.0 * NEAR);
    }
}

/// The sphere's centre is at distance 1, at an angle from the receiver's normal, away from the camera.
#[test]
fn spheres() {
    let cases = [
        ("B.sphere_r/d0.5_th75", 0.5, 75.0),
        ("B.sphere_r/d0.5_th90", 0.5, 90.0),
        ("B.sphere_r/d0.5_th100", 0.5, 100.0),
        ("B.sphere_r/d0.9_th75", 0.9, 75.0),
        ("B.sphere_r/d0.9_th90", 0.9, 90.0),
        ("B.sphere_r/d0.9_th100", 0.9, 100.0),
        ("B.sphere_r/d0.01_th0", 0.01, 0.0),
        ("B.sphere_r/d0.01_th75", 0.01, 75.0),
        ("B.sphere_r/d0.01_th90", 0.01, 90.0),
        ("B.sun", 0.2665f64.to_radians().sin(), 0.0),
    ];
    for (id, radius, degrees) in cases {
        let (s, c) = f64::to_radians(degrees).sin_cos();
        let set = receiver([0.0; 3], |set, lamp| set.sphere(lamp, [s, 0.0, c], radius));
        // Half a small sphere below the horizon moves with the height of the point: 1e-6 of .01.
        check(id, set, WHITE, if radius < 0.1 { 4e-4 } else { 10.0 * NEAR });
    }
}

/// A square lamp half hidden by an opaque half-plane.
#[test]
fn penumbra() {
    for x in ["-1.5", "-0.5", "0.25", "0.5", "1.5"] {
        let at = [x.parse().expect("a number"), 0.0, 0.0];
        let set = receiver(at, |set, lamp| {
            let z = 2.0;
            set.quad(lamp, [[-1.0, -1.0, z], [-1.0, 1.0, z], [1.0, 1.0, z], [1.0, -1.0, z]]);
            let black = set.grey(0.0, 0.0);
            let far = 1000.0;
            set.quad(black, [[-far, -far, 1.0], [0.0, -far, 1.0], [0.0, far, 1.0], [-far, far, 1.0]]);
        });
        // The half-plane's size makes the unit of rounding 1000 · 2⁻²⁴; its edge and the receiver are that sharp.
        check(&format!("A.penumbra_x{x}"), set, WHITE, 1e-3);
    }
}
