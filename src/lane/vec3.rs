//! Three lanes at once: points, directions, colours.

use super::Real;
use core::ops::{Add, Mul, Neg, Sub};

/// A vector or an RGB triple per lane.
#[derive(Clone, Copy, Debug)]
pub struct Vec3<R> {
    /// First coordinate, or red.
    pub x: R,
    /// Second coordinate, or green.
    pub y: R,
    /// Third coordinate, or blue.
    pub z: R,
}

impl<R> Vec3<R> {
    /// From coordinates.
    #[inline(always)]
    pub const fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }
}

impl<R: Real> Vec3<R> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: [f32; 3]) -> Self {
        Self::new(R::splat(v[0]), R::splat(v[1]), R::splat(v[2]))
    }
    /// The same value in every component.
    #[inline(always)]
    pub fn all(v: R) -> Self {
        Self::new(v, v, v)
    }
    /// (0, 0, 0) in every lane.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::all(R::zero())
    }
    /// Fused, in the order z, y, x: `x·x' + (y·y' + z·z')`.
    #[inline(always)]
    pub fn dot(self, o: Self) -> R {
        self.x.mul_add(o.x, self.y.mul_add(o.y, self.z * o.z))
    }
    /// Each component by Kahan's difference of products, ≤ 1.5 ulp.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(
            difference_of_products(self.y, o.z, self.z, o.y),
            difference_of_products(self.z, o.x, self.x, o.z),
            difference_of_products(self.x, o.y, self.y, o.x),
        )
    }
    /// v·v.
    #[inline(always)]
    pub fn length_squared(self) -> R {
        self.dot(self)
    }
    /// √(v·v).
    #[inline(always)]
    pub fn length(self) -> R {
        self.length_squared().sqrt()
    }
    /// NaN for the zero vector; domain: lengths in [2⁻⁶³, 2⁶³], outside which the square over- or underflows.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * self.length().recip()
    }
    /// `self·s + o`, fused.
    #[inline(always)]
    pub fn mul_add(self, s: R, o: Self) -> Self {
        Self::new(self.x.mul_add(s, o.x), self.y.mul_add(s, o.y), self.z.mul_add(s, o.z))
    }
    /// Componentwise product.
    #[inline(always)]
    pub fn hadamard(self, o: Self) -> Self {
        Self::new(self.x * o.x, self.y * o.y, self.z * o.z)
    }
    /// The largest of the three.
    #[inline(always)]
    pub fn max_component(self) -> R {
        self.x.max_or(self.y).max_or(self.z)
    }
    /// Coordinate by coordinate.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }
    /// Lanes of `if_true` where the mask holds, else of `if_false`.
    #[inline(always)]
    pub fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        Self::new(
            R::select(mask, if_true.x, if_false.x),
            R::select(mask, if_true.y, if_false.y),
            R::select(mask, if_true.z, if_false.z),
        )
    }
    /// Zero where the mask does not hold.
    #[inline(always)]
    pub fn masked(self, mask: R::Mask) -> Self {
        Self::new(self.x.masked(mask), self.y.masked(mask), self.z.masked(mask))
    }
    /// Lane `i`.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> [f32; 3] {
        [self.x.lane(i), self.y.lane(i), self.z.lane(i)]
    }
    /// Replaces lane `i`.
    #[inline(always)]
    pub fn set_lane(&mut self, i: usize, v: [f32; 3]) {
        self.x.set_lane(i, v[0]);
        self.y.set_lane(i, v[1]);
        self.z.set_lane(i, v[2]);
    }
    /// Lane `i` is `f(i)`.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> [f32; 3]) -> Self {
        let mut v = Self::zero();
        for i in 0..R::WIDTH {
            v.set_lane(i, f(i));
        }
        v
    }
}

/// `[f(0), f(1), f(2)]`: one value per axis. Unlike `array::map` and `from_fn` it is always inlined, which keeps
/// registers from going through memory.
#[inline(always)]
pub fn axes<T>(mut f: impl FnMut(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// `a·b − c·d` with at most 1.5 ulp of error (Kahan; Jeannerod, Louvet, Muller 2013).
#[inline(always)]
pub fn difference_of_products<R: Real>(a: R, b: R, c: R, d: R) -> R {
    let cd = c * d;
    let error = c.neg_mul_add(d, cd);
    a.mul_add(b, -cd) + error
}

impl<R: Real> Add for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}
impl<R: Real> Sub for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}
impl<R: Real> Mul<R> for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: R) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}
impl<R: Real> Neg for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}
