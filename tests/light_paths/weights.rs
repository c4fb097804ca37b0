//! The weights of the three ways to find a path of light, from the ratios that the kernel carries along, against densities
//! multiplied out in f64 from what they mean, and their sum against 1.

use crate::stats::Rng;
use octolux::kernel::light_paths::ratio::*;
use std::f64::consts::PI;

type V = [f64; 3];

/// A path: light, vertices, camera; with the densities that each vertex's scattering has either way.
struct Path {
    points: Vec<V>,
    normals: Vec<V>,
    /// Per solid angle, of vertex i ≥ 1: towards the camera's side, given where light came from; and the reverse.
    forth: Vec<f64>,
    back: Vec<f64>,
    /// Scattered by a delta: `forth` is 1 and `back` the quotient.
    delta: Vec<bool>,
    /// Of a delta, the index on the side away from the light over that towards it.
    eta: Vec<f64>,
    number: f64,
    start: f64,
    sampled: f64,
    importance: f64,
}

fn difference(a: V, b: V) -> V {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: V, b: V) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

impl Path {
    /// `scatterings` vertices between light and camera.
    fn random(rng: &mut Rng, scatterings: usize) -> Self {
        let mut between = |low: f64, high: f64| (rng.range(low.ln(), high.ln())).exp();
        let count = scatterings + 1;
        let forth = (0..count).map(|_| between(1e-3, 1e3)).collect();
        let back = (0..count).map(|_| between(1e-3, 1e3)).collect();
        let (number, start) = (between(1.0, 1e6), between(1e-3, 1e5));
        let (sampled, importance) = (between(1e-3, 1e4), between(1e2, 1e6));
        let eta = (0..count).map(|_| between(0.5, 2.0)).collect();
        let points = (0..=count).map(|_| rng.sphere().map(|x| x * 1.5)).collect();
        let normals = (0..=count).map(|_| rng.sphere()).collect();
        // Not next to the camera: a delta there leaves nothing to connect.
        let delta = (0..count).map(|i| i > 0 && i < scatterings && rng.f64() < 0.3).collect();
        let mut path = Path { points, normals, forth, back, delta, eta, number, start, sampled, importance };
        for i in 1..count {
            if path.delta[i] {
                path.forth[i] = 1.0;
                path.back[i] = refraction_quotient(path.cos(i, i - 1), path.cos(i, i + 1), path.eta[i]);
            }
        }
        path
    }

    fn squared(&self, i: usize, j: usize) -> f64 {
        let d = difference(self.points[i], self.points[j]);
        dot(d, d)
    }

    /// At vertex `i` towards `j`.
    fn cos(&self, i: usize, j: usize) -> f64 {
        let d = difference(self.points[j], self.points[i]);
        (dot(self.normals[i], d) / dot(d, d).sqrt()).abs()
    }

    /// Per unit of area at `j`, of a density per solid angle at its neighbour `i`.
    fn area(&self, density: f64, i: usize, j: usize) -> f64 {
        density * self.cos(j, i) / self.squared(i, j)
    }

    /// Densities of the whole path: by a light path, by a camera path that runs into the light, by one that samples it.
    fn densities(&self) -> [f64; 3] {
        let last = self.points.len() - 1;
        let scatterings = last - 1;
        let emitted = self.cos(0, 1) / PI;
        let mut light = self.number * self.start * self.area(emitted, 0, 1);
        for i in 1..scatterings {
            light *= self.area(self.forth[i], i, i + 1);
        }
        let mut camera = self.area(self.importance, last, scatterings);
        for i in (2..=scatterings).rev() {
            camera *= self.area(self.back[i], i, i - 1);
        }
        let hit = self.area(self.back[1], 1, 0);
        let sampled = if self.delta[1] { 0.0 } else { self.area(self.sampled, 1, 0) };
        [light, camera * hit, camera * sampled]
    }

    /// The kernel's weight of the light path.
    fn light_weight(&self) -> f64 {
        let scatterings = self.points.len() - 2;
        let cos = |i: usize, j: usize| self.cos(i, j) as f32;
        let mut kept = light_starts(self.start as f32, self.number as f32);
        for i in 1..=scatterings {
            let q = kept / cos(i, i - 1);
            let sampled = if i == 1 && !self.delta[1] { self.sampled as f32 } else { 0.0 };
            let pair = [self.forth[i] as f32, self.back[i] as f32];
            if i == scatterings {
                let view = self.area(self.importance, i + 1, i) as f32;
                return f64::from(weight_against(light_connects(q, sampled, pair[1], view), 0.0));
            }
            kept = light_leaves(q, sampled, cos(i, i + 1), pair);
        }
        unreachable!()
    }

    /// The kernel's weights of the camera path that runs into the light and of the one that samples it.
    fn camera_weights(&self) -> [f64; 2] {
        let scatterings = self.points.len() - 2;
        let cos = |i: usize, j: usize| self.cos(i, j) as f32;
        let distance = self.squared(scatterings + 1, scatterings).sqrt() as f32;
        let mut kept = camera_starts(self.number as f32, distance, self.importance as f32);
        for i in (1..=scatterings).rev() {
            let e = kept / cos(i, i + 1);
            // What is forth for the light is back for the camera.
            let mut pair = [self.back[i] as f32, self.forth[i] as f32];
            if i == scatterings {
                pair[1] = 1.0;
            }
            kept = camera_leaves(e, cos(i, i - 1), pair);
            if i == 1 {
                let (start, hit) = (self.start as f32, pair[0]);
                let nee = self.sampled as f32;
                let against_hit = if self.delta[1] { 0.0 } else { nee / hit };
                let runs_into = weight_against(against_hit, camera_hits(kept, start));
                let light = camera_samples(e, pair[1], start, cos(1, 0), nee);
                let samples = if self.delta[1] { 0.0 } else { weight_against(hit / nee, light) };
                return [f64::from(runs_into), f64::from(samples)];
            }
        }
        unreachable!()
    }
}

/// How densities of directions change where they are refracted or reflected, by differences of Snell's law in azimuth and
/// height: dω of the light's side over dω of the other, so the reversed density over the scattered one.
fn refraction_quotient(from_cos: f64, to_cos: f64, eta: f64) -> f64 {
    // n₁ sinθ₁ = n₂ sinθ₂ in all azimuths: dω = sinθ dθ dφ, so the quotient is d(sin²θ₁)/cosθ₁ over d(sin²θ₂)/cosθ₂ the other
    // way round.
    let step = 1e-6;
    let sin_squared = 1.0 - to_cos * to_cos;
    let of_from = |sin_squared_to: f64| eta * eta * sin_squared_to;
    let from_area = (of_from(sin_squared + step) - of_from(sin_squared)) / (2.0 * from_cos);
    let to_area = step / (2.0 * to_cos);
    to_area / from_area
}

/// Factors of a ratio are some forty, each with a few roundings; a weight moves by at most half as much as its ratio squared.
const TOLERANCE: f64 = 200.0 / 16_777_216.0;

#[test]
fn weights_are_those_of_the_densities_and_sum_to_1() {
    let mut rng = Rng::new(8);
    let mut counted = [0.0; 3];
    for _ in 0..20_000 {
        let scatterings = 1 + rng.below(7);
        let path = Path::random(&mut rng, scatterings);
        let densities = path.densities();
        let squares: f64 = densities.iter().map(|p| p * p).sum();
        let [hit, sampled] = path.camera_weights();
        let weights = [path.light_weight(), hit, sampled];
        for (k, (weight, density)) in weights.into_iter().zip(densities).enumerate() {
            let expected = density * density / squares;
            assert!((weight - expected).abs() < TOLERANCE, "technique {k}: {weight}, from densities {expected}");
            counted[k] += weight;
        }
        let sum: f64 = weights.iter().sum();
        assert!((sum - 1.0).abs() < TOLERANCE, "{sum}");
    }
    // None of them is idle in this family.
    assert!(counted.iter().all(|&sum| sum > 200.0), "{counted:?}");
}

#[test]
fn quotients_at_deltas_are_those_of_snells_law() {
    let mut rng = Rng::new(9);
    for _ in 0..1000 {
        // Into the denser side, so that every angle has one.
        let eta = rng.range(1.0, 3.0);
        let from_cos = rng.range(0.05, 1.0);
        let sin_to = (1.0 - from_cos * from_cos).sqrt() / eta;
        let to_cos = (1.0 - sin_to * sin_to).sqrt();
        // By differences of the refracted angle: the reversed direction's density over the scattered one's is dω′/dω.
        let step = 1e-6;
        let angle = |cos: f64| ((1.0 - cos * cos).sqrt() / eta).asin().cos();
        let widened = (angle(from_cos + step) - angle(from_cos - step)) / (2.0 * step);
        let found = f64::from(delta_quotient(from_cos as f32, -to_cos as f32, eta as f32));
        assert!((found - widened).abs() < 1e-5 * found + 1e-8, "η {eta}, cosθ {from_cos}: {found} for {widened}");
    }
}

#[test]
fn extreme_ratios_stay_in_range() {
    assert_eq!(weight_against(1e30f32, 0.0), 0.0);
    assert_eq!(weight_against(f32::INFINITY, 0.0), 0.0);
    assert_eq!(weight_against(1e-30f32, 1e-30), 1.0);
    assert_eq!(hypot(3e30f32, 4e30), 5e30);
    assert_eq!(hypot(0.0f32, 0.0), 0.0);
    assert_eq!(hypot(0.0f32, 2.0), 2.0);
    assert!((hypot(3e-30f32, 4e-30) / 5e-30 - 1.0).abs() < 1e-6);
}
