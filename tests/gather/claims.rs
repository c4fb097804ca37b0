//! A report says what a method is worth.

use super::{fresh, gather, gathered, sphere_scene};
use octolux::estimate::bmc::Points;
use octolux::scene::{Gather, GatherLights, GatherMethod, GatherWeights};

#[test]
fn bias_is_said() {
    let note = |settings| gathered(&sphere_scene(4, false).finish(), settings).integrator.note();
    let per_hit = fresh(GatherMethod::McIs, Points::Random, GatherLights::Seen, 8);
    assert_eq!(note(per_hit), None);
    assert!(note(gather(GatherMethod::McIs)).is_some_and(|n| n.contains("sets")));
    assert!(note(gather(GatherMethod::BmcIs)).is_some_and(|n| n.contains("biased")));
    let at_each_hit = Gather { weights: GatherWeights::PerHit, ..gather(GatherMethod::Bmc) };
    assert!(note(at_each_hit).is_some_and(|n| n.contains("biased")));
    assert_eq!(sphere_scene(4, false).finish().integrator.note(), None);
}
