//! Lamps sampled along slopes: what is made denser is made lighter by as much, exactly; and it pays.

use super::reach::low_lamp;
use super::scenes::*;
use crate::stats::Rng;
use crate::stats::quadrature::gauss_legendre;
use octolux::lane::{Bits, Mask, Real, Vec3, f32x8, f32x16};
use octolux::light::{Emitter, LightSample, Lights};
use octolux::plan::{Force, Plan};
use octolux::scene::{IntegratorKind, Scene};

const UP: V = [0.0, 0.0, 1.0];
/// Rounding of a dozen f32 operations a node.
const ROUNDING: f64 = 1e-6;

/// Over the origin's hemisphere, seen counter-clockwise from below.
const LAMP: [V; 4] = [[-0.5, -0.25, 1.0], [-0.25, 0.5, 1.125], [0.75, 0.625, 1.0], [0.5, -0.125, 0.875]];

fn halves([a, b, c, d]: [V; 4]) -> [Emitter; 2] {
    [triangle(0, [a, b, c], [1.0; 3]), triangle(1, [c, d, a], [1.0; 3])]
}

fn sloped(corners: [V; 4]) -> Lights {
    let mut lights = area_lights(&halves(corners));
    lights.add_slopes();
    lights
}

fn at(lights: &Lights, p: V, facing: V, u: [f64; 2]) -> LightSample<f32> {
    lights.sample_from(vec1(f32s(p)), Some(vec1(f32s(facing))), None, 0.5, u.map(|u| u as f32), true)
}

/// The mean over the numbers of a sample's radiance times something of it.
fn mean(lights: &Lights, p: V, facing: V, of: impl Fn(&LightSample<f32>) -> f64) -> f64 {
    let rule = gauss_legendre(24);
    let half = |x: f64| 0.5 + 0.5 * x;
    let column = |x: f64| -> f64 {
        let node = |&(y, w): &(f64, f64)| {
            let sample = at(lights, p, facing, [half(x), half(y)]);
            0.5 * w * f64::from(sample.radiance.x) * of(&sample)
        };
        rule.iter().map(node).sum()
    };
    rule.iter().map(|&(x, w)| 0.5 * w * column(x)).sum()
}

/// Receivers and their normals; of the last the horizon cuts the lamp, and one counts no cosine.
fn receivers() -> [(V, V); 6] {
    [
        ([0.0; 3], UP),
        ([0.6, 0.5, 0.5], UP),
        ([-2.0, 0.1, 0.3], unit([1.0, 0.0, 0.5])),
        ([-0.6, -0.3, 0.6], unit([0.5, 0.2, 1.0])),
        ([0.1, 0.2, 0.0], [0.0; 3]),
        ([0.1, 0.2, 0.0], [1.0, 0.0, 0.0]),
    ]
}

/// Polynomials over the lamp have the means that even samples give.
#[test]
fn what_is_denser_is_lighter_by_as_much() {
    let (even, lights) = (area_lights(&halves(LAMP)), sloped(LAMP));
    for (p, n) in receivers() {
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2)] {
            let of = |s: &LightSample<f32>| f64::from(s.target.x).powi(i) * f64::from(s.target.y).powi(j);
            let (expected, found) = (mean(&even, p, n, of), mean(&lights, p, n, of));
            assert!((found - expected).abs() < ROUNDING, "{p:?}, x^{i} y^{j}: {found} for {expected}");
        }
        let largest = mean(&lights, p, n, |s| f64::from(s.radiance.x));
        assert!(largest > 1.001, "a slope there is: {largest}");
    }
}

/// Lambert's formula for the irradiance of a polygon above the horizon, of radiance 1 (1760, Photometria).
fn lambert<const N: usize>(corners: [V; N], p: V, n: V) -> f64 {
    let to = corners.map(|c| unit(sub(c, p)));
    let edge = |i: usize| {
        let (a, b) = (to[i], to[(i + 1) % N]);
        let normal = cross(a, b);
        norm(normal).atan2(dot(a, b)) * dot(unit(normal), n)
    };
    0.5 * (0..N).map(edge).sum::<f64>().abs()
}

#[test]
fn irradiance_is_that_of_the_polygon() {
    let lights = sloped(LAMP);
    for (p, n) in &receivers()[..4] {
        let cos_over_pdf = |s: &LightSample<f32>| dot(f64s(s.wi.lane(0)), *n) / f64::from(s.pdf);
        let (found, exact) = (mean(&lights, *p, *n, cos_over_pdf), lambert(LAMP, *p, *n));
        // The lamp is a plane to within a rounding of its corners.
        assert!((found / exact - 1.0).abs() < 4.0 * ROUNDING, "{p:?}: {found} for {exact}");
    }
}

/// Variance of independent samples of the irradiance, of even samples and along slopes.
#[test]
fn near_a_lamp_it_pays() {
    let (even, lights) = (area_lights(&halves(LAMP)), sloped(LAMP));
    for (p, n, most) in [([0.6, 0.5, 0.5], UP, 0.5), ([-2.0, 0.1, 0.3], unit([1.0, 0.0, 0.5]), 0.1)] {
        let variance = |lights: &Lights| {
            let exact = lambert(LAMP, p, n);
            let squared = |s: &LightSample<f32>| {
                f64::from(s.radiance.x) * (dot(f64s(s.wi.lane(0)), n) / f64::from(s.pdf)).powi(2)
            };
            mean(lights, p, n, squared) - exact * exact
        };
        let ratio = variance(&lights) / variance(&even);
        assert!(ratio < most, "{p:?}: {ratio}");
    }
}

/// The mean over the numbers by the midpoint rule: of a triangle's samples there is a kink somewhere in their square.
fn midpoint_mean(lights: &Lights, p: V, facing: V, of: impl Fn(&LightSample<f32>) -> f64) -> f64 {
    const SIDE: usize = 500;
    let place = |i: usize| (i as f64 + 0.5) / SIDE as f64;
    let value = |i: usize| {
        let sample = at(lights, p, facing, [place(i % SIDE), place(i / SIDE)]);
        f64::from(sample.radiance.x) * of(&sample)
    };
    (0..SIDE * SIDE).map(value).sum::<f64>() / (SIDE * SIDE) as f64
}

/// A single triangle leans as the parallelogram does that stands for it: no less exactly, and it pays.
#[test]
fn single_triangles_lean_too() {
    let corners = [LAMP[0], LAMP[1], LAMP[2]];
    let of_it = || area_lights(&[triangle(0, corners, [1.0; 3])]);
    let (even, mut lights) = (of_it(), of_it());
    lights.add_slopes();
    for (p, n) in receivers() {
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2)] {
            let of = |s: &LightSample<f32>| f64::from(s.target.x).powi(i) * f64::from(s.target.y).powi(j);
            let (expected, found) = (midpoint_mean(&even, p, n, of), midpoint_mean(&lights, p, n, of));
            assert!((found - expected).abs() < 3e-5, "{p:?}, x^{i} y^{j}: {found} for {expected}");
        }
    }
    for (p, n, most) in [([0.6, 0.5, 0.5], UP, 0.75), ([-2.0, 0.1, 0.3], unit([1.0, 0.0, 0.5]), 0.5)] {
        let irradiance = |s: &LightSample<f32>| dot(f64s(s.wi.lane(0)), n) / f64::from(s.pdf);
        let exact = lambert(corners, p, n);
        let found = midpoint_mean(&lights, p, n, irradiance);
        assert!((found / exact - 1.0).abs() < 3e-5, "{p:?}: {found} for {exact}");
        let variance = |lights: &Lights| {
            midpoint_mean(lights, p, n, |s| f64::from(s.radiance.x) * irradiance(s).powi(2)) - exact * exact
        };
        let ratio = variance(&lights) / variance(&even);
        assert!(ratio < most, "{p:?}: {ratio}");
    }
}

/// Where they are many they are small, and each is sampled evenly.
#[test]
fn many_single_triangles_do_not_lean() {
    let row = |i: usize| LAMP.map(|p| [p[0] + 3.0 * i as f64, p[1], p[2]]);
    let emitters: Vec<Emitter> =
        (0..17).map(|i| triangle(i as u32, [row(i)[0], row(i)[1], row(i)[2]], [1.0; 3])).collect();
    let leans = |count: usize| {
        let mut lights = area_lights(&emitters[..count]);
        lights.add_slopes();
        at(&lights, [0.0; 3], UP, [0.25, 0.125]).radiance.x != 1.0
    };
    assert!(leans(16) && !leans(17));
}

/// On the lamp's plane, edges and corners, far away and for tiny lamps: a number between 1/9 and 9.
#[test]
fn extreme_places_and_sizes() {
    let [a, b, c, _] = LAMP;
    let mid = |p: V, q: V| [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
    let edge = sub(b, a);
    let beyond = [0, 1, 2].map(|k| a[k] - edge[k]);
    let mut rng = Rng::new(5);
    let places = [a, mid(a, b), mid(a, c), beyond, [0.0; 3], scaled(a, -1e6), scaled(a, 1e9)];
    for size in [1.0, 1e-6, 1e-18] {
        let corners = LAMP.map(|p| scaled(p, size));
        let mut single = area_lights(&halves(corners)[..1]);
        single.add_slopes();
        for (lights, from) in [sloped(corners), single].iter().flat_map(|lights| places.map(|from| (lights, from))) {
            for _ in 0..200 {
                let n = if rng.f64() < 0.2 { [0.0; 3] } else { rng.sphere() };
                let s = at(lights, scaled(from, size), n, [rng.f64(), rng.f64()].map(|u| u.min(0.999_999)));
                if s.pdf > 0.0 {
                    let stretch = f64::from(s.radiance.x);
                    assert!((1.0 / 9.1..9.1).contains(&stretch), "{stretch} from {from:?}, size {size}");
                    assert!(s.place[0] >= 0.0 && s.place[1] >= 0.0 && s.place[0] + s.place[1] < 1.0 + 1e-6);
                }
            }
        }
    }
}

fn lanes<R: Real>(lights: &Lights, p: &[V; 16], n: &[V; 16], u: &[[f32; 2]; 16], first: usize) -> Vec<[u32; 8]> {
    let vector = |v: &[V; 16]| Vec3::<R>::from_fn(|i| f32s(v[first + i]));
    let u = [0, 1].map(|k| R::from_fn(|i| u[first + i][k]));
    let s = lights.sample_from(vector(p), Some(vector(n)), None, R::splat(0.5), u, R::Mask::splat(true));
    let bits = |i: usize| {
        let ([x, y, z], radiance) = (s.target.lane(i), s.radiance.lane(i)[0]);
        let values = [x, y, z, radiance, s.pdf.lane(i), s.place[0].lane(i), s.place[1].lane(i)].map(f32::to_bits);
        std::array::from_fn(|k| if k < 7 { values[k] } else { s.primitive.lane(i) })
    };
    (0..R::WIDTH).map(bits).collect()
}

#[test]
fn same_bits_at_every_width() {
    let mut emitters = halves(LAMP).to_vec();
    let lights_of = |emitters: &[Emitter]| {
        let mut lights = area_lights(emitters);
        lights.add_slopes();
        lights
    };
    let pair = lights_of(&emitters);
    emitters.push(triangle(2, [[2.0, 0.0, 1.0], [2.0, 1.0, 1.0], [3.0, 0.0, 1.0]], [1.0; 3]));
    let beside_triangle = lights_of(&emitters);
    emitters.push(sphere(3, [-2.0, 0.0, 0.5], 0.25, [1.0; 3]));
    let mut rng = Rng::new(6);
    for lights in [pair, beside_triangle, lights_of(&emitters)] {
        for _ in 0..500 {
            let p = std::array::from_fn(|_| scaled(rng.sphere(), 0.5));
            let n = std::array::from_fn(|_| rng.sphere());
            let u = std::array::from_fn(|_| [rng.f32(), rng.f32()]);
            let one: Vec<_> = (0..16).flat_map(|i| lanes::<f32>(&lights, &p, &n, &u, i)).collect();
            let eight: Vec<_> = [0, 8].into_iter().flat_map(|i| lanes::<f32x8>(&lights, &p, &n, &u, i)).collect();
            assert_eq!(one, eight);
            assert_eq!(one, lanes::<f32x16>(&lights, &p, &n, &u, 0));
        }
    }
}

#[test]
fn where_the_plan_keeps_it() {
    let kept = |scene: &Scene| Plan::new(scene, Force::default(), false).sloped_lamps;
    let scene = low_lamp(IntegratorKind::Path, 2);
    assert!(kept(&scene) && Plan::new(&scene, Force { general: true, geometry: None }, false).sloped_lamps);
    assert!(!kept(&low_lamp(IntegratorKind::Path, 1)) && !kept(&low_lamp(IntegratorKind::Direct, 7)));
    assert!(!kept(&low_lamp(IntegratorKind::Gather, 2)));
}
