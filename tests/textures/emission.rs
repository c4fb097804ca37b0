//! Lamps with a pattern: the irradiance they give, against quadrature.

use super::*;
use crate::renders::{self, assert_image_mean, image_mean};
use octolux::scene::{Gather, GatherLights, GatherMethod, GatherPdf, IntegratorKind, Sphere};
use std::f64::consts::{FRAC_1_PI, PI};

const SEED: u64 = 32;
const SAMPLES: u64 = 16_384;

fn receiver() -> Set {
    let mut set = Set::new([-2.0, 0.0, 0.1], [0.0; 3], 1e-4, 8).bounces(1);
    let ground = set.grey(1.0, 0.0);
    set.triangle(ground, [[-0.01, -0.01, 0.0], [0.02, -0.01, 0.0], [-0.01, 0.02, 0.0]]);
    set
}

/// Unlike in rows, columns and channels, with dark texels and a bright one.
fn pattern() -> Texture {
    image(
        4,
        3,
        |x, y| {
            if (x, y) == (2, 0) { [9.0, 0.5, 3.0] } else { [0.2 * x as f32, 0.3 * y as f32, ((x + y) % 2) as f32] }
        },
    )
}

/// 1/π ∫ L cos² / r² over a square of side 1 at height `h`, u along −x and v along y as [`mapped_square`] lays them.
fn quadrature(texture: &Texture, h: f64) -> [f64; 3] {
    let n = 1200;
    let mut sum = [0.0; 3];
    for i in 0..n {
        for j in 0..n {
            let (u, v) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
            let (x, y) = (0.5 - u, v - 0.5);
            let r2 = x * x + y * y + h * h;
            let weight = FRAC_1_PI * h * h / (r2 * r2) / (n * n) as f64;
            texture.at([u, v]).iter().zip(&mut sum).for_each(|(c, sum)| *sum += weight * c);
        }
    }
    sum
}

/// Faces down.
fn mapped_square(set: &mut Set, lamp: u32, h: f64) {
    mapped_quad(set, lamp, [[0.5, -0.5, h], [-0.5, -0.5, h], [-0.5, 0.5, h], [0.5, 0.5, h]]);
}

/// Near and wide, where rays find the lamp by the BSDF, and far, where only light sampling does; alone, and among
/// other lamps.
#[test]
fn patterned_squares() {
    for (h, others) in [(0.2, false), (1.0, false), (5.0, false), (1.0, true)] {
        let mut set = receiver();
        let lamp = set.grey(0.0, 2.0);
        edit(&mut set, lamp).maps.emission = Some(pattern());
        mapped_square(&mut set, lamp, h);
        let mut expected = quadrature(&pattern(), h).map(|e| 2.0 * e);
        if others {
            // Lit from behind, so that the ground does not see it: chosen in vain.
            let hidden = set.grey(0.0, 1.0);
            set.quad(hidden, [[-3.0, -3.0, 9.0], [3.0, -3.0, 9.0], [3.0, 3.0, 9.0], [-3.0, 3.0, 9.0]]);
            let sun = set.grey(0.0, 3.0);
            set.sphere(sun, [0.0, 3.0, 4.0], 0.5);
            expected = expected.map(|e| e + 3.0 * (0.5f64 / 5.0).powi(2) * 0.8);
        }
        let film = renders::film(&renders::world(&complete(set), SEED), SAMPLES);
        let name = format!("patterned square at {h}, others {others}");
        assert_image_mean(&name, &film, expected, 2e-5 * expected[0] / f64::min(h, 1.0), TESTS);
    }
}

/// Opacity and emission of one lamp both from images.
#[test]
fn a_patterned_lamp_with_holes() {
    let holes = grey_image(2, 2, |x, y| [[1.0, 0.25], [0.0, 0.5]][y as usize][x as usize]);
    let mut set = receiver();
    let lamp = set.grey(0.0, 2.0);
    edit(&mut set, lamp).maps.emission = Some(pattern());
    edit(&mut set, lamp).maps.opacity = Some(holes.clone());
    mapped_square(&mut set, lamp, 0.7);
    let n = 1200;
    let mut expected = [0.0; 3];
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let (u, v) = ((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n));
        let r2 = (0.5 - u).powi(2) + (v - 0.5).powi(2) + 0.49;
        let weight = 2.0 * FRAC_1_PI * 0.49 / (r2 * r2) / f64::from(n * n) * holes.at([u, v])[0];
        pattern().at([u, v]).iter().zip(&mut expected).for_each(|(c, sum)| *sum += weight * c);
    }
    let film = renders::film(&renders::world(&complete(set), SEED), SAMPLES);
    assert_image_mean("patterned lamp with holes", &film, expected, 5e-5 * expected[0], TESTS);
}

/// A globe: u turns about +y with .5 at +z, v rises to the top.
#[test]
fn a_patterned_globe() {
    let mut set = receiver();
    let lamp = set.grey(0.0, 1.0);
    edit(&mut set, lamp).maps.emission = Some(pattern());
    let (center, radius) = ([0.3, 0.2, 1.5], 0.7);
    set.sphere(lamp, center, radius);
    // Over the sphere's surface seen from the origin.
    let n = 1500;
    let mut expected = [0.0; 3];
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let (u, v) = ((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n));
        let (sin_turn, cos_turn) = (2.0 * PI * (u - 0.5)).sin_cos();
        let (across, up) = ((PI * v).sin(), -(PI * v).cos());
        let normal = [across * sin_turn, up, across * cos_turn];
        let p: Point = std::array::from_fn(|k| center[k] + radius * normal[k]);
        let r2 = p.iter().map(|x| x * x).sum::<f64>();
        let cos_light = -(0..3).map(|k| p[k] * normal[k]).sum::<f64>() / r2.sqrt();
        if cos_light <= 0.0 || p[2] <= 0.0 {
            continue;
        }
        let area = radius * radius * across * 2.0 * PI * PI / f64::from(n) / f64::from(n);
        let weight = FRAC_1_PI * cos_light * (p[2] / r2.sqrt()) / r2 * area;
        pattern().at([u, v]).iter().zip(&mut expected).for_each(|(c, sum)| *sum += weight * c);
    }
    let film = renders::film(&renders::world(&complete(set), SEED), SAMPLES);
    // The midpoint rule at the terminator is off by some 1e-5.
    assert_image_mean("patterned globe", &film, expected, 5e-5 * expected[0], TESTS);
}

/// An image of one value is that value: the same image, bit for bit, as a plain lamp of that radiance.
#[test]
fn a_pattern_without_a_pattern() {
    let plain = |set: &mut Set| set.grey(0.0, 1.0);
    let render = |patterned: bool| {
        let mut set = receiver();
        let lamp = plain(&mut set);
        if patterned {
            edit(&mut set, lamp).maps.emission = Some(image(3, 3, |_, _| [1.0; 3]));
        }
        mapped_square(&mut set, lamp, 1.0);
        let sphere = Sphere { center: [0.0, 2.0, 2.0], radius: 0.5, material: lamp };
        set.scene_mut().spheres.push(sphere);
        let film = renders::film(&renders::world(&complete(set), SEED), 64);
        (0..64).map(|i| film.mean(i % 8, i / 8)).collect::<Vec<_>>()
    };
    assert_eq!(render(true), render(false));
}

/// Bright texels between all points at which the lamp is looked at to be chosen: it counts for nothing beside another, and rays alone find
/// it. They are sent also where light samples would do for the other lamp.
#[test]
fn a_lamp_that_hides_from_the_choice_of_lights() {
    let mut set = receiver().integrator(IntegratorKind::Direct);
    let (hidden, sun) = (set.grey(0.0, 1.0), set.grey(0.0, 3.0));
    let mut dots = image(64, 64, |x, y| if (x, y) == (0, 0) { [4096.0; 3] } else { [0.0; 3] });
    dots.scale = [64.0; 2];
    edit(&mut set, hidden).maps.emission = Some(dots);
    let h = 0.2;
    mapped_square(&mut set, hidden, h);
    set.sphere(sun, [0.0, 3.0, 4.0], 0.5);
    let scene = complete(set);
    let even = quadrature(&image(1, 1, |_, _| [1.0; 3]), h);
    let expected = even.map(|e| e + 3.0 * (0.5f64 / 5.0).powi(2) * 0.8);
    let gathered = Gather { samples: 64, ..Gather::default() };
    let gathered =
        Gather { method: GatherMethod::McIs, lights: GatherLights::Seen, pdf: GatherPdf::Cosine, ..gathered };
    for kind in [IntegratorKind::Direct, IntegratorKind::Gather] {
        let mut scene = scene.clone();
        (scene.integrator.kind, scene.integrator.gather) = (kind, gathered);
        let samples = if kind == IntegratorKind::Gather { SAMPLES / 64 } else { SAMPLES };
        let film = renders::film(&renders::world(&scene, SEED), samples);
        assert_image_mean(&format!("hidden lamp, {kind:?}"), &film, expected, 0.01 * expected[0], TESTS);
        assert!(image_mean(&film)[0].std_error < 0.1 * expected[0], "too noisy to tell");
    }
}
