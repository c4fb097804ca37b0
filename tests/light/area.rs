//! Triangles, and triangles beside spheres and an environment: density, geometry, what is left out.

use super::TESTS;
use super::scenes::*;
use crate::stats::quadrature::gauss_legendre;
use crate::stats::{Chi2Sphere, Rng, chi2_test, sidak_alpha};
use octolux::light::{Emitter, EmitterShape, Lights, NO_PRIMITIVE, triangle_pdf};
use octolux::sampling::ONE_BELOW;
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

/// Directions of the whole sphere against the sum of all densities along them. The borders of the lights are jumps, which
/// make the quadrature dear: few samples.
fn chi2(name: &str, emitters: &[Emitter], environment: Option<&Environment>) {
    let lights = Lights::build(emitters.to_vec(), environment).unwrap();
    let origin = [0.0; 3];
    let outcome = Chi2Sphere::new(name).tests(TESTS).samples(20_000).outcome(
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

/// Cells in the triangle's own coordinates, N by N in (b₂, b₁/(1 − b₂)): in them the density is smooth.
#[test]
fn triangles_follow_their_density() {
    const N: usize = 16;
    let rule = gauss_legendre(8);
    for (name, light) in [("facing", facing()), ("oblique", oblique()), ("grazing", grazing())] {
        let light = flip_to_origin(light);
        let EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
        let [p0, e1, e2] = [p0, e1, e2].map(f64s);
        let lights = area_lights(&[light]);
        let n = cross(e1, e2);
        // The stated density's mass at (s, t) of the cells' unit square, per unit of it.
        let mass = |s: f64, t: f64| {
            let (b1, b2) = (t * (1.0 - s), s);
            let point: V = std::array::from_fn(|k| p0[k] + b1 * e1[k] + b2 * e2[k]);
            let cos = -dot(unit(point), unit(n));
            let pdf = lights.pdf_area::<f32>(bits(0), vec1([0.0; 3]), norm(point) as f32, cos as f32);
            f64::from(pdf) * cos / dot(point, point) * norm(n) * (1.0 - s)
        };
        let step = 1.0 / N as f64;
        let cell = |i: usize| {
            let at = |k: usize, x: f64| (k as f64 + 0.5 + 0.5 * x) * step;
            let line = |&(y, wy): &(f64, f64)| {
                rule.iter().map(|&(x, wx)| 0.25 * step * step * wx * wy * mass(at(i / N, x), at(i % N, y))).sum::<f64>()
            };
            rule.iter().map(line).sum::<f64>()
        };
        let share: Vec<f64> = (0..N * N).map(cell).collect();
        let total: f64 = share.iter().sum();
        assert!((total - 1.0).abs() < 1e-6, "{name}: ∫pdf = {total}");

        let draws = 200_000;
        let mut observed = vec![0u64; N * N];
        let mut rng = Rng::new(2);
        for _ in 0..draws {
            let d = f64s(draw(&lights, [0.0; 3], &mut rng).wi.lane(0));
            let q = sub(scaled(d, dot(p0, n) / dot(d, n)), p0);
            let (b1, b2) = (dot(cross(q, e2), n) / dot(n, n), dot(cross(e1, q), n) / dot(n, n));
            let index = |x: f64| ((x * N as f64) as usize).min(N - 1);
            observed[index(b2) * N + index(b1 / (1.0 - b2))] += 1;
        }
        let expected: Vec<f64> = share.iter().map(|p| p * f64::from(draws)).collect();
        let outcome = chi2_test(&observed, &expected);
        assert!(outcome.p_value > sidak_alpha(TESTS), "{name}: {outcome:?}");
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
    let EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
    std::array::from_fn(|k| p0[k] + (e1[k] + e2[k]) / 3.0)
}

fn flip(light: &Emitter) -> Emitter {
    let EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
    Emitter { shape: EmitterShape::Triangle { p0, e1: e2, e2: e1 }, ..*light }
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
                let EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
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

/// A lamp of two triangles is sampled as the parallelogram it is: nets of 2¹² points, shifted at random, integrate a smooth
/// function over it with a tenth of the error that independent points have.
#[test]
fn a_net_falls_evenly_on_a_lamp_of_two_triangles() {
    let corners = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]];
    let halves = [[0, 2, 1], [0, 3, 2]].map(|half| half.map(|i| corners[i]));
    let lights = area_lights(&[triangle(0, halves[0], WHITE), triangle(1, halves[1], WHITE)]);
    let n = 1u32 << 12;
    let mut rng = Rng::new(16);
    let mut squared_error = || {
        let shift = [rng.f64(), rng.f64()];
        let f = |i: u32| {
            let net = [f64::from(i) / f64::from(n), f64::from(i.reverse_bits()) * f64::powi(2.0, -32)];
            let u = [0, 1].map(|k| (net[k] + shift[k]).fract() as f32);
            let target = lights.sample(vec1([0.5, 0.5, 0.0]), 0.5, u.map(|u| u.min(ONE_BELOW)), true).target;
            f64::from(target.x * target.x + target.y)
        };
        ((0..n).map(f).sum::<f64>() / f64::from(n) - 5.0 / 6.0).powi(2)
    };
    let mean_square = (0..16).map(|_| squared_error()).sum::<f64>() / 16.0;
    let of_independent = (4.0 / 45.0 + 1.0 / 12.0) / f64::from(n);
    assert!(mean_square < 0.01 * of_independent, "{mean_square:e} of {of_independent:e}");
}
