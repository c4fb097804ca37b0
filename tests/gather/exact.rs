//! Against values that are known, and against a sum in f64.

use super::{as_they_are, fresh, gather, gathered, smooth_sky, sphere_scene};
use crate::oracle;
use crate::renders::{self, Set};
use octolux::estimate::bmc::{Covariance, Mean, Measure, Points, SetRecipe, point_sets};
use octolux::scene::{Bsdf, Gather, GatherCovariance, GatherLights, GatherMethod, GatherWeights};

const SEED: u64 = 5;

/// Σw = P: a convex Lambert body in a uniform environment shows its reflectance, in every sample.
#[test]
fn white_furnaces_are_exact() {
    let reflectance = [0.8, 0.5, 0.25];
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 20.0, 8).bounces(1).uniform_light();
    let material = set.material(Bsdf::Diffuse { reflectance }, [0.0; 3]);
    set.sphere(material, [0.0; 3], 1.0);
    let scene = set.finish();
    let is = gather(GatherMethod::BmcIs);
    let smooth = GatherCovariance::Given(Covariance::SquaredExponential { length: 0.3 });
    let cases = [
        ("fibonacci", is),
        ("owen, one set, as it is", Gather { points: Points::Owen, sets: 1, rotate: false, ..is }),
        ("random", Gather { points: Points::Random, samples: 17, ..is }),
        ("squared exponential", Gather { covariance: smooth, samples: 64, ..is }),
        ("at each hit", Gather { weights: GatherWeights::PerHit, points: Points::Random, samples: 20, ..is }),
        ("equal weights", gather(GatherMethod::McIs)),
    ];
    for (name, settings) in cases {
        let film = renders::film(&renders::world(&gathered(&scene, settings), SEED), 2);
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
            for (found, expected) in film.mean(x, y).into_iter().zip(reflectance) {
                // n weights, each rounded to f32, times three more roundings.
                let off = found / f64::from(expected) - 1.0;
                assert!(off.abs() < 6.0 * 6e-8, "{name}, pixel ({x}, {y}): off by {off:e}");
            }
        }
    }
}

/// One pixel, one sample, one set without rotation: Σ w ρ/π L over its directions in f64, with the oracle's visibility
/// and its sky.
#[test]
fn a_pixel_is_the_weighted_sum() {
    let mut set = Set::new([0.4, 2.0, 3.0], [0.9, 0.0, 0.8], 1e-4, 1).bounces(1).environment(smooth_sky());
    let ground = set.material(Bsdf::Diffuse { reflectance: [0.6, 0.5, 0.4] }, [0.0; 3]);
    let other = set.grey(0.5, 0.0);
    set.quad(ground, [[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0], [-6.0, 0.0, -6.0]]);
    set.sphere(other, [0.0, 1.0, 0.0], 1.0);
    let scene = set.finish();
    for (method, covariance) in [(GatherMethod::BmcIs, Some(Covariance::SOBOLEV)), (GatherMethod::McIs, None)] {
        let settings = Gather { sets: 1, samples: 64, ..as_they_are(gather(method)) };
        let film = renders::film(&renders::world(&gathered(&scene, settings), SEED), 1);
        let recipe = SetRecipe {
            points: settings.points,
            n: 64,
            sets: 1,
            measure: Measure::COSINE,
            covariance,
            mean: Mean::Constant,
            seed: SEED,
        };
        let points = &point_sets(&recipe)[0];
        let (mut sum, mut hidden) = ([0.0; 3], 0);
        for (i, &w) in points.weights.iter().enumerate() {
            let [x, y, z] = points.directions.each_ref().map(|axis| f64::from(axis[i]));
            // The tangent frame of (0, 1, 0) as Duff et al. 2017 give it: tangent (1, 0, 0), bitangent (0, 0, −1).
            let direction = [x, z, -y];
            if oracle::closest_hit(&scene, [0.9, 1e-6, 0.8], direction).is_some() {
                hidden += 1;
                continue;
            }
            let light = oracle::environment_radiance(&scene, direction);
            sum = std::array::from_fn(|c| sum[c] + f64::from(w) * light[c] / std::f64::consts::PI);
        }
        assert!((5..60).contains(&hidden), "{hidden} directions are hidden");
        for (c, rho) in [0.6, 0.5, 0.4].into_iter().enumerate() {
            let (found, expected) = (film.mean(0, 0)[c], rho * sum[c]);
            assert!((found / expected - 1.0).abs() < 2e-5, "{method:?}, channel {c}: {found} for {expected}");
        }
    }
}

/// A length-scale between those that random points resolve and those that are all but constant: the gate refuses its
/// weights, and the picture is that of equal ones.
#[test]
fn ill_conditioned_weights_are_refused_and_said() {
    let scene = sphere_scene(16, false).finish();
    let long = GatherCovariance::Given(Covariance::SquaredExponential { length: 0.3 });
    let stiff =
        Gather { covariance: long, samples: 64, points: Points::Random, sets: 1, ..gather(GatherMethod::BmcIs) };
    let world = renders::world(&gathered(&scene, stiff), SEED);
    let report = world.setup.gather.clone().expect("a report");
    assert_eq!((report.sets, report.equal_weights), (1, 1), "{report:?}");
    let equal = Gather { points: Points::Random, samples: 64, sets: 1, ..gather(GatherMethod::McIs) };
    let plain = renders::film(&renders::world(&gathered(&scene, equal), SEED), 2);
    crate::equivalence::assert_same("equal weights", &renders::film(&world, 2), &plain);
}

/// The covariance that is fitted is the best of those tried, and is one of the grid.
#[test]
fn a_pilot_chooses_the_covariance() {
    let scene = sphere_scene(16, false).finish();
    let fitted = Gather { covariance: GatherCovariance::Fitted, ..gather(GatherMethod::BmcIs) };
    let report = renders::world(&gathered(&scene, fitted), SEED).setup.gather.expect("a report");
    println!("{:?}", report.evidence);
    assert!(report.evidence.len() > 5);
    assert_eq!(report.covariance, Some(report.evidence[0].covariance));
    assert!(report.evidence.windows(2).all(|pair| pair[0].ln_likelihood >= pair[1].ln_likelihood));
    // Nothing to see: the default stands.
    let mut dark = Set::new([0.0, 0.0, 4.0], [0.0; 3], 20.0, 8).bounces(1);
    let grey = dark.grey(0.5, 0.0);
    dark.sphere(grey, [0.0; 3], 1.0);
    let report = renders::world(&gathered(&dark.finish(), fitted), SEED).setup.gather.expect("a report");
    assert_eq!((report.covariance, report.evidence.len()), (Some(Covariance::SOBOLEV), 0));
}

/// With one bounce and all lights sampled, no direction is followed.
#[test]
fn directions_that_cannot_bring_light_are_not_traced() {
    let settings = fresh(GatherMethod::McIs, Points::Random, GatherLights::Sampled, 8);
    let world = renders::world(&gathered(&sphere_scene(16, true).finish(), settings), SEED);
    let pool = octolux::render::thread_pool(1).expect("a thread");
    let options = octolux::render::Options {
        budget: octolux::render::Budget { samples: Some(1), ..Default::default() },
        width: octolux::kernel::Width::native(),
        tile: 16,
        aovs: false,
        output_seconds: 0.0,
        adaptive: false,
    };
    let outcome = octolux::render::render(&world, &options, &pool, &mut octolux::render::Progress::quiet());
    assert_eq!(outcome.counters.bounce_rays, 0);
    assert!(outcome.counters.shadow_rays > 100);
}
