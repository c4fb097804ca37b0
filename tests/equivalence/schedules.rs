//! Width, threads, tiles, passes, traversal and specialisation leave no trace.

use super::{assert_same, bits, scenes};
use crate::renders::{self, How, film_on, forced};
use octolux::kernel::Width;
use octolux::plan::{Force, GeometryMode, Plan, Shading};
use octolux::render::thread_pool;
use octolux::sampling::SamplerKind;

/// Of the many renders.
const FEW: u64 = 3;
/// So that whole packets are samples of one pixel, and others not.
const SAMPLES: u64 = 19;
const SEED: u64 = 21;

/// Against the general kernel at width 1 with a tree, on one thread.
#[test]
fn every_kernel_gives_the_general_scalar_kernels_bits() {
    let geometry = |geometry| Force { general: true, geometry: Some(geometry) };
    let forces = [
        ("as planned", Force::default()),
        ("general", Force { general: true, geometry: None }),
        ("brute force", geometry(GeometryMode::Brute)),
        ("tree", geometry(GeometryMode::Tree)),
        ("specialised, tree", Force { general: false, geometry: Some(GeometryMode::Tree) }),
        ("specialised, packets", Force { general: false, geometry: Some(GeometryMode::Packet) }),
        ("specialised, streams", Force { general: false, geometry: Some(GeometryMode::Stream) }),
    ];
    let pool = thread_pool(2).expect("threads");
    for (name, scene) in scenes::all() {
        let reference = forced(&scene, SEED, geometry(GeometryMode::Tree));
        let expected = film_on(&thread_pool(1).expect("a thread"), &reference, FEW, scalar());
        for (what, force) in forces {
            let world = forced(&scene, SEED, force);
            for width in Width::ALL {
                let found = film_on(&pool, &world, FEW, How { width, tile: 16 });
                assert_same(&format!("{name}, {what}, {} lanes", width.lanes()), &found, &expected);
            }
        }
    }
}

/// The same with the other sampler, on scenes that together draw every kind of number.
#[test]
fn sobol_points_leave_no_trace_either() {
    let pool = thread_pool(2).expect("threads");
    let general = Force { general: true, geometry: Some(GeometryMode::Tree) };
    for (name, scene) in [
        ("everything", scenes::everything()),
        ("lambert room", scenes::lambert_room()),
        ("images", scenes::images()),
        ("stage lights", scenes::stage_lights(true)),
        ("light paths", scenes::with_light_paths(crate::light_paths::shop(true))),
    ] {
        let world = |force| renders::sampled(&scene, SEED, force, SamplerKind::Sobol);
        let expected = film_on(&thread_pool(1).expect("a thread"), &world(general), SAMPLES, scalar());
        let independent = film_on(&pool, &forced(&scene, SEED, general), SAMPLES, scalar());
        assert_ne!(bits(&expected), bits(&independent), "{name}: the sampler is not the other one");
        for width in Width::ALL {
            for (force, tile) in [(general, 7), (Force::default(), 16), (Force::default(), 1)] {
                let found = film_on(&pool, &world(force), SAMPLES, How { width, tile });
                assert_same(&format!("{name}, {force:?}, tile {tile}, {} lanes", width.lanes()), &found, &expected);
            }
        }
    }
}

fn scalar() -> How {
    How { width: Width::One, tile: 16 }
}

#[test]
fn threads_and_tiles_leave_no_trace() {
    for scene in [scenes::everything(), scenes::with_light_paths(crate::light_paths::shop(false))] {
        let world = renders::world(&scene, SEED);
        let expected = film_on(&thread_pool(1).expect("a thread"), &world, SAMPLES, scalar());
        for (threads, tile) in [(1, 1), (2, 3), (3, 7), (4, 8), (2, 13), (1, 64)] {
            let pool = thread_pool(threads).expect("threads");
            for width in Width::ALL {
                let found = film_on(&pool, &world, SAMPLES, How { width, tile });
                assert_same(&format!("{threads} threads, tile {tile}, {} lanes", width.lanes()), &found, &expected);
            }
        }
    }
}

/// The scenes really differ in what their plans keep: otherwise the comparisons above would compare nothing.
#[test]
fn plans_differ() {
    let plan = |scene| Plan::new(&scene, Force::default(), false);
    let room = plan(scenes::lambert_room());
    assert_eq!((room.geometry, room.shading), (GeometryMode::Brute, Shading::Lambert));
    assert!(!room.spheres && !room.environment && !room.shading_normals && room.area_lights);
    let all = plan(scenes::everything());
    assert_eq!((all.geometry, all.shading), (GeometryMode::Tree, Shading::General));
    assert!(all.spheres && all.environment && all.shading_normals && all.area_lights);
    assert!(!all.textures && !all.cutouts && !all.patterned_lights && !all.texcoords);
    let images = plan(scenes::images());
    assert!(images.textures && images.cutouts && images.patterned_lights && images.texcoords);
}

/// And images differ where they should.
#[test]
fn seeds_and_samples_do_leave_a_trace() {
    let scene = scenes::everything();
    let of = |seed, samples| bits(&renders::film(&renders::world(&scene, seed), samples));
    let first = of(1, 4);
    assert_ne!(first, of(2, 4));
    assert_ne!(first, of(1, 5));
    assert_eq!(first, of(1, 4));
}
