//! Direct light in the oracle's renderer against Lambert's formula and its kin.

use super::scenes::LAMBERT;
use super::*;
use crate::stats::{oracle, oracles_in};
use octolux::scene::{Environment, EnvironmentImage, Scene};
use std::f64::consts::PI;

const RHO: f64 = 0.5;

/// Renders light arriving at the origin on a small Lambert patch whose normal is +z, seen from a thousandth of a degree:
/// radiance · π/ρ is the irradiance. The light must not cover the camera's view from (0.3, 0.2, 0.5)/100.
fn assert_irradiance(name: &str, scene: SceneBuilder, expected: f64, abs_tol: f64, tests: usize) {
    let r = 1e-3;
    let scene = scene
        .quad([[-r, -r, 0.0], [r, -r, 0.0], [r, r, 0.0], [-r, r, 0.0]], LAMBERT(RHO as f32), 0.0)
        .camera([3e-3, 2e-3, 5e-3], [0.0; 3], 1e-3)
        .build();
    let radiance = |e: f64| e * RHO / PI;
    // The scene's coordinates are f32: a few 1e-7 of the light's position, hence of E.
    let tolerance = radiance(abs_tol) + 1e-6 * radiance(expected);
    let image = Renderer::new(&scene).direct(Direct::Area).render(Region::whole(&scene), 40_000, 7);
    image.assert_mean(name, [radiance(expected); 3], tolerance, tests);
}

/// A rectangle by centre and half edges; its front is towards `half_x` × `half_y`.
fn rectangle(center: [f32; 3], half_x: [f32; 3], half_y: [f32; 3]) -> SceneBuilder {
    let corner = |s: f32, t: f32| std::array::from_fn(|i| center[i] + s * half_x[i] + t * half_y[i]);
    SceneBuilder::new().quad(
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        LAMBERT(0.0),
        1.0,
    )
}

/// Unit square, parallel, facing down.
fn ceiling(x: f32, y: f32, h: f32, half: f32) -> SceneBuilder {
    rectangle([x, y, h], [0.0, half, 0.0], [half, 0.0, 0.0])
}

/// Unit square at x = 1 facing −x, from z0 to z1.
fn wall(z0: f32, z1: f32) -> SceneBuilder {
    rectangle([1.0, 0.0, 0.5 * (z0 + z1)], [0.0, 0.0, 0.5 * (z1 - z0)], [0.0, 0.5, 0.0])
}

#[test]
fn polygon_lights_match_lamberts_formula() {
    let cases = [
        ("A.sq_par_h0.1", ceiling(0.0, 0.0, 0.1, 0.5)),
        ("A.sq_par_h0.5", ceiling(0.0, 0.0, 0.5, 0.5)),
        ("A.sq_par_h1", ceiling(0.0, 0.0, 1.0, 0.5)),
        ("A.sq_par_h10", ceiling(0.0, 0.0, 10.0, 0.5)),
        ("A.sq_par_h1e3", ceiling(0.0, 0.0, 1e3, 0.5)),
        ("A.sq_corner_h1", ceiling(0.5, 0.5, 1.0, 0.5)),
        ("A.sq_omega1e-6", ceiling(0.0, 0.0, 1.0, 5e-4)),
        ("A.sq_perp_full", wall(0.0, 1.0)),
        ("A.sq_perp_grazing1e-3", wall(0.0, 1e-3)),
        ("A.sq_perp_halfbelow", wall(-0.5, 0.5)),
        ("A.sq_perp_above", wall(1.0, 2.0)),
    ];
    let tests = 3 * cases.len();
    for (id, scene) in cases {
        let Some(case) = oracle(id) else { return };
        assert_irradiance(id, scene, case.value, 0.0, tests);
    }
}

#[test]
fn lights_shine_from_their_front_only() {
    let away = rectangle([0.0, 0.0, 1.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]);
    assert_irradiance("from behind", away, 0.0, 0.0, 3);
}

#[test]
fn triangle_lights_match_nori() {
    let cases = oracles_in("polygon light (Nori ttest geometry)");
    for case in &cases {
        let digits = |c: char| c.is_ascii_digit() || c == '.' || c == '-' || c == 'e';
        let list = &case.setup[case.setup.find('[').expect("[") + 1..case.setup.find(']').expect("]")];
        let numbers: Vec<f32> = list.split(|c| !digits(c)).filter_map(|s| s.parse().ok()).collect();
        // From y up to z up by a rotation: (x, y, z) → (z, x, y).
        let p: [[f32; 3]; 3] = std::array::from_fn(|i| [numbers[3 * i + 2], numbers[3 * i], numbers[3 * i + 1]]);
        // The oracle's lights are two-sided in effect: whichever winding faces the receiver.
        let scene = SceneBuilder::new().triangle(p, LAMBERT(0.0), 1.0).triangle([p[0], p[2], p[1]], LAMBERT(0.0), 1.0);
        assert_irradiance(&case.id, scene, case.value * PI / 0.5, 0.0, 3 * cases.len());
    }
}

#[test]
fn penumbrae_match() {
    for case in oracles_in("visibility/penumbra") {
        let x: f32 = case.id.strip_prefix("A.penumbra_x").and_then(|s| s.parse().ok()).expect("an x in the id");
        // Everything moved by −x, so that the receiver stays at the origin. The occluder is 1000 wide rather than endless.
        let occluder = [[-1000.0, -1000.0, 1.0], [-x, -1000.0, 1.0], [-x, 1000.0, 1.0], [-1000.0, 1000.0, 1.0]];
        let scene = ceiling(-x, 0.0, 2.0, 1.0).quad(occluder, LAMBERT(0.0), 0.0);
        // Coordinates of 1000 in f32 arithmetic would err, in f64 they do not; the edge itself is exact.
        assert_irradiance(&case.id, scene, case.value, 0.0, 15);
    }
}

#[test]
fn sphere_lights_match() {
    let cases = oracles_in("sphere light");
    let mut tried = 0;
    for case in &cases {
        let Some((ratio, degrees)) = case.id.strip_prefix("B.sphere_r/d").and_then(|s| s.split_once("_th")) else {
            continue;
        };
        let (r, theta): (f32, f64) = (ratio.parse().expect("r/d"), degrees.parse::<f64>().expect("θ").to_radians());
        // Away from the camera's line of sight; f32 leaves 3e-8 of the position, which E sees in full at grazing angles.
        let center = [-theta.sin() as f32, 0.0, theta.cos() as f32];
        let scene = SceneBuilder::new().sphere(center, r, LAMBERT(0.0), 1.0);
        assert_irradiance(&case.id, scene, case.value, 3e-8, 3 * cases.len());
        tried += 1;
    }
    assert!(tried >= 9 || cases.is_empty(), "only {tried} cases read");
}

/// An image whose radiance is a function of height only, so that irradiance has a one-dimensional integral.
#[test]
fn environment_images_light_by_their_bilinear_function() {
    let (width, height) = (16, 8);
    let texels: Vec<_> = (0..width * height).map(|i| [(i / width) as f32 + 1.0, 1.0, (i % width) as f32]).collect();
    let image = Environment::Image(EnvironmentImage { width, height, texels, rotation: 0.0 });
    // A Lambert floor, normal +y, seen from above.
    let r = 1.0;
    let floor = [[-r, 0.0, r], [r, 0.0, r], [r, 0.0, -r], [-r, 0.0, -r]];
    let scene: Scene = SceneBuilder::new()
        .environment(image)
        .quad(floor, LAMBERT(0.5), 0.0)
        .camera([0.0, 1.0, 0.0], [0.0; 3], 1.0)
        .build();
    let rule = crate::stats::quadrature::gauss_legendre(16);
    let row = |v: f64| (v * height as f64 - 0.5).clamp(0.0, height as f64 - 1.0) + 1.0;
    // ρ/π ∫ L cosθ dω = ρ ∫ L 2 sinθ cosθ dθ, panels between the kinks.
    let red = 0.5 * crate::stats::quadrature::integrate(&rule, 0.0, PI / 2.0, 8, |t| row(t / PI) * (2.0 * t).sin());
    let blue = 0.5 * (width as f64 - 1.0) / 2.0; // the mean over a period of a bilinear function is the texels' mean
    render(&scene, Region::whole(&scene), 40_000, 3).assert_mean("environment", [red, 0.5, blue], 1e-12, 3);
}

#[test]
fn two_lights_add_up_in_any_mixture_of_power() {
    // A weak wide one and a strong small one: chosen by power, each weighed by its own probability.
    let wide = oracle("A.sq_par_h1");
    let small = oracle("A.sq_omega1e-6");
    let (Some(wide), Some(small)) = (wide, small) else { return };
    let strong = ceiling(0.0, 0.0, 1.0, 0.5).quad(
        // Just below the wide one, whose millionth it hides.
        [[-5e-4, -5e-4, 1.0], [-5e-4, 5e-4, 1.0], [5e-4, 5e-4, 1.0], [5e-4, -5e-4, 1.0]]
            .map(|[x, y, z]| [x, y, z - 1e-5]),
        LAMBERT(0.0),
        1e5,
    );
    // E of the small one at z = 1 − 1e-5 is 2e-5 larger; what it hides is 1e-6.
    assert_irradiance("two lights", strong, wide.value + 1e5 * small.value * (1.0 + 2e-5), 2e-6, 3);
}
