//! Points of the unit cube, as 32 random-looking bits a coordinate.

use crate::kernel::Width;
use crate::lane::{Bits, Real, f32x8, f32x16};
use crate::sampling::sobol::{self, Key};
use crate::sampling::{Xoshiro, sample_key};
use serde::Serialize;

/// How the points of one estimate lie. All but [`Points::Independent`] fill the cube more evenly than chance; each point
/// by itself is uniform over the keys, so that every one gives unbiased means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Points {
    Independent,
    /// One point in each cell of a regular grid (jittered).
    Stratified,
    /// Radical inverses in the first primes, randomly shifted modulo 1 (Cranley & Patterson 1976).
    Halton,
    /// Sobol' under a random digital shift.
    Sobol,
    /// Owen-scrambled Sobol'.
    Owen,
    /// The Fibonacci lattice, randomly shifted. Two dimensions.
    Fibonacci,
}

/// The most dimensions of a point: what [`Points::Halton`] has primes and [`Points::Sobol`] matrices for.
pub const MAX_DIMENSIONS: usize = sobol::MAX_DIMENSIONS;

const PRIMES: [u64; MAX_DIMENSIONS] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71];

/// 2³²/Φ, Φ the golden ratio, as a step around the circle of 2⁶⁴.
const GOLDEN_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Points of one kind and number, with what does not depend on the key worked out.
#[derive(Clone, Debug)]
pub struct PointPlan {
    points: Points,
    n: usize,
    dimensions: usize,
    /// Halton before the shift, a row a dimension.
    table: Vec<Vec<u32>>,
}

impl Points {
    pub fn name(self) -> &'static str {
        match self {
            Points::Independent => "mc",
            Points::Stratified => "stratified",
            Points::Halton => "halton",
            Points::Sobol => "sobol",
            Points::Owen => "owen",
            Points::Fibonacci => "fibonacci",
        }
    }

    pub const ALL: [Points; 6] =
        [Points::Independent, Points::Stratified, Points::Halton, Points::Sobol, Points::Owen, Points::Fibonacci];

    /// The largest number of points up to `n` that it can have in `dimensions`: a grid needs a power.
    pub fn size(self, n: usize, dimensions: usize) -> usize {
        match self {
            Points::Stratified if dimensions > 1 => per_axis(n, dimensions).pow(dimensions as u32),
            _ => n,
        }
    }

    /// `None` where this kind has no points of so many dimensions.
    pub fn plan(self, n: usize, dimensions: usize) -> Option<PointPlan> {
        if dimensions > MAX_DIMENSIONS || (self == Points::Fibonacci && dimensions != 2) {
            return None;
        }
        let n = self.size(n, dimensions);
        let radical = |&base: &u64| (0..n as u64).map(|i| radical_inverse(i, base)).collect();
        let table =
            if self == Points::Halton { PRIMES[..dimensions].iter().map(radical).collect() } else { Vec::new() };
        Some(PointPlan { points: self, n, dimensions, table })
    }
}

/// ⌊n^(1/d)⌋, exactly.
pub fn per_axis(n: usize, dimensions: usize) -> usize {
    let guess = (n as f64).powf(1.0 / dimensions as f64) as usize;
    let fits = |s: usize| s.checked_pow(dimensions as u32).is_some_and(|power| power <= n);
    (guess.saturating_sub(1)..=guess + 1).rev().find(|&s| fits(s)).unwrap_or(1).max(1)
}

impl PointPlan {
    pub fn len(&self) -> usize {
        self.n
    }

    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// The points of `key`: `bits[d][i]` is coordinate d of point i. The same at any width.
    pub fn fill(&self, width: Width, key: u64, bits: &mut [Vec<u32>]) {
        for row in bits.iter_mut() {
            row.resize(self.n.next_multiple_of(crate::lane::MAX_WIDTH), 0);
        }
        match self.points {
            Points::Stratified => self.stratified(key, bits),
            Points::Halton => self.halton(key, bits),
            Points::Fibonacci => self.fibonacci(key, bits),
            _ => match width {
                Width::One => self.lanes::<f32>(key, bits),
                Width::Eight => self.lanes::<f32x8>(key, bits),
                Width::Sixteen => self.lanes::<f32x16>(key, bits),
            },
        }
    }

    fn lanes<R: Real>(&self, key: u64, bits: &mut [Vec<u32>]) {
        let lane_key = Key::<R>::from_fn(|_| key);
        for first in (0..self.n).step_by(R::WIDTH) {
            let index = R::Bits::from_fn(|lane| (first + lane) as u32);
            let mut rng = match self.points {
                Points::Independent => Some(Xoshiro::<R>::from_keys(|lane| sample_key(key, 0, (first + lane) as u32))),
                _ => None,
            };
            for (d, row) in bits.iter_mut().enumerate().take(self.dimensions) {
                let coordinate = match (&mut rng, self.points) {
                    (Some(rng), _) => rng.next_bits(),
                    (None, Points::Sobol) => sobol::shifted_sobol::<R>(index, lane_key, d),
                    (None, _) => sobol::owen_sobol::<R>(index, lane_key, d),
                };
                coordinate.store(&mut row[first..]);
            }
        }
    }

    fn stratified(&self, key: u64, bits: &mut [Vec<u32>]) {
        let per_axis = per_axis(self.n, self.dimensions);
        for i in 0..self.n {
            let mut rng = Xoshiro::<f32>::from_keys(|_| sample_key(key, 0, i as u32));
            let mut cell = i;
            for row in bits.iter_mut().take(self.dimensions) {
                row[i] = within((cell % per_axis) as u64, rng.next_bits().lane(0), per_axis as u64);
                cell /= per_axis;
            }
        }
    }

    fn halton(&self, key: u64, bits: &mut [Vec<u32>]) {
        for (d, row) in bits.iter_mut().enumerate().take(self.dimensions) {
            let shift = sample_key(key, 1, d as u32) as u32;
            row.iter_mut().zip(&self.table[d]).for_each(|(out, point)| *out = point.wrapping_add(shift));
        }
    }

    fn fibonacci(&self, key: u64, bits: &mut [Vec<u32>]) {
        let (shift, turn) = (sample_key(key, 1, 0) as u32, sample_key(key, 1, 1));
        let [first, second, ..] = bits else { return };
        for i in 0..self.n {
            first[i] = within(i as u64, shift, self.n as u64);
            second[i] = ((i as u64).wrapping_mul(GOLDEN_STEP).wrapping_add(turn) >> 32) as u32;
        }
    }
}

/// (cell + fraction)/cells, in units of 2⁻³².
fn within(cell: u64, fraction: u32, cells: u64) -> u32 {
    (((cell << 32) + u64::from(fraction)) / cells) as u32
}

/// Digits of `i` in `base` mirrored at the point, in units of 2⁻³² (van der Corput 1935; Halton 1960).
fn radical_inverse(mut i: u64, base: u64) -> u32 {
    let (mut mirrored, mut power) = (0u64, 1u64);
    while i > 0 {
        mirrored = mirrored * base + i % base;
        power *= base;
        i /= base;
    }
    ((u128::from(mirrored) << 32) / u128::from(power)) as u32
}

/// The centre of a coordinate's cell, in (0, 1).
#[inline(always)]
pub fn unit(bits: u32) -> f64 {
    (f64::from(bits) + 0.5) * f64::powi(2.0, -32)
}

/// The centre of a cell of 2⁻²³ in lanes, in (0, 1): exact in f32, and without the bias that rounding down has.
#[inline(always)]
pub fn lane_unit<R: Real>(bits: R::Bits) -> R {
    let odd = bits.shr::<9>().shl::<1>() | R::Bits::splat(1);
    R::from_int(odd) * R::splat(1.0 / (1u32 << 24) as f32)
}
