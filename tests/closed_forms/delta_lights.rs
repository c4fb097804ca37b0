//! Lights without extent in whole renders: cosines, inverse squares, cones, hard shadows; materials under one direction of
//! light show their BSDF itself.

use super::TESTS;
use crate::oracle::{bsdf_eval, fresnel_dielectric};
use crate::renders::{self, Set, assert_image_mean};
use crate::stats;
use octolux::film::Film;
use octolux::scene::{Bsdf, ConductorFresnel, DeltaLight, Masking};
use std::f64::consts::{FRAC_1_PI, PI};

/// Roundings of 2⁻²⁴ in a direct-light path, all to one side.
const ROUNDING: f64 = 64.0 / 16_777_216.0;

fn film(set: Set, samples: u64) -> Film {
    renders::film(&renders::world(&set.finish(), 41), samples)
}

/// A floor about the origin, normal +z, seen from so near that the view is a point.
fn floor(bsdf: Bsdf, from: [f64; 3]) -> Set {
    let mut set = Set::new(from, [0.0; 3], 1e-4, 4).bounces(1);
    let material = set.material(bsdf, [0.0; 3]);
    set.quad(material, [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    set
}

const WHITE: Bsdf = Bsdf::Diffuse { reflectance: [1.0; 3] };

fn point(position: [f32; 3], intensity: f32) -> DeltaLight {
    DeltaLight::Point { position, intensity: [intensity; 3] }
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

#[test]
fn inverse_square_and_cosine() {
    let Some(case) = stats::oracle("B.point_I1_d1") else { return };
    let straight = floor(WHITE, [0.5, 0.2, 0.8]).light(point([0.0, 0.0, 1.0], 1.0));
    assert_image_mean("B.point_I1_d1", &film(straight, 2), [case.value * FRAC_1_PI; 3], ROUNDING, TESTS);
    for (x, z, intensity) in [(1.0, 1.0, 2.0), (-3.0, 0.25, 40.0), (0.0, 0.01, 1e-3)] {
        let set = floor(WHITE, [0.5, 0.2, 0.8]).light(point([x, 0.5, z], intensity));
        let (x, z, intensity) = (f64::from(x), f64::from(z), f64::from(intensity));
        let d2 = x * x + 0.25 + z * z;
        let expected = FRAC_1_PI * intensity * z / (d2 * d2.sqrt());
        // The pixel covers 1e-6 of the floor, to both sides alike.
        assert_image_mean("point light", &film(set, 16), [expected; 3], expected * (ROUNDING + 1e-5), TESTS);
    }
}

#[test]
fn directional_light_is_the_same_everywhere() {
    let direction = unit([0.3, -0.4, -0.6]).map(|x| x as f32);
    let set = floor(WHITE, [0.5, 0.2, 0.8]).light(DeltaLight::Directional { direction, irradiance: [3.0, 2.0, 1.0] });
    let cos = -f64::from(direction[2]);
    let expected = [3.0, 2.0, 1.0].map(|e| e * cos * FRAC_1_PI);
    assert_image_mean("directional light", &film(set, 2), expected, 3.0 * ROUNDING, TESTS);
}

/// A cone straight down lights a disk of radius h tan θ; the film sees a square of known size.
#[test]
fn a_spot_lights_a_disk() {
    for angle in [5.0f32, 20.0, 35.0] {
        // The view from height 1 reaches ±1: 4 of area.
        let mut set = Set::new([0.0, 0.0, 1.0], [0.0; 3], 90.0, 32).bounces(1);
        let floor = set.grey(1.0, 0.0);
        set.quad(floor, [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]]);
        let height = 1.2f64;
        let set = set.light(DeltaLight::Spot {
            position: [0.0, 0.0, height as f32],
            direction: [0.0, 0.0, -1.0],
            intensity: [PI as f32; 3],
            angle,
        });
        // ∫ h/(h² + r²)^{3/2} over the disk = 2π (1 − cos θ).
        let expected = 2.0 * PI * (1.0 - f64::from(angle).to_radians().cos()) / 4.0;
        assert_image_mean(&format!("spot of {angle}"), &film(set, 256), [expected; 3], 1e-5 * expected, TESTS);
    }
}

#[test]
fn shadows_are_black_and_mirrors_see_nothing() {
    let mut shadowed = floor(WHITE, [0.5, 0.2, 0.8]).light(point([0.0, 0.0, 2.0], 9.0));
    let grey = shadowed.grey(0.5, 0.0);
    shadowed.sphere(grey, [0.0, 0.0, 1.0], 0.1);
    let fresnel = ConductorFresnel::Constant { reflectance: [1.0; 3] };
    let mirror = Bsdf::Conductor { alpha: 0.0, masking: Masking::Correlated, fresnel };
    let mirrored = floor(mirror, [0.0, 0.0, 1.0]).light(point([0.0, 0.0, 2.0], 9.0));
    let behind = floor(WHITE, [0.5, 0.2, 0.8]).light(point([0.0, 0.0, -1.0], 9.0));
    for set in [shadowed, mirrored, behind] {
        let film = film(set, 8);
        assert!((0..4).all(|x| film.mean(x, 2) == [0.0; 3]));
    }
}

/// One direction of light: radiance is E f cosθ, without noise. The smooth coat's base is lit although its coat is a delta.
#[test]
fn materials_show_their_bsdf() {
    let coat = |alpha| Bsdf::Coated { reflectance: [0.5, 0.2, 0.1], alpha, masking: Masking::Correlated, ior: 1.5 };
    let materials = [
        Bsdf::Phong { diffuse: [0.2, 0.1, 0.3], specular: [0.5, 0.6, 0.7], exponent: 25.0 },
        Bsdf::Phong { diffuse: [0.0; 3], specular: [1.0; 3], exponent: 1.0 },
        coat(0.3),
        coat(0.0),
    ];
    for bsdf in materials {
        for to_light in [unit([-0.5, -0.1, 0.7]), unit([0.4, 0.8, 0.2])] {
            let view = [0.5, 0.2, 0.8];
            let direction = to_light.map(|x| -x as f32);
            let set = floor(bsdf, view).light(DeltaLight::Directional { direction, irradiance: [2.0; 3] });
            let expected = bsdf_eval(&bsdf, unit(view), to_light).map(|f| 2.0 * f);
            // The view is a cone of 1e-4 degrees, and lobes of n = 25 or α = .3 turn by a few per cent a degree.
            let tolerance = expected.iter().fold(0.0f64, |a, &b| a.max(b)) * (1e-5 + ROUNDING);
            assert_image_mean(&format!("{bsdf:?}"), &film(set, 16), expected, tolerance, TESTS);
        }
    }
}

/// Base and coat together in a white sky: delta samples find the sky for the coat, the others for the base.
#[test]
fn a_smooth_coat_in_a_furnace() {
    let bsdf = Bsdf::Coated { reflectance: [1.0, 0.5, 0.0], alpha: 0.0, masking: Masking::Correlated, ior: 1.5 };
    for mu in [1.0f64, 0.5, 0.1] {
        let set = floor(bsdf, [(1.0 - mu * mu).sqrt(), 0.0, mu]).uniform_light();
        let f = fresnel_dielectric(mu, 1.5);
        // ∫ (1 − F(wi)) cosθ/π dω, by its own quadrature.
        let rule = stats::quadrature::gauss_legendre(16);
        let enters = stats::quadrature::integrate(&rule, 0.0, 1.0, 8, |z| 2.0 * z * (1.0 - fresnel_dielectric(z, 1.5)));
        let expected = [1.0, 0.5, 0.0].map(|rho| f + (1.0 - f) * enters * rho);
        assert_image_mean(&format!("smooth coat, cosine {mu}"), &film(set, 16_384), expected, 1e-5, TESTS);
    }
}
