//! Closed rooms in which every surface emits: radiance is the same at every point and in every direction, whatever the
//! geometry.

use super::{TESTS, rounding};
use crate::renders::{self, Set, assert_image_mean, image_mean};
use crate::stats;
use octolux::film::Film;
use octolux::scene::{self, FilmSize, GatherLights, IntegratorKind, LightPaths, Scene};
use std::path::Path;

const SEED: u64 = 11;

/// A room with a block and a sphere in it, all of one Lambert material.
fn enclosure(reflectance: f32, emission: f32, max_bounces: u32) -> Set {
    let mut set = Set::new([0.3, 0.2, 0.9], [-0.4, -0.1, -1.0], 80.0, 24).bounces(max_bounces);
    let wall = set.grey(reflectance, emission);
    set.room([wall; 6], [-1.0, -0.8, -1.5], [1.2, 0.9, 1.1]);
    set.block(wall, [-0.7, -0.6, -0.9], [-0.2, 0.1, -0.4]);
    set.sphere(wall, [0.5, -0.3, -0.6], 0.35);
    set
}

fn render(scene: &Scene, samples: u64) -> Film {
    renders::film(&renders::world(scene, SEED), samples)
}

/// Every case (1 − ρ^(n+1))/(1 − ρ) of the oracles, up to ρ = .999 and n = 64; n = 8 at ρ = .5 is 1.99609375.
#[test]
fn enclosures_cut_at_n_bounces() {
    let mut cases = vec![("1.99609375".to_string(), 0.5, 8, 1.99609375)];
    for case in stats::oracles_in("furnace (depth-limited)") {
        let (reflectance, bounces) = parse(&case.id);
        cases.push((case.id, reflectance, bounces, case.value));
    }
    for (name, reflectance, bounces, expected) in cases {
        let film = render(&enclosure(reflectance, 1.0, bounces).finish(), 8192 / u64::from(bounces + 8));
        assert_image_mean(&name, &film, [expected; 3], rounding(expected, bounces), TESTS);
    }
}

/// `C.interior_RHO_truncN`.
fn parse(id: &str) -> (f32, u32) {
    let fields = id.strip_prefix("C.interior_").and_then(|rest| rest.split_once("_trunc"));
    let (reflectance, bounces) = fields.unwrap_or_else(|| panic!("not a depth-limited furnace: {id}"));
    (reflectance.parse().expect("a reflectance"), bounces.parse().expect("a number of bounces"))
}

/// 0 bounces: what the camera sees emit and nothing else, without noise. 1: direct light too.
#[test]
fn bounces_are_counted_to_the_letter() {
    let emission_only = render(&enclosure(0.5, 1.0, 0).finish(), 4);
    for (y, x) in (0..24).flat_map(|y| (0..24).map(move |x| (y, x))) {
        assert_eq!(emission_only.mean(x, y), [1.0; 3]);
    }
    for (bounces, expected) in [(1, 1.5), (2, 1.75), (3, 1.875)] {
        let film = render(&enclosure(0.5, 1.0, bounces).finish(), 4096);
        assert_image_mean(&format!("{bounces} bounces"), &film, [expected; 3], rounding(expected, bounces), TESTS);
    }
    // `direct` is a path of one bounce, bit for bit.
    let direct = render(&enclosure(0.5, 1.0, 7).integrator(IntegratorKind::Direct).finish(), 16);
    let path = render(&enclosure(0.5, 1.0, 1).finish(), 16);
    assert_eq!(image_mean(&direct).map(|m| m.mean.to_bits()), image_mean(&path).map(|m| m.mean.to_bits()));
}

/// Kirchhoff: where every surface emits 1 − ρ, radiance is 1; cut at n bounces and with one ρ, 1 − ρ^(n+1).
#[test]
fn isothermal_rooms() {
    for (reflectance, bounces) in [(0.5f32, 4u32), (0.8, 3), (0.25, 12)] {
        let film = render(&enclosure(reflectance, 1.0 - reflectance, bounces).finish(), 2048);
        let expected = 1.0 - f64::from(reflectance).powi(bounces as i32 + 1);
        let name = format!("isothermal, ρ = {reflectance}, {bounces} bounces");
        assert_image_mean(&name, &film, [expected; 3], rounding(expected, bounces), TESTS);
    }
}

/// The scene as it is shipped: coloured walls, a mirror, a glass sphere.
#[test]
fn isothermal_room_as_shipped() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/isothermal/scene.toml");
    let mut scene = scene::load(&path).expect("the scene loads");
    scene.film = FilmSize { width: 48, height: 48 };
    assert_image_mean("scenes/isothermal", &render(&scene, 512), [1.0; 3], rounding(1.0, 64), TESTS);
}

/// A sphere seen from inside, cut by a plane that emits and does not reflect. The plane fills the solid angle that the
/// cap behind it would, so the rest of the sphere shows, after k bounces, B_k = ρ((1 − f) B_(k−1) + f) with f the
/// cap's share of the sphere, whatever the viewpoint; ρ f/(1 − ρ + ρ f) in the end.
#[test]
fn sphere_with_an_emitting_cap() {
    for (share, reflectance, bounces) in [(0.01, 0.5f32, 30), (0.05, 0.8, 60), (0.05, 0.8, 3)] {
        let plane = (1.0 - 2.0 * share) as f32;
        let share = 0.5 * (1.0 - f64::from(plane));
        let mut set = Set::new([0.1, 0.2, 0.3], [-0.3, 0.4, -1.0], 70.0, 24).bounces(bounces);
        let (wall, lamp) = (set.grey(reflectance, 0.0), set.grey(0.0, 1.0));
        set.sphere(wall, [0.0; 3], 1.0);
        let (z, side) = (f64::from(plane), 0.5);
        set.quad(lamp, [[-side, -side, z], [-side, side, z], [side, side, z], [side, -side, z]]);
        let rho = f64::from(reflectance);
        let expected = (0..bounces).fold(0.0, |b, _| rho * ((1.0 - share) * b + share));
        // The plane's rim is where it and the sphere are closer than a ray's offset (1e-6 of the sphere's radius).
        let rim = expected * 2e-6 / (2.0 * share);
        let name = format!("cap of {share:.3}, ρ = {reflectance}, {bounces} bounces");
        assert_image_mean(&name, &render(&set.finish(), 2048), [expected; 3], rounding(expected, bounces) + rim, TESTS);
    }
}

/// A lamp that is a sphere shines outwards: seen from inside it is dark, and what else shines there is all there is, whatever rounding
/// says of the side that points of its inside lie on.
#[test]
fn a_lamp_does_not_light_its_inside() {
    for (k, radius) in [0.15, 0.3, 0.37, 1.0, 1.7].into_iter().enumerate() {
        for (light_paths, kind) in [
            (LightPaths::Off, IntegratorKind::Path),
            (LightPaths::On, IntegratorKind::Path),
            (LightPaths::Off, IntegratorKind::Direct),
            (LightPaths::Off, IntegratorKind::Gather),
        ] {
            let center = [0.3, 0.2, 0.1 * k as f64];
            let mut set = Set::new(center, [1.0, 0.3, 0.0], 60.0, 16).bounces(2).integrator(kind);
            let lamp = set.grey(0.5, 10.0);
            set.sphere(lamp, center, radius);
            let mut scene = set.finish();
            scene.integrator.light_paths = light_paths;
            scene.integrator.gather.lights = GatherLights::Sampled;
            let film = render(&scene, 64);
            let brightest = (0..256).map(|i| film.mean(i % 16, i / 16)[0]).fold(0.0, f64::max);
            assert_eq!(brightest, 0.0, "radius {radius}, {kind:?}, light paths {light_paths:?}");
        }
    }
}
