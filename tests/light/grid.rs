//! Many lights, chosen by where the receiver is.

use super::TESTS;
use super::scenes::*;
use crate::stats::{Moments, Rng, chi2_test, sidak_alpha, z_bound};
use octolux::lane::{Bits, Mask, Real, Vec3, f32x8, f32x16};
use octolux::light::{Emitter, EmitterShape, Lights, Receivers};

const LAMPS: usize = 60;

/// A room of unit size whose ceiling is lamps facing down, with two balls, and a floor.
struct Room {
    emitters: Vec<Emitter>,
    lights: Lights,
}

impl Room {
    fn new() -> Self {
        let mut rng = Rng::new(31);
        let mut emitters: Vec<Emitter> = (0..LAMPS)
            .map(|i| {
                let (x, y) = (rng.range(-0.9, 0.8), rng.range(-0.9, 0.8));
                let corners = [[x, y, 0.9], [x, y + 0.1, 0.9], [x + 0.1, y, 0.9]];
                triangle(i as u32 + 2, corners, [(4.0 * (rng.f64() - 0.5)).exp() as f32; 3])
            })
            .collect();
        let first_ball = LAMPS as u32 + 2;
        let balls = [([0.5, 0.5, 0.0], 0.1), ([-0.5, 0.2, 0.3], 0.02)];
        emitters.extend(balls.iter().enumerate().map(|(i, (c, r))| sphere(first_ball + i as u32, *c, *r, [0.5; 3])));

        let mut positions = vec![[-1f32, -1.0, -0.5], [1.0, -1.0, -0.5], [1.0, 1.0, -0.5], [-1.0, 1.0, -0.5]];
        let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
        for emitter in &emitters {
            if let EmitterShape::Triangle { p0, e1, e2 } = emitter.shape {
                let at = positions.len() as u32;
                positions.extend([p0, std::array::from_fn(|k| p0[k] + e1[k]), std::array::from_fn(|k| p0[k] + e2[k])]);
                triangles.push([at, at + 1, at + 2]);
            }
        }
        let spheres = balls.map(|(c, r)| (f32s(c), r as f32));
        let mut lights = area_lights(&emitters);
        assert!(!lights.has_grid());
        lights.add_grid(&Receivers { positions: &positions, triangles: &triangles, spheres: &spheres });
        assert!(lights.has_grid());
        Room { emitters, lights }
    }

    /// Probability of each lamp from a table, as the densities state it.
    fn stated(&self, table: u32) -> Vec<f64> {
        let ratio = |e: &Emitter| {
            f64::from(self.lights.choice_ratio::<f32>(Bits::splat(e.primitive), Bits::splat(table), true))
        };
        let by_power = |e: &Emitter| match e.shape {
            EmitterShape::Triangle { .. } => f64::from(self.lights.emitter_pdf_row(e.primitive)) * e.area(),
            EmitterShape::Sphere { .. } => f64::from(self.lights.emitter_pdf_row(e.primitive)),
        };
        self.emitters.iter().map(|e| ratio(e) * by_power(e)).collect()
    }

    fn table(&self, p: [f32; 3], n: [f32; 3]) -> u32 {
        self.lights.table_at::<f32>(vec1(p), vec1(n)).lane(0)
    }
}

/// Receivers on the floor, one where nothing was expected, and one out of bounds, which counts to the cell beside it. All
/// see every lamp.
const RECEIVERS: [([f32; 3], [f32; 3]); 5] = [
    ([-0.8, -0.7, -0.5], [0.0, 0.0, 1.0]),
    ([0.6, 0.1, -0.5], [0.1, 0.0, 0.99]),
    ([0.0, 0.0, -0.5], [0.0, 0.0, -1.0]),
    ([0.0, 0.0, 0.4], [1.0, 0.0, 0.0]),
    ([0.0, 0.0, -9.0], [0.0, 0.0, 1.0]),
];

#[test]
fn drawn_as_often_as_stated() {
    let room = Room::new();
    let mut rng = Rng::new(32);
    for (k, (p, n)) in RECEIVERS.into_iter().enumerate() {
        let table = room.table(p, n);
        assert_eq!(table == 0, k == 3, "receiver {k}");
        let stated = room.stated(table);
        assert!((stated.iter().sum::<f64>() - 1.0).abs() < 1e-5, "receiver {k}: Σ = {}", stated.iter().sum::<f64>());
        let draws = 400_000;
        let mut observed = vec![0; stated.len()];
        for _ in 0..draws {
            let (choice, u) = (rng.f32(), [rng.f32(), rng.f32()]);
            let sample = room.lights.sample_from::<f32>(vec1(p), None, Some(Bits::splat(table)), choice, u, true);
            observed[sample.primitive.lane(0) as usize - 2] += 1;
        }
        let expected: Vec<f64> = stated.iter().map(|p| p * f64::from(draws)).collect();
        let outcome = chi2_test(&observed, &expected);
        assert!(outcome.p_value > sidak_alpha(TESTS), "receiver {k}: {outcome:?}");
    }
}

/// What a lamp would send counts for nine tenths at most: no lamp is ever forgotten.
#[test]
fn every_lamp_keeps_a_tenth_of_its_power() {
    let room = Room::new();
    let by_power = room.stated(0);
    for (p, n) in RECEIVERS {
        for (at, power) in room.stated(room.table(p, n)).iter().zip(&by_power) {
            assert!(*at > 0.1 * power - f64::powi(2.0, -23), "{at} of {power}");
        }
    }
}

/// Nine tenths in proportion to what four points of the floor in a cell would get of each lamp, by the formula in f64.
#[test]
fn in_proportion_to_what_lamps_send() {
    let room = Room::new();
    let by_power = room.stated(0);
    // A thirty-second of the longest side.
    let size = 2.0 / 32.0;
    for (p, n) in &RECEIVERS[..2] {
        let middle = |x: f32| ((f64::from(x) + 1.0) / size).floor() * size - 1.0 + 0.5 * size;
        let (x, y) = (middle(p[0]), middle(p[1]));
        let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|c| c.map(|c| 0.25 * size * c));
        let sent = |e: &Emitter| corners.iter().map(|c| sends(e, [x + c[0], y + c[1], -0.5], size)).sum::<f64>();
        let sent: Vec<f64> = room.emitters.iter().map(sent).collect();
        let total: f64 = sent.iter().sum();
        for (i, stated) in room.stated(room.table(*p, *n)).iter().enumerate() {
            let expected = 0.9 * sent[i] / total + 0.1 * by_power[i];
            // Numbers have steps of 2⁻²⁴.
            assert!(
                (stated - expected).abs() < 1.5 * f64::powi(2.0, -24) + 1e-5 * expected,
                "{i}: {stated} {expected}"
            );
        }
    }
}

/// About what arrives at a point of the floor.
fn sends(emitter: &Emitter, p: [f64; 3], size: f64) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let (center, area, down) = match emitter.shape {
        EmitterShape::Triangle { p0, e1, e2 } => {
            ([0, 1, 2].map(|k| f64::from(p0[k]) + (f64::from(e1[k]) + f64::from(e2[k])) / 3.0), emitter.area(), true)
        }
        EmitterShape::Sphere { center, radius } => {
            (center.map(f64::from), std::f64::consts::PI * f64::from(radius).powi(2), false)
        }
    };
    let to = [0, 1, 2].map(|k| center[k] - p[k]);
    let soft = dot(to, to).max(area / 4.0).max(size * size / 16.0);
    let up = to[2] / dot(to, to).sqrt();
    let extent = (area / soft).sqrt().min(1.0);
    let leaving = if down { (extent + up).max(0.0) / (1.0 + extent) } else { 1.0 };
    f64::from(emitter.radiance[0]) * area * leaving * (extent + up).max(0.0) / (1.0 + extent) / soft
}

/// The density of a sample is what a ray that runs into the same point is told.
#[test]
fn read_back_from_the_table() {
    let room = Room::new();
    let mut rng = Rng::new(33);
    for (p, n) in RECEIVERS {
        let table = Bits::splat(room.table(p, n));
        for _ in 0..2000 {
            let (choice, u) = (rng.f32(), [rng.f32(), rng.f32()]);
            let s = room.lights.sample_from::<f32>(vec1(p), None, Some(table), choice, u, true);
            let cos = -(s.ng.dot(s.wi));
            let pdf = room.lights.pdf_area::<f32>(s.primitive, vec1(p), s.distance, cos)
                * room.lights.choice_ratio::<f32>(s.primitive, table, true);
            assert!((pdf / s.pdf - 1.0).abs() < 1e-5, "{pdf} {}", s.pdf);
        }
    }
}

/// Irradiance without occlusion: both choices estimate the same, the grid's with less noise.
#[test]
fn same_mean_less_variance() {
    let room = Room::new();
    let mut rng = Rng::new(34);
    let mut quieter = 0;
    for (p, n) in &RECEIVERS[..2] {
        let table = Bits::splat(room.table(*p, *n));
        let mut estimate = |table: Option<<f32 as Real>::Bits>| {
            let mut moments = Moments::new();
            for _ in 0..400_000 {
                let (choice, u) = (rng.f32(), [rng.f32(), rng.f32()]);
                let s = room.lights.sample_from::<f32>(vec1(*p), None, table, choice, u, true);
                let cos = s.wi.dot(vec1(*n)).max(0.0);
                moments.push(if s.pdf > 0.0 { f64::from(s.radiance.x * cos / s.pdf) } else { 0.0 });
            }
            moments
        };
        let (grid, power) = (estimate(Some(table)), estimate(None));
        let error = grid.std_error().hypot(power.std_error());
        let difference = grid.mean - power.mean;
        assert!(difference.abs() < z_bound(TESTS) * error, "{difference} ± {error}");
        quieter += usize::from(grid.variance() < 0.5 * power.variance());
    }
    assert_eq!(quieter, 2);
}

#[test]
fn same_bits_at_every_width() {
    let room = Room::new();
    let mut rng = Rng::new(35);
    for _ in 0..200 {
        let mut triple = || -> [[f32; 3]; 16] { std::array::from_fn(|_| f32s([0; 3].map(|_| rng.range(-1.2, 1.2)))) };
        let (p, n, u) = (triple(), triple(), triple().map(|u| u.map(|x| x.abs().fract())));
        let eight: Vec<u32> = [0, 8].iter().flat_map(|first| run::<f32x8>(&room.lights, &p, &n, &u, *first)).collect();
        let one: Vec<u32> = (0..16).flat_map(|first| run::<f32>(&room.lights, &p, &n, &u, first)).collect();
        assert_eq!(one, eight);
        assert_eq!(one, run::<f32x16>(&room.lights, &p, &n, &u, 0));
    }
}

fn run<R: Real>(lights: &Lights, p: &[[f32; 3]], n: &[[f32; 3]], u: &[[f32; 3]], first: usize) -> Vec<u32> {
    let pick = |from: &[[f32; 3]]| Vec3::<R>::from_fn(|i| from[first + i]);
    let (p, u) = (pick(p), pick(u));
    let table = lights.table_at(p, pick(n));
    let all = R::Mask::splat(true);
    let s = lights.sample_from(p, None, Some(table), u.x, [u.y, u.z], all);
    let ratio = lights.choice_ratio::<R>(R::Bits::from_fn(|i| 2 + (first + i) as u32), table, all);
    let lane = |i: usize| [table.lane(i), s.primitive.lane(i), s.pdf.lane(i).to_bits(), ratio.lane(i).to_bits()];
    (0..R::WIDTH).flat_map(lane).collect()
}

#[test]
fn a_few_lamps_go_by_power() {
    let lamp = triangle(0, [[0.0, 0.0, 1.0], [0.0, 0.5, 1.0], [0.5, 0.0, 1.0]], [1.0; 3]);
    let mut lights = area_lights(&[lamp]);
    let positions = [[0.0, 0.0, 1.0], [0.0, 0.5, 1.0], [0.5, 0.0, 1.0]];
    lights.add_grid(&Receivers { positions: &positions, triangles: &[[0, 1, 2]], spheres: &[] });
    assert!(!lights.has_grid());
    assert_eq!(lights.table_at::<f32>(vec1([0.1, 0.1, 0.0]), vec1([0.0, 0.0, 1.0])).lane(0), 0);
}
