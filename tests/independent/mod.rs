//! Whole images against the oracle, the f64 brute-force path tracer that shares no code with `src`.

use crate::equivalence::scenes;
use crate::oracle::{self, Estimate, Region};
use crate::renders;
use octolux::scene::{Environment, Scene};

/// Compares blocks of `block` × `block` pixels, family-wise 1 % over the blocks and channels of a scene. `spp` are the
/// oracle's samples; octolux, which is faster, takes four times as many.
fn compare(name: &str, scene: &Scene, spp: u32, block: usize) {
    let film = renders::film(&renders::world(scene, 31), 4 * u64::from(spp));
    let estimate = |x, y| -> [Estimate; 3] {
        let (mean, variance) = (film.mean(x, y), film.variance_of_mean(x, y).expect("many samples"));
        std::array::from_fn(|c| Estimate { mean: mean[c], std_error: variance[c].sqrt() })
    };
    let ours: Vec<_> = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y))).collect();
    let ours: Vec<_> = ours.into_iter().map(|(x, y)| estimate(x, y)).collect();
    let theirs = oracle::render(scene, Region::whole(scene), spp, 32);
    for (c, (e, ours)) in theirs.mean().into_iter().zip(renders::image_mean(&film)).enumerate() {
        let error = e.std_error.hypot(ours.std_error);
        println!(
            "{name}, channel {c}: {:.6}, oracle {:.6}: {:+.2} σ of {:.2} %",
            ours.mean,
            e.mean,
            (ours.mean - e.mean) / error,
            100.0 * error / e.mean
        );
    }
    // f32 against f64 over ten bounces: 1e-5 of radiances near 1.
    if let Some(problem) = theirs.disagreement(&ours, block, 1e-5) {
        panic!("{name}: {problem}");
    }
}

/// All materials, smooth normals, both kinds of emitters, an image environment.
#[test]
fn everything() {
    compare("everything", &scenes::everything(), 2048, 5);
}

/// The same by area lights alone, which an environment's light would drown.
#[test]
fn everything_but_the_sky() {
    let mut scene = scenes::everything();
    scene.environment = None;
    compare("everything but the sky", &scene, 2048, 5);
}

/// Texels, poles and the seam of an environment image, from a diffuse plain and two spheres.
#[test]
fn spheres_under_a_sky() {
    let scene = scenes::spheres_under_a_sky();
    assert!(matches!(scene.environment, Some(Environment::Image(_))));
    compare("spheres under a sky", &scene, 4096, 5);
}

/// Phong and coated spheres by point, directional and spot light through a lens; the oracle adds up every light.
#[test]
fn stage_lights() {
    compare("stage lights", &scenes::stage_lights(false), 2048, 5);
    compare("stage lights under a turned sky", &scenes::stage_lights(true), 2048, 5);
}

/// Vertex normals that point anywhere: what counts, and what fades, is told by both normals. Light that the ball throws far away is
/// rare: of half the samples the spread does not tell how much of it there is.
#[test]
fn crumpled_ball() {
    compare("crumpled ball from outside", &scenes::crumpled_ball(true), 4096, 5);
    compare("crumpled ball from inside", &scenes::crumpled_ball(false), 2048, 5);
}

#[test]
fn lambert_room() {
    compare("lambert room", &scenes::lambert_room(), 2048, 4);
}
