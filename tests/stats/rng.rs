//! The tests' own random numbers.

/// SplitMix64 (Steele, Lea, Flood 2014): a counter through a 64-bit mixer. Small, and unrelated to the renderer's.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Self {
        // One mixing step, so that seeds 1, 2, 3 … do not give streams shifted by one.
        Rng(Rng(seed ^ 0x6A09_E667_F3BC_C909).u64())
    }

    pub fn u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn u32(&mut self) -> u32 {
        (self.u64() >> 32) as u32
    }

    /// Uniform on [0, 1), 53 bits.
    pub fn f64(&mut self) -> f64 {
        (self.u64() >> 11) as f64 * f64::powi(2.0, -53)
    }

    /// Uniform on [0, 1), 24 bits.
    pub fn f32(&mut self) -> f32 {
        (self.u64() >> 40) as f32 * f32::powi(2.0, -24)
    }

    /// Uniform on [lo, hi).
    pub fn range(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.f64()
    }

    /// Uniform on 0 … n − 1 (bias below n/2⁶⁴). `n` > 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.u64() as u128 * n as u128) >> 64) as usize
    }

    /// A standard normal number (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.f64()).ln()).sqrt() * (std::f64::consts::TAU * self.f64()).cos()
    }

    /// A unit vector, uniform over the sphere.
    pub fn sphere(&mut self) -> [f64; 3] {
        let z = self.range(-1.0, 1.0);
        let (s, c) = self.range(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * c, r * s, z]
    }
}
