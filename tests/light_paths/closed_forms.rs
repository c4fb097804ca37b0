//! Light through glass, known in closed form.

use super::{TESTS, film, with};
use crate::renders::{Set, assert_image_mean};
use octolux::scene::{self, Bsdf, FilmSize, LightPaths, Masking, Scene};
use std::f64::consts::PI;
use std::path::Path;

const IOR: f64 = 1.5;
/// Of the pane's lower and upper side, and of the lamp.
const LOW: f64 = 1.0;
const HIGH: f64 = 1.5;
const LAMP: f64 = 2.5;

/// A black-backed lamp of half side `half` above a wide pane of glass above a grey floor, of which a small square around the
/// origin is seen from below the pane. Three scatterings: light crosses the pane once and is scattered by the floor.
pub fn pane(half: f64) -> Scene {
    let mut set = Set::new([0.0, 0.9, 0.0], [0.0; 3], 5.0, 16).bounces(3);
    let glass = set.material(Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior: IOR as f32 }, [0.0; 3]);
    let (floor, lamp) = (set.grey(0.5, 0.0), set.grey(0.0, 1.0 / (half * half) as f32));
    set.quad(floor, [[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]]);
    set.block(glass, [-20.0, LOW, -20.0], [20.0, HIGH, 20.0]);
    set.quad(lamp, [[-half, LAMP, -half], [half, LAMP, -half], [half, LAMP, half], [-half, LAMP, half]]);
    set.finish()
}

/// Fresnel's reflectance from the outside of the glass at the cosine `c`.
fn fresnel(c: f64) -> f64 {
    let t = (1.0 - (1.0 - c * c) / (IOR * IOR)).sqrt();
    let (s, p) = ((c - IOR * t) / (c + IOR * t), (IOR * c - t) / (IOR * c + t));
    0.5 * (s * s + p * p)
}

/// Radiance of the floor at the origin's surroundings, ρ/π ∫ L (1 − F)² cosθ dω, over points of the lamp: the ray to a point r
/// to the side at angle θ satisfies r = (LAMP − d) tanθ + d tanθ′ for a pane of thickness d, and dω = sinθ dθ dφ with dA = r dr dφ.
fn expected(half: f64, seen: f64) -> f64 {
    let d = HIGH - LOW;
    let shift = |sin: f64| {
        let (c, t) = ((1.0 - sin * sin).sqrt(), (1.0 - sin * sin / (IOR * IOR)).sqrt());
        (LAMP - d) * sin / c + d * sin / IOR / t
    };
    // ∫ over the lamp seen from the floor's point (px, pz).
    let at = |px: f64, pz: f64| {
        const N: usize = 24;
        let mut sum = 0.0;
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let place = |i: usize| half * (2.0 * (i as f64 + 0.5) / N as f64 - 1.0);
            let r = (place(i) - px).hypot(place(j) - pz).max(1e-9);
            // By bisection: the shift grows with the sine.
            let (mut low, mut high) = (0.0, 1.0 - 1e-12);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if shift(middle) < r { low = middle } else { high = middle }
            }
            let sin = 0.5 * (low + high);
            let step = 1e-6;
            let slope = (shift(sin + step) - shift(sin - step).abs() * (sin - step).signum()) / (2.0 * step);
            let c = (1.0 - sin * sin).sqrt();
            // cosθ dω = sinθ d(sinθ) dφ = sinθ/(r dr/dsinθ) dA.
            sum += (1.0 - fresnel(c)).powi(2) * sin / (r * slope);
        }
        sum / (N * N) as f64 * 4.0
    };
    // The lamp's radiance is 1/half²; its area 4 half² then leaves the 4 above.
    const M: usize = 16;
    let place = |i: usize| seen * (2.0 * (i as f64 + 0.5) / M as f64 - 1.0);
    let points = (0..M).flat_map(|i| (0..M).map(move |j| (i, j)));
    0.5 / PI * points.map(|(i, j)| at(place(i), place(j))).sum::<f64>() / (M * M) as f64
}

#[test]
fn a_lamp_through_a_pane() {
    // The floor's square that is seen, from .9 above at 5°.
    let seen = 0.9 * 2.5f64.to_radians().tan();
    for (half, samples, light_paths) in [
        (0.5, 512, LightPaths::On),
        (0.5, 512, LightPaths::Off),
        (0.05, 512, LightPaths::On),
        (1.5, 256, LightPaths::On),
    ] {
        let expected = expected(half, seen);
        let film = film(&with(pane(half), light_paths), 41, samples);
        // Midpoints of 24 × 24 on the lamp and 16 × 16 on the floor: 1e-4 where the lamp is large.
        assert_image_mean(&format!("pane, {half}, {light_paths:?}"), &film, [expected; 3], 3e-4 * expected, TESTS);
    }
}

/// A sealed room in equilibrium shows 1 everywhere, whatever is in it: importance must not be scaled by η² where radiance is.
#[test]
fn equilibrium_with_glass() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/isothermal/scene.toml");
    let mut scene = scene::load(&path).expect("the scene loads");
    scene.film = FilmSize { width: 32, height: 32 };
    let film_of = |scene: &Scene| film(&with(scene.clone(), LightPaths::On), 43, 512);
    let rounding = 20.0 * 65.0 / 16_777_216.0;
    assert_image_mean("isothermal", &film_of(&scene), [1.0; 3], rounding, TESTS);
    // The eye inside the glass: radiance there is η² times as much.
    scene.camera.position = [0.9, 0.55, 1.2];
    scene.camera.look_at = [0.0, 0.6, 0.0];
    assert_image_mean("eye in glass", &film_of(&scene), [2.25; 3], 2.25 * rounding, TESTS);
}
