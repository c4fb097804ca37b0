//! Ambient and point lights.

use super::gathered;
use crate::renders::{self, Set, assert_image_mean, image_mean};
use octolux::scene::{Bsdf, DeltaLight, Gather, IntegratorKind};

const SEED: u64 = 8;

fn stage(kind: IntegratorKind) -> Set {
    let mut set = Set::new([0.2, 1.2, 3.0], [0.0, 0.3, 0.0], 45.0, 24).bounces(1).integrator(kind);
    let ground = set.grey(0.5, 0.0);
    let shiny = set.material(Bsdf::Phong { diffuse: [0.3, 0.2, 0.1], specular: [0.5; 3], exponent: 30.0 }, [0.0; 3]);
    set.quad(ground, [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]]);
    set.sphere(shiny, [0.0, 0.5, 0.0], 0.5);
    set.light(DeltaLight::Point { position: [-1.0, 1.5, 1.0], intensity: [1.5, 1.0, 0.5] })
        .light(DeltaLight::Directional { direction: [0.48, -0.8, -0.36], irradiance: [0.4, 0.6, 0.8] })
        .light(DeltaLight::Spot {
            position: [1.2, 1.4, 0.5],
            direction: [-0.64, -0.6, -0.48],
            intensity: [3.0, 3.0, 4.0],
            angle: 18.0,
        })
}

/// `direct` draws one light a sample, `phong` sums all; both have the shadows.
#[test]
fn phong_without_ambient_is_direct_light() {
    let phong = renders::film(&renders::world(&stage(IntegratorKind::Phong).finish(), SEED), 256);
    let direct = renders::film(&renders::world(&stage(IntegratorKind::Direct).finish(), SEED + 1), 2048);
    let expected = image_mean(&phong);
    // Its own error adds to what is allowed.
    let slack = expected.iter().map(|m| 4.5 * m.std_error).fold(0.0, f64::max);
    assert_image_mean("direct", &direct, expected.map(|m| m.mean), slack, 3);
    assert!(slack < 0.01 * expected[0].mean, "{slack}");
}

/// I/d² · ρ/π straight below a point light, plus the ambient's ρ·a; in the shadow of nothing.
#[test]
fn a_point_light_falls_off_with_the_square() {
    let ambient = [0.1, 0.2, 0.3];
    for height in [0.5, 1.0, 4.0] {
        let mut set = Set::new([0.0, 3.0, 1e-3], [0.0; 3], 1e-3, 2).integrator(IntegratorKind::Phong);
        let ground = set.grey(0.5, 0.0);
        set.quad(ground, [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]]);
        let light = DeltaLight::Point { position: [0.0, height, 0.0], intensity: [3.0, 2.0, 1.0] };
        let mut scene = set.light(light).finish();
        scene.integrator.ambient = ambient;
        let film = renders::film(&renders::world(&scene, SEED), 1);
        for (c, intensity) in [3.0, 2.0, 1.0].into_iter().enumerate() {
            let d = f64::from(height);
            let expected = 0.5 * (intensity / (d * d * std::f64::consts::PI) + f64::from(ambient[c]));
            let found = film.mean(1, 1)[c];
            assert!((found / expected - 1.0).abs() < 3e-6, "{height}, {c}: {found} for {expected}");
        }
    }
}

/// Point lights are met by no direction: gathering samples them whatever its lights are.
#[test]
fn a_gather_sees_lights_without_extent() {
    let phong = renders::film(&renders::world(&stage(IntegratorKind::Phong).finish(), SEED), 256);
    let settings = Gather { samples: 64, ..super::gather(octolux::scene::GatherMethod::BmcIs) };
    let world = renders::world(&gathered(&stage(IntegratorKind::Gather).finish(), settings), SEED + 2);
    let expected = image_mean(&phong);
    let slack = expected.iter().map(|m| 4.5 * m.std_error).fold(0.0, f64::max);
    assert_image_mean("gather", &renders::film(&world, 64), expected.map(|m| m.mean), slack, 3);
}
