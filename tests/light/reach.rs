//! Where light samples suffice: what is said of their density there, and that images stay what they were.

use super::TESTS;
use super::scenes::*;
use crate::renders::{self, Set, assert_image_mean};
use crate::stats::Rng;
use octolux::Renderer;
use octolux::light::{Emitter, EmitterShape, FEW_EMITTERS, Lights, Receivers};
use octolux::own::Own;
use octolux::plan::{Force, Plan};
use octolux::sampling::SamplerKind;
use octolux::scene::{Environment, IntegratorKind, LightPaths, Scene};
use std::f64::consts::FRAC_1_PI;

fn lamps() -> Vec<(&'static str, Vec<Emitter>)> {
    let big = triangle(0, [[-0.4, 0.5, -0.4], [0.4, 0.5, -0.4], [0.0, 0.5, 0.5]], [3.0; 3]);
    let thin = triangle(1, [[-0.8, 0.2, 0.1], [0.8, 0.21, 0.1], [0.8, 0.2, 0.1]], [9.0, 1.0, 0.0]);
    let ball = sphere(2, [0.4, -0.3, 0.2], 0.2, [2.0; 3]);
    let weak = sphere(3, [-0.5, -0.4, -0.2], 0.1, [3.0; 3]);
    vec![("one", vec![big]), ("ball", vec![ball]), ("two", vec![big, thin]), ("all", vec![big, thin, ball, weak])]
}

/// Each sample drawn from beyond the reach is at least as dense as cosθ/π ever is; within it some are not.
#[test]
fn samples_are_dense_beyond_the_reach() {
    for (name, emitters) in lamps() {
        for place in [false, true] {
            let mut lights = area_lights(&emitters);
            if place {
                let positions = [[-1.5f32, -0.6, -1.5], [1.5, -0.6, -1.5], [0.0, -0.6, 1.5], [0.0, 1.4, 0.0]];
                let triangles = [[0, 2, 1], [0, 1, 3]];
                let spheres = [([0.4, -0.3, 0.2], 0.2), ([-0.5, -0.4, -0.2], 0.1)];
                lights.add_grid(&Receivers { positions: &positions, triangles: &triangles, spheres: &spheres });
                if !lights.has_grid() {
                    continue;
                }
            }
            let reach = lights.reach().expect("few lamps, each of which is chosen at times");
            let mut rng = Rng::new(31);
            let (mut beyond, mut thinner, mut least) = (0, 0, f64::MAX);
            for _ in 0..100_000 {
                // Half of them near a lamp.
                let anchor = match emitters[(rng.f64() * emitters.len() as f64) as usize].shape {
                    EmitterShape::Triangle { p0, .. } => f64s(p0),
                    EmitterShape::Sphere { center, .. } => f64s(center),
                };
                let (from, size) = if rng.f64() < 0.5 { ([0.0; 3], 8.0) } else { (anchor, 0.6) };
                let p = f32s(from.map(|c| c + size * (rng.f64() - 0.5)));
                let n = f32s(rng.sphere());
                let table = place.then(|| lights.table_at(vec1(p), vec1(n)));
                let s = lights.sample_from::<f32>(vec1(p), None, table, rng.f32(), [rng.f32(), rng.f32()], true);
                if s.pdf > 0.0 {
                    match reach.beyond::<f32>(vec1(p)) {
                        true => (beyond, least) = (beyond + 1, f64::min(least, s.pdf.into())),
                        false => thinner += usize::from(f64::from(s.pdf) < FRAC_1_PI),
                    }
                }
            }
            assert!(beyond > 500 && thinner > 100, "{name}, {place}: {beyond} beyond, {thinner} are thinner within");
            assert!(least >= FRAC_1_PI * (1.0 - 1e-6), "{name}, {place}: density {least}");
        }
    }
}

#[test]
fn many_lamps_and_those_that_are_never_chosen_have_none() {
    let lamp = |i: u32, radiance: f32| sphere(i, [f64::from(i), 0.0, 0.0], 0.1, [radiance; 3]);
    let lights = |count: usize| area_lights(&(0..count as u32).map(|i| lamp(i, 1.0)).collect::<Vec<_>>());
    assert!(lights(FEW_EMITTERS).reach().is_some() && lights(FEW_EMITTERS + 1).reach().is_none());
    assert!(area_lights(&[lamp(0, 1.0), lamp(1, 1e-12)]).reach().is_none());
    let sky = Environment::Constant([1.0; 3]);
    assert!(Lights::build(vec![lamp(0, 1.0)], Some(&sky)).unwrap().reach().is_none());
}

/// A floor around and below a lamp that hangs low: points within its reach and beyond.
pub(super) fn low_lamp(kind: IntegratorKind, bounces: u32) -> Scene {
    let mut set = Set::new([0.0, 4.0, 3.0], [0.0, 0.0, 0.0], 50.0, 16).bounces(bounces).integrator(kind);
    let (grey, lamp) = (set.grey(0.6, 0.0), set.grey(0.0, 2.0));
    set.quad(grey, [[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]]);
    set.quad(grey, [[-2.0, 0.0, -2.0], [2.0, 0.0, -2.0], [2.0, 2.0, -2.0], [-2.0, 2.0, -2.0]]);
    set.quad(lamp, [[-0.3, 0.2, 0.3], [-0.3, 0.2, -0.3], [0.3, 0.2, -0.3], [0.3, 0.2, 0.3]]);
    set.scene_mut().integrator.light_paths = LightPaths::Off;
    set.finish()
}

/// The same image as with both techniques at the last vertex, with rays left out.
#[test]
fn the_image_is_that_of_both_techniques() {
    for (kind, bounces) in [(IntegratorKind::Direct, 7), (IntegratorKind::Path, 1), (IntegratorKind::Path, 3)] {
        let scene = low_lamp(kind, bounces);
        let world = renders::world(&scene, 32);
        assert!(world.plan.last_by_lights && world.reach.is_some());
        let mut both = renders::world(&scene, 33);
        both.reach = None;
        let (film, other) = (renders::film(&world, 4096), renders::film(&both, 16_384));
        let expected = renders::image_mean(&other);
        // The other's own noise, at most half as large, widens the bound by √(1 + ¼) < 1.12.
        let slack = 0.12 * 4.0 * expected[0].std_error + 4.0 * expected[0].std_error;
        assert_image_mean(&format!("low lamp, {bounces}"), &film, expected.map(|c| c.mean), slack, TESTS);
    }
}

#[test]
fn where_the_plan_keeps_it() {
    let kept = |scene: &Scene| Plan::new(scene, Force::default(), false).last_by_lights;
    let scene = low_lamp(IntegratorKind::Path, 2);
    assert!(kept(&scene) && Plan::new(&scene, Force { general: true, geometry: None }, false).last_by_lights);
    assert!(!kept(&low_lamp(IntegratorKind::Gather, 2)));
    let mut lit = scene.clone();
    lit.environment = Some(Environment::Constant([1.0; 3]));
    assert!(!kept(&lit));
    let mut light_paths = scene.clone();
    light_paths.integrator.light_paths = LightPaths::On;
    assert!(!kept(&light_paths));
    // A program's own material: bit for bit as without.
    let renderer = Renderer::new(4).seed(34);
    let own = renderer.render_with(&scene, &Own::new()).unwrap();
    let mut world = renders::sampled(&scene, 34, Force::default(), SamplerKind::Sobol);
    world.reach = None;
    world.plan.path_reuse = false;
    crate::equivalence::assert_same("own", &own, &renders::film(&world, 4));
}
