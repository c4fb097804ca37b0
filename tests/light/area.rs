//! Triangles, and triangles beside spheres and an environment: density, geometry, what is left out.

use super::TESTS;
use super::scenes::*;
use crate::stats::{Chi2Sphere, Rng};
use octolux::light::{Emitter, Lights, NO_PRIMITIVE, triangle_pdf};
use octolux::scene::Environment;

const WHITE: [f32; 3] = [1.0; 3];

fn facing() -> Emitter {
    triangle(0, [[-0.6, -0.4, 1.0], [0.1, 0.7, 1.1], [0.8, -0.5, 0.9]], WHITE)
}
fn oblique() -> Emitter {
    triangle(0, [[0.5, -1.0, 0.2], [0.4, 0.9, 1.4], [1.2, 0.1, 0.6]], WHITE)
}
/// Seen from the origin almost edge-on.
fn grazing() -> Emitter {
    triangle(0, [[-1.0, 0.3, 0.05], [1.0, 0.3, 0.05], [0.0, 1.5, 0.02]], WHITE)
}

fn chi2(name: &str, emitters: &[Emitter], environment: Option<&Environment>) {
    let lights = Lights::build(emitters.to_vec(), environment).unwrap();
    let origin = [0.0; 3];
    let outcome = Chi2Sphere::new(name).tests(TESTS).cells(32, 64).outcome(
        |rng| {
            let sample = draw(&lights, origin, rng);
            (sample.pdf > 0.0).then(|| f64s(sample.wi.lane(0)))
        },
        |d| stated_pdf(&lights, emitters, origin, d),
    );
    assert!(outcome.failure.is_none(), "{}", outcome.failure.unwrap());
    assert_eq!(outcome.rejected, 0, "{name}: every light here faces the origin");
    let off = (outcome.pdf_total - 1.0).abs();
    assert!(off <= outcome.pdf_error + 1e-5, "{name}: ∫pdf = {}", outcome.pdf_total);
}

#[test]
fn triangles_follow_their_density() {
    for (name, light) in [("facing", facing()), ("oblique", oblique()), ("grazing", grazing())] {
        let d = f64s(mid(&light));
        let flipped = if hit(&light, [0.0; 3], unit(d)).is_none() { flip(&light) } else { light };
        chi2(name, &[flipped], None);
    }
}

#[test]
fn mixtures_follow_their_density() {
    let mut emitters = vec![facing(), flip_to_origin(Emitter { primitive: 7, radiance: [9.0, 0.1, 0.0], ..oblique() })];
    emitters[0] = flip_to_origin(emitters[0]);
    chi2("two triangles", &emitters, None);
    emitters.push(sphere(10, [-1.5, 0.5, -0.3], 0.4, [2.0; 3]));
    emitters.push(sphere(12, [0.0, -2.0, -2.0], 1.0, [0.2, 0.2, 0.4]));
    chi2("triangles and spheres", &emitters, None);
    chi2("spheres", &emitters[2..], None);
    chi2("triangles, spheres, constant", &emitters, Some(&Environment::Constant([0.1; 3])));
    chi2("triangles, spheres, image", &emitters, Some(&Environment::Image(noise(7, 4, 0.1, 4.0, 3))));
}

fn mid(light: &Emitter) -> [f32; 3] {
    let octolux::light::EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
    std::array::from_fn(|k| p0[k] + (e1[k] + e2[k]) / 3.0)
}

fn flip(light: &Emitter) -> Emitter {
    let octolux::light::EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
    Emitter { shape: octolux::light::EmitterShape::Triangle { p0, e1: e2, e2: e1 }, ..*light }
}

fn flip_to_origin(light: Emitter) -> Emitter {
    if hit(&light, [0.0; 3], unit(f64s(mid(&light)))).is_none() { flip(&light) } else { light }
}

/// The sample's density is the one stated for its own distance and cosine. In f32 the cosine is off by a few units of
/// 2⁻²⁴ absolutely (wi and ng are unit vectors of rounded components), so the pdf by that over the cosine.
#[test]
fn sample_and_pdf_agree() {
    let emitters = [facing(), oblique(), grazing()].map(flip_to_origin);
    let mut rng = Rng::new(5);
    for light in emitters {
        let lights = area_lights(&[light]);
        let row = lights.emitter_pdf_row(0);
        for _ in 0..20_000 {
            let p = f32s(scaled(rng.sphere(), 0.01));
            let sample = draw(&lights, p, &mut rng);
            if sample.pdf == 0.0 {
                continue;
            }
            let d = f64s(sample.wi.lane(0));
            let cos = -dot(d, f64s(sample.ng.lane(0)));
            let t = norm(sub(f64s(sample.target.lane(0)), f64s(p)));
            let exact = f64::from(row) * t * t / cos;
            let bound = exact * f64::powi(2.0, -24) * (8.0 + 4.0 / cos);
            assert!((f64::from(sample.pdf) - exact).abs() <= bound, "{} for {exact}, cos {cos}", sample.pdf);
            let looked_up = lights.pdf_area::<f32>(bits(0), vec1(p), t as f32, cos as f32);
            assert_eq!(looked_up, triangle_pdf(row, t as f32, cos as f32));
            assert!((f64::from(looked_up) - exact).abs() <= exact * 6.0 * f64::powi(2.0, -24));
        }
    }
}

/// The point lies on the plane to within the error it claims, and where wi and distance lead.
#[test]
fn targets_lie_on_the_triangle() {
    let mut rng = Rng::new(6);
    for offset in [0.0, 1.0, 1.9] {
        for size in [1.0, 1e-3, 1e-5] {
            let base = [offset, -offset, 0.7];
            let corner = |rng: &mut Rng| std::array::from_fn(|k| base[k] + size * rng.range(-1.0, 1.0));
            for _ in 0..100 {
                let light = triangle(0, [corner(&mut rng), corner(&mut rng), corner(&mut rng)], WHITE);
                let octolux::light::EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
                let lights = area_lights(&[light]);
                let n = unit(cross(f64s(e1), f64s(e2)));
                for _ in 0..20 {
                    let sample = draw(&lights, [0.1, 0.2, -0.9], &mut rng);
                    let target = f64s(sample.target.lane(0));
                    let off = dot(sub(target, f64s(p0)), n).abs();
                    let bound: f64 = f64s(sample.target_error.lane(0)).iter().zip(n).map(|(e, n)| e * n.abs()).sum();
                    assert!(off <= bound, "{off} off the plane, claimed {bound}");
                    let d = f64s(sample.wi.lane(0));
                    let reached = sub(target, [0.1f32, 0.2, -0.9].map(f64::from));
                    let gap = norm(sub(reached, scaled(d, f64::from(sample.distance))));
                    assert!(gap <= 8.0 * f64::powi(2.0, -24) * norm(reached), "gap {gap}");
                }
            }
        }
    }
}

#[test]
fn the_back_is_dark() {
    let lights = area_lights(&[flip(&flip_to_origin(facing()))]);
    let mut rng = Rng::new(7);
    for _ in 0..1000 {
        let sample = draw(&lights, [0.0; 3], &mut rng);
        assert_eq!((sample.pdf, sample.radiance.lane(0), sample.primitive), (0.0, [0.0; 3], bits(NO_PRIMITIVE)));
    }
    assert_eq!(triangle_pdf(1.0f32, 1.0, -0.5), 0.0);
    assert_eq!(triangle_pdf(1.0f32, 1.0, 0.0), 0.0);
    assert_eq!(triangle_pdf(1e30f32, 1e10, 1e-3), 0.0, "overflow is left to the other technique");
}

#[test]
fn what_cannot_emit_is_not_there() {
    let line = triangle(0, [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]], WHITE);
    let point = triangle(1, [[0.5; 3]; 3], WHITE);
    let black = Emitter { primitive: 2, radiance: [0.0; 3], ..facing() };
    let dark = area_lights(&[line, point, black]);
    assert!(dark.is_empty() && dark.memory() == 0);
    assert_eq!(draw(&dark, [0.0; 3], &mut Rng::new(1)).pdf, 0.0);
    assert_eq!(dark.environment(vec1([0.0, 1.0, 0.0])).1, 0.0);

    let lit = area_lights(&[line, point, black, Emitter { primitive: 3, ..flip_to_origin(facing()) }]);
    assert_eq!(lit.area_count(), 1);
    assert_eq!([0, 1, 2].map(|p| lit.emitter_pdf_row(p)), [0.0; 3]);
    assert_eq!(draw(&lit, [0.0; 3], &mut Rng::new(1)).primitive, bits(3));
    // A black environment takes no share from the area lights.
    let black_sky = Environment::Image(image(4, 2, |_, _| [0.0; 3]));
    let under = Lights::build(vec![flip_to_origin(facing())], Some(&black_sky)).unwrap();
    assert_eq!(under.emitter_pdf_row(0), area_lights(&[flip_to_origin(facing())]).emitter_pdf_row(0));
    assert!(under.environment_map().is_none());
}
