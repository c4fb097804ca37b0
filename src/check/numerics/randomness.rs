//! Random numbers of both samplers: below 1, and uncorrelated between whatever stands beside each other.

use super::{Effort, Row};
use crate::lane::{Real, f32x8};
use crate::sampling::{Sampler, SamplerKind, Site, dimensions};
use rayon::prelude::*;

const GROUP: &str = "random numbers";
/// Of a bounce, those that paths draw.
const DRAWN: usize = dimensions::OPACITY + 1;
/// Dimensions compared: the camera's and the first bounce's.
const DIMENSIONS: usize = dimensions::CAMERA + DRAWN;
/// Dimensions × relations × samplers are 108 tests: below this at 1 % of false alarms together (Šidák).
const LARGEST_Z: f64 = 3.91;

/// A sample: seed, pixel, index.
type Sample = (u64, u32, u32);
/// Two samples that stand beside each other.
type Beside = fn(u32) -> [Sample; 2];

pub fn rows(effort: Effort) -> Vec<Row> {
    let pairs = effort.pick(1 << 17, 1 << 22, 1 << 27);
    let beside: [(&str, Beside); 4] = [
        ("neighbouring pixels, or blocks that share points", |k| [(1, 2 * k, 3), (1, 2 * k + 1, 3)]),
        ("seeds one apart", |k| [(1, k, 3), (2, k, 3)]),
        ("a pixel's sample and the sample's pixel", |k| [(1, k, k / 2 + 1), (1, k / 2 + 1, k)]),
        // Of Sobol' points those of one pixel are to differ from each other: that is what they are for.
        ("consecutive samples", |k| [(1, 77, 2 * k), (1, 77, 2 * k + 1)]),
    ];
    let mut rows = Vec::new();
    for (kind, relations) in [(SamplerKind::Independent, 4), (SamplerKind::Sobol, 3)] {
        rows.push(below_one(kind, pairs));
        rows.extend(beside[..relations].iter().map(|(name, samples)| correlation(kind, name, pairs, *samples)));
        rows.push(dimension_to_dimension(kind, pairs));
    }
    rows
}

/// Lanes are samples: eight pairs at a time.
fn draws(kind: SamplerKind, sample: impl Fn(usize) -> Sample) -> [f32x8; DIMENSIONS] {
    let mut sampler = Sampler::<f32x8>::idle();
    for lane in 0..8 {
        let (seed, pixel, index) = sample(lane);
        sampler.seed_lane(kind, lane, seed, Site::alone(pixel), index);
    }
    let (camera, bounce) = (sampler.camera_dims(kind, true), sampler.bounce_dims(kind, f32x8::zero()));
    std::array::from_fn(|d| if d < dimensions::CAMERA { camera[d] } else { bounce[d - dimensions::CAMERA] })
}

fn below_one(kind: SamplerKind, samples: u32) -> Row {
    let wrong = |k: u32| {
        // Indices from both ends of the 2³² there are.
        let u = draws(kind, |i| (9, (8 * k + i as u32) / 64, if i % 2 == 0 { k } else { !k }));
        u.iter().filter(|u| !(u.lowest() >= 0.0 && u.highest() < 1.0)).count() as u64
    };
    let wrong = (0..samples / 8).into_par_iter().map(wrong).sum();
    let case = format!("{}: all in [0, 1)", kind.name());
    Row::never(GROUP, case, u64::from(samples) * DIMENSIONS as u64, wrong, "numbers outside")
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

fn row(kind: SamplerKind, name: &str, pairs: u32, z: f64) -> Row {
    let seen = LARGEST_Z / f64::from(pairs).sqrt();
    let case = format!("{}, {name}: correlations from {seen:.1e} up", kind.name());
    Row::new(GROUP, case, u64::from(pairs), z, LARGEST_Z, "standard errors")
}

fn correlation(kind: SamplerKind, name: &str, pairs: u32, samples: Beside) -> Row {
    let z = largest_z(pairs, |k| {
        let [a, b] = [0, 1].map(|one| draws(kind, |i| samples(8 * k + i as u32)[one]));
        std::array::from_fn(|d| product(a[d], b[d]))
    });
    row(kind, name, pairs, z)
}

fn dimension_to_dimension(kind: SamplerKind, pairs: u32) -> Row {
    let z = largest_z(pairs, |k| {
        let u = draws(kind, |i| (4, 8 * k + i as u32, 1));
        std::array::from_fn(|d| product(u[d], u[(d + 1) % DIMENSIONS]))
    });
    row(kind, "a dimension and the next", pairs, z)
}
