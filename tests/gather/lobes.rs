//! Directions about the mirror direction.

use super::agreement::{agrees, over_seeds};
use super::ranking::rmse;
use super::{fresh, gather, gathered, smooth_sky};
use crate::renders::{self, Set};
use octolux::estimate::bmc::{Covariance, Measure, Points};
use octolux::scene::{
    Bsdf, ConductorFresnel, Gather, GatherCovariance, GatherLights, GatherMethod, GatherPdf, IntegratorKind, Masking,
    Scene,
};

const PHONG: Bsdf = Bsdf::Phong { diffuse: [0.4, 0.3, 0.2], specular: [0.5; 3], exponent: 40.0 };

fn metal(alpha: f32) -> Bsdf {
    let fresnel = ConductorFresnel::Schlick { f0: [0.9, 0.7, 0.4] };
    Bsdf::Conductor { alpha, masking: Masking::Correlated, fresnel }
}

fn coat(alpha: f32) -> Bsdf {
    Bsdf::Coated { reflectance: [0.5, 0.3, 0.1], alpha, masking: Masking::Correlated, ior: 1.5 }
}

/// A plane under the smooth sky, seen at 35° to it.
fn plane(bsdf: Bsdf) -> Scene {
    let mut set = Set::new([1.2, 1.0, 1.6], [0.2, 0.0, 0.6], 12.0, 24).bounces(1).environment(smooth_sky());
    let ground = set.material(bsdf, [0.0; 3]);
    set.quad(ground, [[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0], [-6.0, 0.0, -6.0]]);
    set.finish()
}

/// Whatever p is, g = f·cosθ·L/p makes up for it: directions of the lobes by equal weights are unbiased, above and below
/// the plane, for Phong lobes that are Phong's and those that a broader one stands in for, and for metals.
#[test]
fn lobes_are_sampled_without_bias() {
    let mut set = Set::new([0.0, 1.6, 5.0], [0.0, 0.75, 0.0], 36.0, 24).bounces(1).environment(smooth_sky());
    let ground = set.material(PHONG, [0.0; 3]);
    let narrow = set.material(Bsdf::Phong { diffuse: [0.0; 3], specular: [0.8; 3], exponent: 1000.0 }, [0.0; 3]);
    let rough = set.material(metal(0.4), [0.0; 3]);
    let gold = set.material(metal(0.05), [0.0; 3]);
    set.quad(ground, [[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0], [-6.0, 0.0, -6.0]]);
    let lacquer = set.material(coat(0.1), [0.0; 3]);
    for (material, x, radius) in [(narrow, -1.2, 0.5), (rough, 0.0, 0.8), (gold, 1.3, 0.6), (lacquer, 2.4, 0.45)] {
        set.sphere(material, [x, radius, 0.0], radius);
    }
    let mut direct = set.finish();
    direct.integrator.kind = IntegratorKind::Direct;
    let expected = over_seeds(&direct, 256);
    for (name, points) in [("random", Points::Random), ("owen", Points::Owen), ("fibonacci", Points::Fibonacci)] {
        let settings = Gather { pdf: GatherPdf::Lobe, ..fresh(GatherMethod::McIs, points, GatherLights::Seen, 16) };
        agrees(&format!("lobes, {name}"), &gathered(&direct, settings), &expected, 8);
    }
    let shared = Gather { pdf: GatherPdf::Lobe, samples: 16, ..gather(GatherMethod::McIs) };
    agrees("lobes, shared sets", &gathered(&direct, shared), &expected, 8);
}

/// RMSE at 40 directions (and 40 more about the normal where there is a base).
fn error(scene: &Scene, method: GatherMethod, pdf: GatherPdf, covariance: Covariance) -> f64 {
    let mut direct = scene.clone();
    direct.integrator.kind = IntegratorKind::Direct;
    let reference = renders::film(&renders::world(&direct, 99), 4096);
    let settings = Gather { pdf, covariance: GatherCovariance::Given(covariance), ..gather(method) };
    rmse(&renders::film(&renders::world(&gathered(scene, settings), 3), 1), &reference)
}

/// A cosine set meets a lobe of a dozen degrees with one direction in ten; a set of its own has all of them there, and the
/// weights gain on equal ones as they do for Lambert.
#[test]
fn a_set_of_its_own_serves_a_lobe() {
    for (name, bsdf) in [("phong", PHONG), ("metal", metal(0.2)), ("coat", coat(0.2))] {
        let scene = plane(bsdf);
        use GatherMethod::{BmcIs, McIs};
        let cosine = error(&scene, BmcIs, GatherPdf::Cosine, Covariance::SOBOLEV);
        let [equal, sobolev] = [McIs, BmcIs].map(|method| error(&scene, method, GatherPdf::Lobe, Covariance::SOBOLEV));
        let smooth = error(&scene, BmcIs, GatherPdf::Lobe, Covariance::SquaredExponential { length: 0.5 });
        println!(
            "{name}: bmc-is about the normal {cosine:.5}; lobe: mc-is {equal:.5}, bmc-is {sobolev:.5}, se {smooth:.5}"
        );
        assert!(sobolev < equal && equal < cosine, "{name}: {cosine} {equal} {sobolev}");
    }
}

/// One family for each lobe, with p as the material has it.
#[test]
fn lobes_are_reported() {
    let lobe = Gather { pdf: GatherPdf::Lobe, ..gather(GatherMethod::BmcIs) };
    let report = |bsdf| renders::world(&gathered(&plane(bsdf), lobe), 0).setup.gather.expect("a report");
    assert_eq!(report(PHONG).lobes, [Measure::PowerCosine { exponent: 40.0 }]);
    assert_eq!(report(PHONG).sets, 32);
    assert_eq!(report(metal(0.5)).lobes, [Measure::Microfacet { kappa: 2.0 }]);
    assert_eq!(report(coat(0.5)).lobes, [Measure::Microfacet { kappa: 2.0 }]);
    assert_eq!(report(coat(0.0)).lobes, []);
    assert_eq!(report(Bsdf::Diffuse { reflectance: [0.5; 3] }).lobes, []);
}
