//! Numbers to draw cases from: the same ones on every machine.

use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

pub struct Random(Xoshiro128PlusPlus);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }
    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }
    /// Uniform in [−1, 1).
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }
    pub fn below(&mut self, n: usize) -> usize {
        self.bits() as usize % n
    }
    /// Log-uniform in [2^low, 2^high).
    pub fn log_uniform(&mut self, low: f32, high: f32) -> f32 {
        (low + (high - low) * self.unit()).exp2()
    }
    /// Uniform in the cube of half-side `scale`.
    pub fn point(&mut self, scale: f32) -> [f32; 3] {
        [(); 3].map(|_| scale * self.signed())
    }
    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> [f32; 3] {
        loop {
            let v = self.point(1.0).map(f64::from);
            let squared: f64 = v.iter().map(|x| x * x).sum();
            if squared > 1e-4 && squared <= 1.0 {
                return v.map(|x| (x / squared.sqrt()) as f32);
            }
        }
    }
}

/// `x` moved by so many f32 steps; through zero by its sign bit.
pub fn nudge(x: f32, steps: i32) -> f32 {
    if x == 0.0 {
        f32::from_bits(steps.unsigned_abs()).copysign(steps as f32)
    } else {
        f32::from_bits((x.to_bits() as i32 + steps) as u32)
    }
}
