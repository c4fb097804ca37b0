//! How often the truth lies inside the intervals that the posterior gives, over the pixels of one render.

use crate::renders::{film_with, prepare_with};
use octolux::estimate::bmc::{Covariance, Points};
use octolux::film::Film;
use octolux::render;
use octolux::scene::{Gather, GatherCovariance, GatherMethod, GatherWeights, IntegratorKind, Scene};
use octolux::student::student_quantile;
use std::error::Error;

const NOMINAL: [f64; 3] = [0.5, 0.9, 0.95];

/// One camera sample a pixel, so that estimate and truth are of the same hit: the truth is that of 1,024 Owen points,
/// equally weighted, from the same camera sample.
pub fn print(scene: &Scene) -> Result<(), Box<dyn Error>> {
    let pool = render::thread_pool(std::thread::available_parallelism().map_or(1, |n| n.get()))?;
    let gathered = |gather: Gather| {
        let mut scene = scene.clone();
        scene.integrator.kind = IntegratorKind::Gather;
        scene.integrator.max_bounces = 1;
        scene.integrator.gather = gather;
        prepare_with(&scene, 0, true).map(|world| film_with(&pool, &world, 1, true).0)
    };
    let truth = gathered(Gather {
        method: GatherMethod::McIs,
        points: Points::Owen,
        weights: GatherWeights::PerHit,
        rotate: false,
        samples: 1024,
        ..Gather::default()
    })?;
    println!("{:34} {:>7} {:>7} {:>7} {:>9} {:>9}", "covered at", "50 %", "90 %", "95 %", "RMSE", "believed");
    let bmc = Gather { samples: scene.integrator.gather.samples, method: GatherMethod::BmcIs, ..Gather::default() };
    let given = |covariance| Gather { covariance: GatherCovariance::Given(covariance), ..bmc };
    for (name, gather) in [
        ("fibonacci, sobolev", bmc),
        ("fibonacci, sobolev 1.5", given(Covariance::Sobolev { smoothness: 1.5 })),
        ("fibonacci, se 0.5", given(Covariance::SquaredExponential { length: 0.5 })),
        ("fibonacci, fitted", Gather { covariance: GatherCovariance::Fitted, ..bmc }),
        ("random, sobolev", Gather { points: Points::Random, ..bmc }),
    ] {
        let found = gathered(gather)?;
        let [c50, c90, c95, rmse, believed] = coverage(&found, &truth, gather.samples - 1);
        println!("{name:34} {:6.1}% {:6.1}% {:6.1}% {rmse:9.5} {believed:9.5}", 100.0 * c50, 100.0 * c90, 100.0 * c95);
    }
    Ok(())
}

/// Shares of pixel channels whose truth lies inside Student's intervals; RMSE, and what the posterior takes it for. Pixels
/// without any uncertainty (background, darkness) do not count.
fn coverage(found: &Film, truth: &Film, dof: u32) -> [f64; 5] {
    let bounds = NOMINAL.map(|p| student_quantile(dof, p));
    let (mut inside, mut squares, mut believed, mut count) = ([0.0; 3], 0.0, 0.0, 0.0);
    for (x, y) in (0..found.height()).flat_map(|y| (0..found.width()).map(move |x| (x, y))) {
        let (a, b) = (found.mean(x, y), truth.mean(x, y));
        let variance = found.posterior_variance(x, y).unwrap_or_default();
        for c in (0..3).filter(|&c| variance[c] > 0.0) {
            let error = (a[c] - b[c]).abs();
            for (inside, bound) in inside.iter_mut().zip(bounds) {
                *inside += f64::from(u8::from(error <= bound * variance[c].sqrt()));
            }
            squares += error * error;
            believed += variance[c];
            count += 1.0;
        }
    }
    let [a, b, c] = inside.map(|n| n / count);
    [a, b, c, (squares / count).sqrt(), (believed / count).sqrt()]
}
