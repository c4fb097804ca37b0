//! Methods without bias against the path estimator, over independent seeds.

use super::{fresh, gather, gathered, sphere_scene};
use crate::equivalence::scenes;
use crate::renders::{self, image_mean};
use crate::stats::{Moments, z_bound};
use octolux::estimate::bmc::Points;
use octolux::scene::{Gather, GatherLights, GatherMethod, IntegratorKind, Scene};

const SEEDS: u64 = 16;
const TESTS: usize = 3 * 18;

/// Moments over seeds of the image mean, by channel: what point sets of one seed share is in the spread.
pub fn over_seeds(scene: &Scene, samples: u64) -> [Moments; 3] {
    let mut moments = [Moments::new(), Moments::new(), Moments::new()];
    for seed in 0..SEEDS {
        let film = renders::film(&renders::world(scene, 1000 + seed), samples);
        moments.iter_mut().zip(image_mean(&film)).for_each(|(m, mean)| m.push(mean.mean));
    }
    moments
}

#[track_caller]
pub fn agrees(name: &str, scene: &Scene, path: &[Moments; 3], samples: u64) {
    for (c, (found, expected)) in over_seeds(scene, samples).iter().zip(path).enumerate() {
        let error = found.std_error().hypot(expected.std_error());
        let off = found.mean - expected.mean;
        println!("{name}, channel {c}: {:.6} for {:.6} ± {error:.1e}", found.mean, expected.mean);
        // 15 degrees of freedom, not a normal's: the bound is widened by their ratio at this level.
        let bound = crate::stats::t_bound(TESTS, (SEEDS - 1) as f64).max(z_bound(TESTS));
        assert!(off.abs() <= bound * error, "{name}, channel {c}: off by {:.2} standard errors", off / error);
        // A bias of a twentieth would be seen.
        assert!(bound * error < 0.05 * expected.mean, "{name}: {error:e} is too coarse");
    }
}

#[test]
fn one_bounce_is_direct_light() {
    let mut direct = sphere_scene(24, true).finish();
    direct.integrator.kind = IntegratorKind::Direct;
    let expected = over_seeds(&direct, 64);
    use GatherLights::{Sampled, Seen};
    use GatherMethod::{Mc, McIs};
    for (name, settings) in [
        ("mc", fresh(Mc, Points::Random, Seen, 16)),
        ("mc, owen", fresh(Mc, Points::Owen, Seen, 16)),
        ("mc-is", fresh(McIs, Points::Random, Seen, 16)),
        ("mc-is, owen", fresh(McIs, Points::Owen, Seen, 16)),
        ("mc-is, fibonacci", fresh(McIs, Points::Fibonacci, Seen, 16)),
        ("mc-is, lights sampled", fresh(McIs, Points::Random, Sampled, 16)),
        ("mc-is, shared sets", Gather { samples: 16, ..gather(McIs) }),
    ] {
        agrees(name, &gathered(&direct, settings), &expected, 4);
    }
}

/// Everything the kernel has: glass, mirrors, coats, two kinds of lights. The sky's and the lamp's light is sampled, so
/// that directions need not find them.
#[test]
fn many_bounces_are_paths() {
    let mut everything = scenes::everything();
    everything.integrator.max_bounces = 4;
    let expected = over_seeds(&everything, 256);
    let sampled = |samples| fresh(GatherMethod::McIs, Points::Owen, GatherLights::Sampled, samples);
    agrees("everything, sampled", &gathered(&everything, sampled(8)), &expected, 32);
    let mut stage = scenes::stage_lights(true);
    stage.integrator.max_bounces = 3;
    let expected = over_seeds(&stage, 256);
    agrees("stage, sampled", &gathered(&stage, sampled(8)), &expected, 32);
    let seen = fresh(GatherMethod::McIs, Points::Owen, GatherLights::Seen, 16);
    agrees("stage, seen", &gathered(&stage, seen), &expected, 32);
}
