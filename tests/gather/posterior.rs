//! What the gather estimate believes of its own variance.

use super::ranking::plane;
use super::{as_they_are, gather, gathered, smooth_sky};
use crate::renders::{Set, film as plain_film, world as plain_world};
use octolux::estimate::bmc::{Covariance, Mean, Measure, Points, SetRecipe, point_sets};
use octolux::film::Film;
use octolux::kernel::{Prepare, Width, World};
use octolux::plan::{Force, Plan};
use octolux::render::{self, Budget, Options, Progress};
use octolux::scene::{Bsdf, Gather, GatherMethod, GatherWeights, Scene};
use std::f64::consts::PI;

const SEED: u64 = 5;

fn with_features(scene: &Scene, width: Width, samples: u64) -> Film {
    let options = Prepare { seed: SEED, ..Prepare::default() };
    let world = World::new(scene, Plan::new(scene, Force::default(), true), options).expect("a world");
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    let options = Options { budget, width, tile: 16, aovs: true, output_seconds: 0.0, adaptive: false };
    let pool = render::thread_pool(1).expect("a thread");
    render::render(&world, &options, &pool, &mut Progress::quiet()).film
}

fn believed(film: &Film) -> Vec<[f64; 3]> {
    let pixels = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    pixels.map(|(x, y)| film.posterior_variance(x, y).expect("a posterior")).collect()
}

/// One pixel, one set without rotation under the sky alone: V·σ̂² of the values that its 40 directions see.
#[test]
fn the_layer_is_the_posterior_variance() {
    let mut set = Set::new([0.4, 2.0, 3.0], [0.9, 0.0, 0.8], 1e-4, 1).bounces(1).environment(smooth_sky());
    let ground = set.material(Bsdf::Diffuse { reflectance: [0.6, 0.5, 0.4] }, [0.0; 3]);
    set.quad(ground, [[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0], [-6.0, 0.0, -6.0]]);
    let scene = set.finish();
    let recipe = SetRecipe {
        points: Points::Fibonacci,
        n: 40,
        sets: 1,
        measure: Measure::COSINE,
        covariance: Some(Covariance::SOBOLEV),
        mean: Mean::Constant,
        seed: SEED,
    };
    let points = &point_sets(&recipe)[0];
    let posterior = points.posterior.as_ref().expect("weights");
    let settings = Gather { sets: 1, ..as_they_are(gather(GatherMethod::BmcIs)) };
    let found = believed(&with_features(&gathered(&scene, settings), Width::native(), 1))[0];
    for (c, rho) in [0.6, 0.5, 0.4].into_iter().enumerate() {
        let light = |i: usize| {
            let [x, y, z] = points.directions.each_ref().map(|axis| f64::from(axis[i]));
            // The tangent frame of (0, 1, 0) as Duff et al. 2017 give it: tangent (1, 0, 0), bitangent (0, 0, −1).
            crate::oracle::environment_radiance(&scene, [x, z, -y])[c] * rho / PI
        };
        let expected = posterior.variance(&(0..40).map(light).collect::<Vec<_>>()).expect("a variance");
        // Values in f32 are good to 1e-6, and errors come through Q⁻¹, whose eigenvalues are below 1e3 here: of the middle
        // channel, a constant, nothing else is left.
        let rounding = posterior.unit_variance.expect("one") * (1e-6 * rho).powi(2) * 1e3;
        let off = (found[c] - expected).abs();
        println!("channel {c}: {:e} for {expected:e}, rounding {rounding:e}", found[c]);
        assert!(off <= 1e-3 * expected + rounding, "channel {c}: {:e} for {expected:e}", found[c]);
    }
}

/// The image is the same with and without it, it is the same at any width, and falls as 1/n over samples.
#[test]
fn believing_changes_no_image() {
    let scene = gathered(&plane(true), gather(GatherMethod::BmcIs));
    let first = with_features(&scene, Width::One, 2);
    let plain = plain_film(&plain_world(&scene, SEED), 2);
    crate::equivalence::assert_same("without features", &plain, &first);
    for width in [Width::Eight, Width::Sixteen] {
        assert_eq!(believed(&with_features(&scene, width, 2)), believed(&first), "{width:?}");
    }
    let mean = |film: &Film| believed(film).iter().flatten().sum::<f64>();
    let (two, eight) = (mean(&first), mean(&with_features(&scene, Width::native(), 8)));
    assert!((two / eight / 4.0 - 1.0).abs() < 0.1, "{two} {eight}");
    // Nothing of the kind without a process.
    let mc = with_features(&gathered(&plane(true), gather(GatherMethod::McIs)), Width::native(), 1);
    assert!(mc.posterior_variance(0, 0).is_none() && mc.aovs(0, 0).is_some());
}

/// Weights of a hit's own have the same belief as sets made beforehand, whose points they share in distribution.
#[test]
fn weights_of_a_hits_own_believe_too() {
    let shared = gathered(&plane(true), gather(GatherMethod::BmcIs));
    let own = Gather { weights: GatherWeights::PerHit, rotate: false, ..gather(GatherMethod::BmcIs) };
    let total = |scene: &Scene| believed(&with_features(scene, Width::native(), 2)).iter().flatten().sum::<f64>();
    let (shared, own) = (total(&shared), total(&gathered(&plane(true), own)));
    assert!((own / shared - 1.0).abs() < 0.1, "{own:e} {shared:e}");
}
