//! Two triangles of a parallelogram as one lamp: one affine map of the square, each triangle's own density.

use super::TESTS;
use super::scenes::*;
use crate::stats::quadrature::gauss_legendre;
use crate::stats::{Rng, chi2_test, sidak_alpha};
use octolux::light::{Emitter, EmitterShape, LightSample, Lights, Receivers};

const WHITE: [f32; 3] = [1.0; 3];
const ULP: f64 = 5.960_464_477_539_063e-8; // 2⁻²⁴

/// A parallelogram, corners in order, seen counter-clockwise from the origin.
const CORNERS: [V; 4] = [[-0.5, -0.25, 1.0], [-0.25, 0.5, 1.125], [0.75, 0.625, 1.0], [0.5, -0.125, 0.875]];

/// Its halves, the vertices of each begun anywhere.
fn pair(corners: [V; 4], [i, j]: [usize; 2], radiance: [[f32; 3]; 2]) -> [Emitter; 2] {
    let half = |p: [V; 3], from: usize| [0, 1, 2].map(|k| p[(from + k) % 3]);
    let [a, b, c, d] = corners;
    [triangle(0, half([a, b, c], i), radiance[0]), triangle(1, half([a, c, d], j), radiance[1])]
}

fn turns() -> impl Iterator<Item = [usize; 2]> {
    (0..9).map(|k| [k / 3, k % 3])
}

fn at(lights: &Lights, u: [f64; 2]) -> LightSample<f32> {
    lights.sample(vec1([0.0; 3]), 0.5, u.map(|u| u as f32), true)
}

/// Do the numbers list the triangles one after the other? (Of a pair, this one is in the first triangle's half.)
fn apart(lights: &Lights) -> bool {
    at(lights, [0.75, 0.125]).primitive == bits(1)
}

#[test]
fn the_square_is_mapped_by_one_affine_map() {
    for turn in turns() {
        let emitters = pair(CORNERS, turn, [WHITE; 2]);
        let lights = area_lights(&emitters);
        assert!(!apart(&lights), "{turn:?}");
        let target = |u| f64s(at(&lights, u).target.lane(0));
        let origin = target([0.0, 0.0]);
        let [x, y] = [[0.5, 0.0], [0.0, 0.5]].map(|u| scaled(sub(target(u), origin), 2.0));
        // The square's corners are those of the parallelogram: its area, and the diagonal's ends opposite.
        let area = |a: V, b: V| norm(cross(a, b));
        let own = area(sub(CORNERS[1], CORNERS[0]), sub(CORNERS[3], CORNERS[0]));
        assert!((area(x, y) - own).abs() < 16.0 * ULP, "{turn:?}");
        assert!(norm(sub(origin, CORNERS[1])) < 4.0 * ULP, "{turn:?}");
        let mut rng = Rng::new(3);
        for _ in 0..2000 {
            let u = [rng.f32(), rng.f32()].map(f64::from);
            let sample = at(&lights, u);
            let expected: V = std::array::from_fn(|k| origin[k] + u[0] * x[k] + u[1] * y[k]);
            let found = f64s(sample.target.lane(0));
            assert!(norm(sub(found, expected)) < 8.0 * ULP, "{turn:?}: {found:?} at {u:?}, not {expected:?}");
            let named = &emitters[sample.primitive.0 as usize];
            let EmitterShape::Triangle { p0, e1, e2 } = named.shape else { unreachable!() };
            let [b1, b2] = sample.place.map(f64::from);
            assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 + 2.0 * ULP, "{b1} {b2}");
            let placed: V = std::array::from_fn(|k| f64s(p0)[k] + b1 * f64s(e1)[k] + b2 * f64s(e2)[k]);
            assert!(norm(sub(placed, found)) < 4.0 * ULP, "{turn:?}: place and point agree");
        }
    }
}

/// Also where the halves are not quite alike: each keeps the density of its own area. Cells N by N in each triangle's (b₂,
/// b₁/(1 − b₂)), their masses by quadrature of the stated density.
#[test]
fn points_follow_the_density() {
    const N: usize = 8;
    const DRAWS: usize = 200_000;
    let rule = gauss_legendre(8);
    let mut uneven = CORNERS;
    uneven[3][0] += 2e-4;
    uneven[3][2] -= 1e-4;
    for (name, corners) in [("even", CORNERS), ("uneven", uneven)] {
        let emitters = pair(corners, [1, 0], [WHITE; 2]);
        let lights = area_lights(&emitters);
        assert!(!apart(&lights));
        let mass = |light: &Emitter, s: f64, t: f64| {
            let EmitterShape::Triangle { p0, e1, e2 } = light.shape else { unreachable!() };
            let [p0, e1, e2] = [p0, e1, e2].map(f64s);
            let n = cross(e1, e2);
            let point: V = std::array::from_fn(|k| p0[k] + t * (1.0 - s) * e1[k] + s * e2[k]);
            let cos = -dot(unit(point), unit(n));
            let primitive = bits(light.primitive);
            let pdf = lights.pdf_area::<f32>(primitive, vec1([0.0; 3]), norm(point) as f32, cos as f32);
            f64::from(pdf) * cos / dot(point, point) * norm(n) * (1.0 - s)
        };
        let mut expected = Vec::new();
        for light in &emitters {
            for cell in 0..N * N {
                let (i, j) = ((cell / N) as f64, (cell % N) as f64);
                let n = N as f64;
                let place = |k: f64, x: f64| (k + 0.5 + 0.5 * x) / n;
                let inner = |x: f64| rule.iter().map(move |&(y, w)| (y, w, x));
                let sum: f64 = rule
                    .iter()
                    .flat_map(|&(x, w)| inner(x).map(move |(y, v, x)| (x, y, v * w)))
                    .map(|(x, y, w)| w * mass(light, place(i, x), place(j, y)))
                    .sum();
                expected.push(0.25 * sum / (n * n));
            }
        }
        let total: f64 = expected.iter().sum();
        assert!((total - 1.0).abs() < 1e-6, "{name}: ∫pdf = {total}");
        let mut observed = vec![0u64; expected.len()];
        let mut rng = Rng::new(8);
        for _ in 0..DRAWS {
            let sample = draw(&lights, [0.0; 3], &mut rng);
            let [b1, b2] = sample.place.map(f64::from);
            let cell = |x: f64| ((x * N as f64) as usize).min(N - 1);
            observed[(sample.primitive.0 as usize * N + cell(b2)) * N + cell(b1 / (1.0 - b2))] += 1;
        }
        let expected: Vec<f64> = expected.iter().map(|p| p * DRAWS as f64).collect();
        let outcome = chi2_test(&observed, &expected);
        assert!(outcome.p_value > sidak_alpha(TESTS), "{name}: {outcome:?}");
    }
}

#[test]
fn what_is_no_parallelogram_or_shines_unevenly_is_not_paired() {
    let pairs = |corners| area_lights(&pair(corners, [0, 0], [WHITE; 2]));
    assert!(!apart(&pairs(CORNERS)));
    assert!(apart(&area_lights(&pair(CORNERS, [0, 0], [WHITE, [2.0, 1.0, 0.0]]))), "as bright, but of another colour");
    let mut kite = CORNERS;
    kite[3][0] += 0.01;
    assert!(apart(&pairs(kite)));
    let [a, b, c, d] = CORNERS;
    let moved = [c, d, a].map(|p| [p[0], p[1] + 0.01, p[2]]);
    assert!(apart(&area_lights(&[triangle(0, [a, b, c], WHITE), triangle(1, moved, WHITE)])), "a gap between them");
    let same = [triangle(0, [a, b, c], WHITE), triangle(1, [b, c, a], WHITE)];
    assert!(apart(&area_lights(&same)), "the same twice");
    // So thin that all vertices are near where a parallelogram of its length has them, but one half has 20 times the other's area.
    let strip = [[-0.8, 0.0, 1.0], [0.8, 0.0, 1.0], [0.8, -1.5e-5, 1.0], [-0.8, -3e-4, 1.0]];
    assert!(apart(&pairs(strip)), "halves of unlike areas");
    // Back to back: the second triangle turned over. From the origin only one is lit.
    let turned = area_lights(&[triangle(0, [a, b, c], WHITE), triangle(1, [a, d, c], WHITE)]);
    assert_eq!(at(&turned, [0.75, 0.125]).pdf, 0.0);
}

/// From the lamp's plane, its edges and corners, from 10⁶ away; lamps 10⁻⁶ wide and slivers: nothing that is not finite, and
/// a density that f64 agrees with wherever there is one.
#[test]
fn extreme_places_and_sizes() {
    let [a, b, c, d] = CORNERS;
    let mid = |p: V, q: V| scaled([0, 1, 2].map(|k| p[k] + q[k]), 0.5);
    let edge = sub(b, a);
    let cases: [(f64, V); 8] = [
        (1.0, a),
        (1.0, mid(a, b)),
        (1.0, mid(a, c)),
        (1.0, mid(b, d)),
        (1.0, [0, 1, 2].map(|k| a[k] - edge[k])),
        (1.0, scaled(CORNERS[0], -1e6)),
        (1e-6, [0.0; 3]),
        (1e-6, a),
    ];
    let mut rng = Rng::new(11);
    for (size, from) in cases {
        // Shrunk towards its first corner.
        let corners = CORNERS.map(|p| [0, 1, 2].map(|k| a[k] + size * (p[k] - a[k])));
        let lights = area_lights(&pair(corners, [0, 2], [WHITE; 2]));
        for _ in 0..2000 {
            let s = draw(&lights, f32s(from), &mut rng);
            assert!(s.pdf.is_finite() && s.pdf >= 0.0);
            if s.pdf == 0.0 {
                continue;
            }
            let way = sub(f64s(s.target.lane(0)), f64s(f32s(from)));
            let cos = -dot(unit(way), f64s(s.ng.lane(0)));
            if cos < 1e-4 {
                // Too near the lamp's plane for f32 to tell on which side.
                continue;
            }
            let exact = f64::from(lights.emitter_pdf_row(s.primitive.0)) * dot(way, way) / cos;
            let bound = exact * ULP * (8.0 + 4.0 / cos);
            assert!((f64::from(s.pdf) - exact).abs() <= bound, "{} for {exact}, cos {cos}", s.pdf);
            assert!(s.distance.is_finite() && s.wi.lane(0).iter().all(|x| x.is_finite()));
        }
    }
}

/// By place, both triangles of a lamp are as likely; all together they are certain.
#[test]
fn a_grid_chooses_whole_lamps() {
    let lamp = |i: u32, x: f64| {
        let corners = CORNERS.map(|p| [0.25 * p[0] + x, 0.25 * p[1], p[2]]);
        pair(corners, [0, 1], [WHITE; 2]).map(|e| Emitter { primitive: e.primitive + 2 * i, ..e })
    };
    let emitters: Vec<Emitter> =
        [-0.9, 0.0, 0.9].into_iter().enumerate().flat_map(|(i, x)| lamp(i as u32, x)).collect();
    let mut lights = area_lights(&emitters);
    let vertices = |e: &Emitter| {
        let EmitterShape::Triangle { p0, e1, e2 } = e.shape else { unreachable!() };
        [p0, [0, 1, 2].map(|k| p0[k] + e1[k]), [0, 1, 2].map(|k| p0[k] + e2[k])]
    };
    let floor = [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 2.0, 0.0]];
    let positions: Vec<[f32; 3]> = emitters.iter().flat_map(vertices).chain(floor).collect();
    let triangles: Vec<[u32; 3]> = (0..7).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    lights.add_grid(&Receivers { positions: &positions, triangles: &triangles, spheres: &[] });
    assert!(lights.has_grid());
    let mut rng = Rng::new(12);
    for x in [-0.8, 0.0, 0.7] {
        let (p, up) = (vec1([x, 0.0, 0.0]), vec1([0.0, 0.0, 1.0]));
        let table = lights.table_at(p, up);
        let ratio = |primitive: u32| f64::from(lights.choice_ratio::<f32>(bits(primitive), table, true));
        let chosen = |e: &Emitter| f64::from(lights.emitter_pdf_row(e.primitive)) * e.area() * ratio(e.primitive);
        let total: f64 = emitters.iter().map(chosen).sum();
        assert!((total - 1.0).abs() < 1e-6, "{total}");
        assert!((0..3).all(|i| ratio(2 * i) == ratio(2 * i + 1)));
        let nearest = if x < -0.5 {
            0
        } else if x < 0.5 {
            1
        } else {
            2
        };
        assert!((0..3).all(|i| ratio(2 * i) <= ratio(2 * nearest)));
        for _ in 0..200 {
            let s = lights.sample_from(p, None, Some(table), rng.f32(), [rng.f32(), rng.f32()], true);
            let cos = -s.wi.dot(s.ng);
            let again = lights.pdf_area::<f32>(s.primitive, p, s.distance, cos) * ratio(s.primitive.0) as f32;
            assert!((s.pdf / again - 1.0).abs() < 1e-6, "{} and {again}", s.pdf);
        }
    }
}
