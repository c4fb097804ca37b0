//! Path reuse: the same means as paths of each pixel's own, less noise, and nothing where it cannot be.

use crate::equivalence::{assert_same, scenes};
use crate::renders::{self, How, Set};
use crate::stats::{self, Moments};
use octolux::kernel::Width;
use octolux::plan::{Force, Plan};
use octolux::render::{Budget, Options, Progress, thread_pool};
use octolux::scene::{
    self, Bsdf, ConductorFresnel, DeltaLight, Environment, FilmSize, Image, IntegratorKind, LightPaths, Masking,
    NO_TEXCOORD, PathReuse, Roulette, Scene, Texels, Texture,
};
use std::path::Path;
use std::sync::Arc;

fn without(mut scene: Scene) -> Scene {
    scene.integrator.path_reuse = PathReuse::Off;
    scene
}

/// Does the plan share paths?
fn shares(scene: &Scene) -> bool {
    Plan::new(scene, Force::default(), false).path_reuse
}

fn scenes_that_share() -> Vec<(&'static str, Scene)> {
    let scenes = [
        ("everything", scenes::everything()),
        ("lambert room", scenes::lambert_room()),
        ("spheres under a sky", scenes::spheres_under_a_sky()),
        ("stage lights", scenes::stage_lights(true)),
        ("crumpled ball", scenes::crumpled_ball(true)),
        ("metal floor", metal_floor()),
        ("red and white under green", red_and_white_under_green()),
        ("in rough glass", in_rough_glass()),
        ("dark and white stripes", dark_and_white_stripes()),
    ];
    assert!(scenes.iter().all(|(_, scene)| shares(scene)), "nothing would be tested");
    scenes.into()
}

/// Rough metal and Phong seen directly and by reflection, a screen that hides much of each from the other, a point light.
fn metal_floor() -> Scene {
    let mut set = Set::new([0.0, 1.2, 4.0], [0.0, 0.6, 0.0], 45.0, scenes::SIDE).bounces(4);
    let fresnel = ConductorFresnel::Schlick { f0: [0.9, 0.8, 0.6] };
    let metal = set.material(Bsdf::Conductor { alpha: 0.3, masking: Masking::Correlated, fresnel }, [0.0; 3]);
    let wood = Bsdf::Phong { diffuse: [0.4, 0.3, 0.2], specular: [0.3; 3], exponent: 20.0 };
    let wood = set.material(wood, [0.0; 3]);
    let clay = set.material(Bsdf::Diffuse { reflectance: [0.7, 0.6, 0.5] }, [0.0; 3]);
    set.quad(metal, [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]]);
    set.quad(clay, [[-3.0, 0.0, -1.5], [3.0, 0.0, -1.5], [3.0, 3.0, -1.5], [-3.0, 3.0, -1.5]]);
    set.quad(wood, [[-1.0, 0.2, 0.0], [0.2, 0.2, 0.4], [0.2, 1.0, 0.4], [-1.0, 1.0, 0.0]]);
    set.sphere(wood, [0.8, 0.4, 0.3], 0.4);
    let mut scene = set.finish();
    scene.environment = Some(Environment::Constant([0.2, 0.3, 0.4]));
    scene.delta_lights.push(DeltaLight::Point { position: [1.5, 2.0, 1.5], intensity: [6.0, 5.0, 4.0] });
    scene
}

/// What comes by way of a red stripe and the green metal above is black, by way of a white stripe it is not: neighbours share
/// what they cannot see themselves.
fn red_and_white_under_green() -> Scene {
    let mut set = Set::new([0.0, 2.0, 4.0], [0.0, 0.0, 0.0], 40.0, scenes::SIDE).bounces(4);
    let red = set.material(Bsdf::Diffuse { reflectance: [0.9, 0.0, 0.0] }, [0.0; 3]);
    let white = set.grey(0.8, 0.0);
    let fresnel = ConductorFresnel::Constant { reflectance: [0.0, 0.9, 0.0] };
    let green = set.material(Bsdf::Conductor { alpha: 0.5, masking: Masking::Correlated, fresnel }, [0.0; 3]);
    for i in 0..10 {
        let (left, right) = (-2.0 + 0.4 * f64::from(i), -1.6 + 0.4 * f64::from(i));
        let stripe = if i % 2 == 0 { red } else { white };
        set.quad(stripe, [[left, 0.0, 2.0], [right, 0.0, 2.0], [right, 0.0, -2.0], [left, 0.0, -2.0]]);
    }
    set.quad(green, [[-2.0, 2.5, -2.0], [2.0, 2.5, -2.0], [2.0, 2.5, 1.0], [-2.0, 2.5, 1.0]]);
    let light = DeltaLight::Point { position: [0.0, 1.5, 0.0], intensity: [5.0; 3] };
    set.light(light).finish()
}

/// Every other stripe is nearly black, and all light comes by way of the ceiling: what paths from dark stripes find there is half
/// of what the white ones are given.
fn dark_and_white_stripes() -> Scene {
    let mut set = Set::new([0.0, 1.9, 0.01], [0.0; 3], 54.0, scenes::SIDE).bounces(2);
    let (dark, white) = (set.grey(1e-6, 0.0), set.grey(0.8, 0.0));
    for i in 0..40 {
        let (left, right) = (-1.0 + 0.05 * f64::from(i), -0.95 + 0.05 * f64::from(i));
        let stripe = if i % 2 == 0 { dark } else { white };
        set.quad(stripe, [[left, 0.0, 1.0], [right, 0.0, 1.0], [right, 0.0, -1.0], [left, 0.0, -1.0]]);
    }
    set.quad(white, [[-30.0, 2.0, -30.0], [30.0, 2.0, -30.0], [30.0, 2.0, 30.0], [-30.0, 2.0, 30.0]]);
    let (position, direction) = ([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
    set.light(DeltaLight::Spot { position, direction, intensity: [3.0; 3], angle: 89.0 }).finish()
}

/// A ball within rough glass, which paths meet from behind, and a sheet of it that they meet from both sides.
fn in_rough_glass() -> Scene {
    let mut set = Set::new([0.0, 0.4, 2.5], [0.0, 0.0, 0.0], 50.0, scenes::SIDE).bounces(6);
    let glass = set.material(Bsdf::Dielectric { alpha: 0.3, masking: Masking::Separable, ior: 1.4 }, [0.0; 3]);
    let white = set.grey(0.8, 0.0);
    set.sphere(glass, [0.0; 3], 4.0);
    set.sphere(white, [0.0, -0.6, 0.0], 1.0);
    set.quad(glass, [[-1.5, 0.8, 0.5], [1.5, 0.8, 0.5], [1.5, 0.9, -1.5], [-1.5, 0.9, -1.5]]);
    let mut scene = set.finish();
    scene.environment = Some(Environment::Constant([1.0, 0.8, 0.6]));
    scene
}

/// Blocks along each side of the image.
const BLOCKS: u32 = 4;
const SEEDS: u64 = 1000;

/// Mean of each block of pixels and channel, over seeds.
fn block_means(scene: &Scene, first_seed: u64) -> Vec<Moments> {
    let mut world = renders::world(scene, 0);
    let side = scene.film.width / BLOCKS;
    let mut moments = vec![Moments::new(); (3 * BLOCKS * BLOCKS) as usize];
    for seed in first_seed..first_seed + SEEDS {
        world.seed = seed;
        let film = renders::film(&world, 4);
        for (k, moments) in moments.iter_mut().enumerate() {
            let (block, channel) = (k as u32 / 3, k % 3);
            let (bx, by) = (block % BLOCKS * side, block / BLOCKS * side);
            let pixels = (by..by + side).flat_map(|y| (bx..bx + side).map(move |x| (x, y)));
            moments.push(pixels.map(|(x, y)| film.mean(x, y)[channel]).sum::<f64>() / f64::from(side * side));
        }
    }
    moments
}

/// The spread over seeds knows of errors that go together.
#[test]
fn the_means_are_those_of_own_paths() {
    let scenes = scenes_that_share();
    let bound = stats::z_bound(scenes.len() * (3 * BLOCKS * BLOCKS) as usize);
    for (name, scene) in scenes {
        let (shared, own) = (block_means(&scene, 1), block_means(&without(scene), 1_000_000));
        let mut seen = 0.0f64;
        for (k, (a, b)) in shared.iter().zip(&own).enumerate() {
            let error = a.std_error().hypot(b.std_error());
            seen = seen.max(bound * error / b.mean);
            let off = a.mean - b.mean;
            assert!(
                off.abs() <= bound * error,
                "{name}, block {}, channel {}: {} for {}, {:.1} standard errors",
                k / 3,
                k % 3,
                a.mean,
                b.mean,
                off / error
            );
        }
        println!("{name}: a bias of {seen:.1e} of a block would be seen");
    }
}

/// A pixel alone shares with nobody: sample for sample it has what its own paths find, to rounding, if these do not end by
/// chance (which goes by what paths carry, and shared ones carry less of their first surface).
#[test]
fn a_pixel_alone_has_its_own_paths() {
    for (name, scene) in scenes_that_share() {
        for (k, at) in [[0.0, 0.3, 0.9], [-0.7, 0.3, 0.6], [0.6, 0.1, 1.5], [0.1, 0.0, 2.0], [-0.4, 0.6, 0.2]]
            .into_iter()
            .enumerate()
        {
            let mut scene = scene.clone();
            scene.film = FilmSize { width: 1, height: 1 };
            scene.camera.look_at = at;
            scene.camera.vfov = 4.0;
            scene.integrator.roulette = Roulette { after: 2, below: 0.0 };
            let (shared, own) = (
                renders::film(&renders::world(&scene, 7), 512),
                renders::film(&renders::world(&without(scene), 7), 512),
            );
            for c in 0..3 {
                let (a, b) = (shared.mean(0, 0)[c], own.mean(0, 0)[c]);
                assert!((a - b).abs() <= 2e-5 * b.abs(), "{name}, place {k}, channel {c}: {a} for {b}");
            }
        }
    }
}

/// A metal wall just above a floor of which only what it sees at less than a degree is lit: whether it sees that must not be
/// a matter of rounding.
#[test]
fn what_is_seen_at_a_low_angle_is_not_lost() {
    let mut set = Set::new([0.0, 0.5, 2.0], [0.0, 0.02, 0.0], 0.05, 1).bounces(2);
    let fresnel = ConductorFresnel::Constant { reflectance: [0.9; 3] };
    let metal = set.material(Bsdf::Conductor { alpha: 0.8, masking: Masking::Correlated, fresnel }, [0.0; 3]);
    let clay = set.grey(0.7, 0.0);
    set.quad(metal, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    set.quad(clay, [[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, 0.0], [-9.0, 0.0, 0.0]]);
    let (position, direction) = ([0.0, 3.0, 5.0], [0.0, -1.0, 0.0]);
    let scene = set.light(DeltaLight::Spot { position, direction, intensity: [9.0; 3], angle: 30.0 }).finish();
    let mean = |scene: &Scene| renders::film(&renders::world(scene, 11), 1 << 16).mean(0, 0)[0];
    let (shared, own) = (mean(&scene), mean(&without(scene.clone())));
    assert!(shares(&scene) && own > 0.0 && (shared - own).abs() <= 2e-5 * own, "{shared} for {own}");
}

/// Walls lit by way of a floor whose image bends its normals away from most of them: turned towards who looks, they are other
/// normals to each. Pixel by pixel: the sum over a block would know nothing of it.
#[test]
fn normals_of_images_are_not_shared() {
    let mut set = Set::new([0.0, 1.2, 3.4], [0.0, 1.0, 0.0], 40.0, 8).bounces(2);
    let (clay, bent) = (set.grey(0.75, 0.0), set.grey(0.8, 0.0));
    let texels = Texels::Floats([0.975, 0.5, 0.655].to_vec());
    let map = Texture::new(Arc::new(Image { width: 1, height: 1, channels: 3, texels }), false);
    let material = &mut set.scene_mut().materials[bent as usize];
    (material.maps.normal, material.maps.strength) = (Some(map), [1.0; 2]);
    set.quad(bent, [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]]);
    set.quad(clay, [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 2.0, -1.0], [-1.0, 2.0, -1.0]]);
    set.quad(clay, [[-1.0, 0.0, 1.0], [-1.0, 0.0, -1.0], [-1.0, 2.0, -1.0], [-1.0, 2.0, 1.0]]);
    set.quad(clay, [[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [1.0, 2.0, 1.0], [1.0, 2.0, -1.0]]);
    let mesh = &mut set.scene_mut().mesh;
    mesh.texcoords = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].to_vec();
    mesh.texcoord_indices = vec![[NO_TEXCOORD; 3]; mesh.triangles.len()];
    mesh.texcoord_indices[..2].copy_from_slice(&[[0, 1, 2], [0, 2, 3]]);
    let light = DeltaLight::Directional { direction: [0.1, -1.0, -0.1], irradiance: [3.0; 3] };
    let scene = set.light(light).finish();
    assert!(shares(&scene));
    let pixels = |scene: &Scene| {
        let mut world = renders::world(scene, 0);
        let mut moments = vec![Moments::new(); 64];
        for seed in 1..=200 {
            world.seed = seed;
            let film = renders::film(&world, 64);
            moments.iter_mut().enumerate().for_each(|(k, m)| m.push(film.mean(k as u32 % 8, k as u32 / 8)[0]));
        }
        moments
    };
    let bound = stats::z_bound(64);
    for (k, (a, b)) in pixels(&scene).iter().zip(&pixels(&without(scene))).enumerate() {
        let error = a.std_error().hypot(b.std_error());
        assert!((a.mean - b.mean).abs() <= bound * error, "pixel {k}: {} for {} ± {error}", a.mean, b.mean);
    }
}

/// A light too close to a ceiling for f32, hidden from the floor that the camera sees: what paths find there is no number.
#[test]
fn what_is_no_number_is_counted_and_spoils_no_other() {
    let mut set = Set::new([0.0, 1.0, 3.0], [0.0, 0.0, 0.0], 20.0, 8).bounces(2);
    let clay = set.grey(0.7, 0.0);
    set.quad(clay, [[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]]);
    set.quad(clay, [[-2.0, 2.0, -2.0], [2.0, 2.0, -2.0], [2.0, 2.0, 2.0], [-2.0, 2.0, 2.0]]);
    // A small screen just below the light.
    set.quad(clay, [[-0.3, 1.8, 0.3], [0.3, 1.8, 0.3], [0.3, 1.8, -0.3], [-0.3, 1.8, -0.3]]);
    let scene = set.light(DeltaLight::Point { position: [0.0, 1.9, 0.0], intensity: [2e38; 3] }).finish();
    assert!(shares(&scene));
    let pool = thread_pool(1).expect("a thread");
    let options = Options {
        budget: Budget { samples: Some(64), ..Budget::default() },
        width: Width::native(),
        tile: 8,
        aovs: false,
        output_seconds: 0.0,
        adaptive: false,
    };
    let film = |scene: &Scene| {
        let world = renders::world(scene, 1);
        octolux::render::render(&world, &options, &pool, &mut Progress::quiet()).film
    };
    let (shared, own) = (film(&scene), film(&without(scene.clone())));
    let (found, expected) = (shared.discarded().count, own.discarded().count);
    println!("{found} samples discarded, {expected} of own paths");
    assert!(expected > 0 && found == expected, "{found} discarded for {expected}");
    assert!((0..64).all(|k| shared.mean(k % 8, k / 8).iter().all(|x| x.is_finite())), "a pixel is spoilt");
}

#[test]
fn there_is_less_noise() {
    let relative_variance = |scene: &Scene| {
        let film = renders::film(&renders::world(scene, 5), 16);
        let pixels = (0..scene.film.height).flat_map(|y| (0..scene.film.width).map(move |x| (x, y)));
        let relative = |(x, y)| {
            let variance = film.variance_of_mean(x, y).expect("samples");
            film.mean(x, y)
                .into_iter()
                .zip(variance)
                .map(|(mean, variance)| variance / (mean * mean + 0.01))
                .sum::<f64>()
        };
        pixels.map(relative).sum::<f64>()
    };
    // As large as it is meant to be: blocks are small, and few pixels are on the lamp's rim.
    let mut cornell = scene::load(Path::new("scenes/cornell/scene.toml")).expect("a scene of the project");
    cornell.film = FilmSize { width: 256, height: 256 };
    for (name, scene, most) in [("lambert room", scenes::lambert_room(), 0.6), ("cornell", cornell, 0.2)] {
        let (shared, own) = (relative_variance(&scene), relative_variance(&without(scene)));
        println!("{name}: {:.3} of the variance", shared / own);
        assert!(shared <= most * own, "{name}: {shared} for {own}");
    }
}

/// Films whose sides are no multiples of a block's, or less.
#[test]
fn blocks_at_the_rim_leave_no_trace_of_lanes_and_tiles() {
    let pool = thread_pool(2).expect("threads");
    for (name, scene) in scenes_that_share() {
        for (width, height) in [(13, 11), (3, 9), (8, 1)] {
            let mut scene = scene.clone();
            scene.film = FilmSize { width, height };
            let world = renders::world(&scene, 3);
            let film = |width, tile| renders::film_on(&pool, &world, 6, How { width, tile });
            let expected = film(Width::One, 16);
            for (width, tile) in [(Width::One, 3), (Width::Eight, 16), (Width::Sixteen, 8), (Width::Sixteen, 40)] {
                assert_same(&format!("{name}, {} lanes, tile {tile}", width.lanes()), &film(width, tile), &expected);
            }
        }
    }
}

#[test]
fn where_it_cannot_be_the_plan_leaves_it_out() {
    let with = |change: fn(&mut Scene)| {
        let mut scene = scenes::lambert_room();
        change(&mut scene);
        shares(&scene)
    };
    assert!(with(|_| {}));
    assert!(!with(|scene| scene.integrator.path_reuse = PathReuse::Off));
    assert!(!with(|scene| scene.integrator.max_bounces = 1));
    assert!(!with(|scene| scene.integrator.roulette.after = 1));
    assert!(!with(|scene| scene.integrator.light_paths = LightPaths::On));
    assert!(!with(|scene| scene.integrator.kind = IntegratorKind::Direct));
    assert!(!shares(&scenes::images()), "a cut-out is in it");
    // The general kernel decides alike.
    let room = scenes::lambert_room();
    assert!(Plan::new(&room, Force { general: true, geometry: None }, false).path_reuse);
}
