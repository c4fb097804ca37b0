//! Random numbers: below 1, and uncorrelated between whatever stands beside each other.

use super::{Effort, Row};
use crate::lane::{Real, f32x8};
use crate::sampling::{Xoshiro, dimensions, sample_key};
use rayon::prelude::*;

const GROUP: &str = "random numbers";
/// Dimensions compared: the camera's and the first bounce's.
const DIMENSIONS: usize = dimensions::CAMERA + dimensions::BOUNCE;
/// Dimensions × relations are 80 tests: below this at 1 % of false alarms together (Šidák).
const LARGEST_Z: f64 = 3.889;

/// The keys of two samples that stand beside each other.
type Beside = fn(u32) -> [u64; 2];

pub fn rows(effort: Effort) -> Vec<Row> {
    let pairs = effort.pick(1 << 17, 1 << 22, 1 << 27);
    let beside: [(&str, Beside); 4] = [
        ("neighbouring pixels", |k| [sample_key(1, 2 * k, 3), sample_key(1, 2 * k + 1, 3)]),
        ("consecutive samples", |k| [sample_key(1, 77, 2 * k), sample_key(1, 77, 2 * k + 1)]),
        ("seeds one apart", |k| [sample_key(1, k, 3), sample_key(2, k, 3)]),
        ("a pixel's sample and the sample's pixel", |k| [sample_key(1, k, k / 2 + 1), sample_key(1, k / 2 + 1, k)]),
    ];
    let mut rows = vec![below_one(pairs)];
    rows.extend(beside.into_iter().map(|(name, keys)| correlation(name, pairs, keys)));
    rows.push(dimension_to_dimension(pairs));
    rows
}

/// Lanes are samples: eight pairs at a time.
fn draws(keys: impl FnMut(usize) -> u64) -> [f32x8; DIMENSIONS] {
    let mut rng = Xoshiro::<f32x8>::from_keys(keys);
    let (camera, bounce) = (rng.camera_dims(), rng.bounce_dims());
    std::array::from_fn(|d| if d < dimensions::CAMERA { camera[d] } else { bounce[d - dimensions::CAMERA] })
}

fn below_one(samples: u32) -> Row {
    let wrong = |k: u32| {
        let u = draws(|i| sample_key(9, 8 * k + i as u32, 0));
        u.iter().filter(|u| !(u.lowest() >= 0.0 && u.highest() < 1.0)).count() as u64
    };
    let wrong = (0..samples / 8).into_par_iter().map(wrong).sum();
    Row::never(GROUP, "all in [0, 1)", u64::from(samples) * DIMENSIONS as u64, wrong, "numbers outside")
        .naive("u32 · 2⁻³² in f32: 1 for the largest 128")
}

/// Σ (u − ½)(v − ½)·12 over √n is a standard normal for independent u and v. Sees correlations from 3.9/√n up.
fn largest_z(pairs: u32, products: impl Fn(u32) -> [f64; DIMENSIONS] + Send + Sync) -> f64 {
    let add = |a: [f64; DIMENSIONS], b: [f64; DIMENSIONS]| std::array::from_fn(|d| a[d] + b[d]);
    let sums = (0..pairs / 8).into_par_iter().map(products).reduce(|| [0.0; DIMENSIONS], add);
    sums.iter().map(|s| (12.0 * s / f64::from(pairs).sqrt()).abs()).fold(0.0, f64::max)
}

fn product(a: f32x8, b: f32x8) -> f64 {
    (0..8).map(|i| (f64::from(a.lane(i)) - 0.5) * (f64::from(b.lane(i)) - 0.5)).sum()
}

fn row(name: &str, pairs: u32, z: f64) -> Row {
    let seen = LARGEST_Z / f64::from(pairs).sqrt();
    let case = format!("{name}: correlations from {seen:.1e} up");
    Row::new(GROUP, case, u64::from(pairs), z, LARGEST_Z, "standard errors")
}

fn correlation(name: &str, pairs: u32, keys: Beside) -> Row {
    let z = largest_z(pairs, |k| {
        let (a, b) = (draws(|i| keys(8 * k + i as u32)[0]), draws(|i| keys(8 * k + i as u32)[1]));
        std::array::from_fn(|d| product(a[d], b[d]))
    });
    row(name, pairs, z)
}

fn dimension_to_dimension(pairs: u32) -> Row {
    let z = largest_z(pairs, |k| {
        let u = draws(|i| sample_key(4, 8 * k + i as u32, 1));
        std::array::from_fn(|d| product(u[d], u[(d + 1) % DIMENSIONS]))
    });
    row("a dimension and the next", pairs, z)
}
