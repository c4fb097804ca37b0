//! Renders against the converged images of an independent renderer in `../shared/refs`.
//!
//! Every scene is rendered with many seeds and few samples; what is tested are means: of the whole image and of square
//! blocks of it, each within Student's bound (Šidák over everything tested here, family-wise 1 %) of the spread over
//! the seeds and the reference's own noise. Also relMSE − floor ≤ 3·C/N. Seeds are fixed and never changed to mend a
//! failure. `cargo run --release --example references` does the same with more samples.

mod blocks;
mod reference;
mod replicates;

use crate::renders;
use blocks::Part;
use octolux::kernel::{Width, World};
use octolux::sampling::SamplerKind;
use octolux::scene::{self, Environment, EnvironmentImage, LightPaths, Scene};
use reference::Reference;
use replicates::Replicates;

/// A scene and how it is rendered here.
struct Case {
    name: &'static str,
    /// Samples a pixel of one render.
    samples: u64,
    /// Blocks along each side; 0: the whole image only, where rare bright paths rule a block's mean.
    blocks: u32,
    /// relMSE at one sample a pixel that an independent sampler has (`refs/README.md`).
    c: Option<f64>,
}

/// Renders of each scene: degrees of freedom of the spread are one less.
const SEEDS: u64 = 32;

/// The same of the costlier renders with divided samples.
const ADAPTIVE_SEEDS: u64 = 12;

const CASES: [Case; 11] = [
    Case { name: "cornell", samples: 4, blocks: 16, c: Some(0.273) },
    Case { name: "cornell_direct", samples: 4, blocks: 16, c: Some(0.023) },
    Case { name: "veach_mis", samples: 3, blocks: 16, c: Some(0.438) },
    Case { name: "env", samples: 4, blocks: 16, c: Some(0.298) },
    Case { name: "glass", samples: 4, blocks: 8, c: Some(2.65) },
    Case { name: "many_lights", samples: 4, blocks: 0, c: Some(17.9) },
    Case { name: "door_ajar", samples: 8, blocks: 0, c: Some(24.9) },
    Case { name: "furnace_diffuse05", samples: 8, blocks: 8, c: None },
    Case { name: "furnace_ggx_a0.2", samples: 8, blocks: 8, c: None },
    Case { name: "furnace_ggx_a1", samples: 8, blocks: 8, c: None },
    Case { name: "furnace_rglass_a0.5", samples: 8, blocks: 8, c: None },
];

/// many_lights' lamps are in view and up to 10,000 times brighter than what they light: the mean of its image is mostly
/// the noise of their edges. Pixels below this see none.
const NO_LAMP: f64 = 2.0;

/// Means tested here, at most: three channels of every image and block, with and without light paths, with divided samples
/// and by Sobol' points, and of the pixels without a lamp.
const TESTS: usize = {
    let (mut tests, mut i) = (3, 0);
    while i < CASES.len() {
        tests += 4 * 3 * (1 + CASES[i].blocks * CASES[i].blocks) as usize;
        i += 1;
    }
    tests
};

/// Loads a case's scene and reference; `None`, and the reason printed, without `../shared`.
fn load(name: &str) -> Option<(&'static Case, Scene, Reference)> {
    let Some(folder) = crate::stats::shared_dir().map(|d| d.join("refs")) else {
        eprintln!("skipped {name}: ../shared is absent");
        return None;
    };
    let case = CASES.iter().find(|c| c.name == name).expect("the case is listed");
    let scene = scene::load(&folder.join(name).join("scene.toml")).expect("the reference scene loads");
    Some((case, scene, Reference::load(&folder, name)))
}

fn check(name: &str, change: impl FnOnce(Scene) -> Scene) {
    check_by(SamplerKind::Independent, name, change);
}

fn check_by(sampler: SamplerKind, name: &str, change: impl FnOnce(Scene) -> Scene) {
    let Some((case, scene, reference)) = load(name) else { return };
    let replicates = Replicates::render(&change(scene), sampler, case.samples, SEEDS);
    let check = |parts: &[Part]| blocks::check(&replicates, &reference, name, parts, TESTS);
    check(&[Part::whole(&reference)]);
    if case.blocks > 0 {
        check(&Part::blocks(&reference, case.blocks));
    }
    if name == "many_lights" {
        check(&[Part::below(&reference, NO_LAMP)]);
    }
    if let Some(c) = case.c {
        let relmse = replicates.relmse(&reference) - reference.relmse_floor;
        let measured = relmse * case.samples as f64;
        println!("{name}: C = {measured:.3}, reference {c}");
        assert!(measured <= 3.0 * c, "{name}: relMSE − floor is {measured:.3}/N, more than 3 · {c}/N");
    }
}

/// One test function a scene, so that a failure says where.
macro_rules! references {
    ($($function:ident: $name:literal),* $(,)?) => {
        $(
            #[test]
            fn $function() {
                check($name, |scene| scene);
            }
        )*
    };
}

references! {
    cornell: "cornell",
    cornell_direct: "cornell_direct",
    veach_mis: "veach_mis",
    glass: "glass",
    many_lights: "many_lights",
    door_ajar: "door_ajar",
    furnace_diffuse: "furnace_diffuse05",
    furnace_smooth_metal: "furnace_ggx_a0.2",
    furnace_rough_metal: "furnace_ggx_a1",
    furnace_rough_glass: "furnace_rglass_a0.5",
}

/// By the points that are drawn where nobody asks for others.
#[test]
fn cornell_by_sobol_points() {
    check_by(SamplerKind::Sobol, "cornell", |scene| scene);
}

#[test]
fn veach_mis_by_sobol_points() {
    check_by(SamplerKind::Sobol, "veach_mis", |scene| scene);
}

#[test]
fn cornell_direct_by_sobol_points() {
    check_by(SamplerKind::Sobol, "cornell_direct", |scene| scene);
}

/// With paths from the lights, wanted or not.
fn with_light_paths(mut scene: Scene) -> Scene {
    scene.integrator.light_paths = LightPaths::On;
    scene
}

#[test]
fn cornell_with_light_paths() {
    check("cornell", with_light_paths);
}

#[test]
fn veach_mis_with_light_paths() {
    check("veach_mis", with_light_paths);
}

#[test]
fn door_ajar_with_light_paths() {
    check("door_ajar", with_light_paths);
}

#[test]
fn glass_without_light_paths() {
    check("glass", |mut scene| {
        scene.integrator.light_paths = LightPaths::Off;
        scene
    });
}

/// Samples divided by a pilot: no bias in any block, and at most half the error.
#[test]
fn veach_mis_adaptive() {
    const SAMPLES: u64 = 32;
    let Some((case, scene, reference)) = load("veach_mis") else { return };
    let render = |world: &World| renders::adaptive(world, SAMPLES, Width::native(), None).film;
    let replicates = Replicates::render_by(&scene, SamplerKind::Independent, ADAPTIVE_SEEDS, render);
    blocks::check(&replicates, &reference, "veach_mis, adaptive", &[Part::whole(&reference)], TESTS);
    blocks::check(&replicates, &reference, "veach_mis, adaptive", &Part::blocks(&reference, case.blocks), TESTS);
    let even =
        Replicates::render(&scene, SamplerKind::Independent, SAMPLES, 4).relmse(&reference) - reference.relmse_floor;
    let found = replicates.relmse(&reference) - reference.relmse_floor;
    println!("veach_mis, {SAMPLES} samples: relMSE {found:.2e} adaptive, {even:.2e} even");
    assert!(found < 0.5 * even, "dividing the samples gained {:.2} alone", even / found);
}

/// With the environment's rows where the reference has them: no allowance is needed.
#[test]
fn env() {
    check("env", |mut scene| {
        if let Some(Environment::Image(image)) = &mut scene.environment {
            *image = rows_of_the_reference(image);
        }
        scene
    });
}

/// The scene as it is: the reference's rows lie up to half a row off, which brightens it by up to 0.22 %.
#[test]
fn env_as_it_is() {
    let Some((_, scene, reference)) = load("env") else { return };
    let film = renders::film(&renders::world(&scene, 1000), 128);
    for (c, ours) in renders::image_mean(&film).into_iter().enumerate() {
        let ratio = ours.mean / reference.mean[c];
        println!("env as it is, channel {c}: mean ratio {ratio:.5} ± {:.5}", ours.std_error / reference.mean[c]);
        assert!((ratio - 1.0).abs() <= 0.003, "env, channel {c}: mean ratio {ratio:.5} is not within 0.3 % of 1");
    }
}

/// The reference puts row j at v = j/(h − 1), octolux at (j + ½)/h. An image with eight times the rows that takes, at
/// octolux's rows, the values that the reference interpolates: between them both are linear but at kinks, where the
/// difference is 1/64 of what it was.
fn rows_of_the_reference(image: &EnvironmentImage) -> EnvironmentImage {
    const FINER: usize = 8;
    let height = image.height * FINER;
    let row = |j: usize| {
        let at = (j as f64 + 0.5) / height as f64 * (image.height - 1) as f64;
        let low = (at as usize).min(image.height - 2);
        let f = (at - low as f64) as f32;
        let texel = |row: usize, i: usize| image.texels[row * image.width + i];
        (0..image.width).map(move |i| {
            let (a, b) = (texel(low, i), texel(low + 1, i));
            std::array::from_fn(|c| a[c] + (b[c] - a[c]) * f)
        })
    };
    let texels: Vec<[f32; 3]> = (0..height).flat_map(row).collect();
    EnvironmentImage { width: image.width, height, texels, rotation: image.rotation }
}
