//! Unpolarised Fresnel reflectance. Cosines are of the angle to the (micro)normal on the side of `wo`, in [0, 1].

use crate::lane::Real;

/// Keeps 0/0 out where both amplitudes vanish (an index of 1 at exactly grazing incidence: then nothing reflects).
const TINY: f32 = 1e-30;

/// A dielectric interface seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct RelativeIor<R> {
    /// η(far side)/η(this side).
    pub eta: R,
    /// 1/η.
    pub inv_eta: R,
    /// η² − 1, to a few ulp of itself also where η is near 1.
    pub eta2_minus_1: R,
}

impl<R: Real> RelativeIor<R> {
    /// Of a solid of index `ior` > 0 in vacuum, seen from outside or from inside.
    #[inline(always)]
    pub fn new(ior: R, outside: R::Mask) -> Self {
        let inv_ior = ior.recip();
        let from_outside = (ior - R::one()) * (ior + R::one());
        let from_inside = -(from_outside * inv_ior * inv_ior);
        Self {
            eta: R::select(outside, ior, inv_ior),
            inv_eta: R::select(outside, inv_ior, ior),
            eta2_minus_1: R::select(outside, from_outside, from_inside),
        }
    }

    /// (F, η·cosθt): the reflectance, 1 under total internal reflection and exactly 0 for η = 1; and the cosine of
    /// the refracted direction times η, 0 under total internal reflection.
    ///
    /// With g = η cosθt = √(η² − 1 + cos²), the amplitudes are (c − g)/(c + g) and (η²c − g)/(η²c + g). Their
    /// numerators are multiplied out so that η² − 1 appears as a factor: nothing cancels as η nears 1.
    #[inline(always)]
    pub fn fresnel(&self, cos: R) -> (R, R) {
        let d = self.eta2_minus_1;
        let g2 = cos.mul_add(cos, d);
        let g = g2.safe_sqrt();
        let sum_s = (cos + g).max_or(R::splat(TINY));
        let sum_p = d.mul_add(cos, cos + g).max_or(R::splat(TINY));
        let r_s = d / (sum_s * sum_s);
        let r_p = d * (d + R::splat(2.0)).mul_add(cos * cos, -R::one()) / (sum_p * sum_p);
        let partial = R::splat(0.5) * r_s.mul_add(r_s, r_p * r_p);
        // Rounding may lift it an ulp above 1 at grazing incidence.
        let f = R::select(g2.gt(R::zero()), partial.min_or(R::one()), R::one());
        // η = 1 at grazing: g² rounds to 0 and is no total reflection.
        (f.masked(!d.eq(R::zero())), g)
    }
}

impl<R: Real> RelativeIor<R> {
    /// 1 − F without its cancellation towards grazing angles: 2cg (1/(c + g)² + η²/(η²c + g)²).
    #[inline(always)]
    pub fn transmittance(&self, cos: R) -> R {
        let d = self.eta2_minus_1;
        let g = cos.mul_add(cos, d).safe_sqrt();
        let inv_s = (cos + g).max_or(R::splat(TINY)).recip();
        let inv_p = d.mul_add(cos, cos + g).max_or(R::splat(TINY)).recip();
        // As (2c/(c + g))·(g/(c + g)): both factors stay in range.
        let s = (cos * inv_s) * (g * inv_s);
        let p = (cos * inv_p) * (g * inv_p) * (d + R::one());
        (R::splat(2.0) * (s + p)).min_or(R::one())
    }
}

/// A metal of complex index eta + ik, in real arithmetic. Domain: eta, k ≥ 0, not both 0, below 1e9.
///
/// With (a + ib)² = (eta + ik)² − sin², the amplitudes' squares are ((a − c)² + b²)/((a + c)² + b²) and that times
/// ((a c − s²)² + b²c²)/((a c + s²)² + b²c²): sums of squares, no cancellation (Born and Wolf, § 14.4.1).
#[inline(always)]
pub fn conductor<R: Real>(cos: R, eta: R, k: R) -> R {
    let half = R::splat(0.5);
    let cos2 = cos * cos;
    let sin2 = (R::one() - cos2).max_or(R::zero());
    let eta_k = eta * k;
    // (a² − b²) and a² + b²; of a and b the larger by its root, the smaller from a·b = eta·k.
    let difference = (eta - k).mul_add(eta + k, -sin2);
    let sum = (R::splat(2.0) * eta_k).mul_add(R::splat(2.0) * eta_k, difference * difference).sqrt();
    let larger = (half * (sum + difference.abs())).sqrt();
    let smaller = eta_k / larger.max_or(R::splat(TINY));
    let metallic = difference.lt(R::zero());
    let a = R::select(metallic, smaller, larger);
    let b = R::select(metallic, larger, smaller);

    let b2 = b * b;
    let (minus_s, plus_s) = (a - cos, a + cos);
    let (minus_p, plus_p) = (a.mul_add(cos, -sin2), a.mul_add(cos, sin2));
    let b2_cos2 = b2 * cos2;
    let r_s = minus_s.mul_add(minus_s, b2) / plus_s.mul_add(plus_s, b2).max_or(R::splat(TINY));
    let ratio = minus_p.mul_add(minus_p, b2_cos2) / plus_p.mul_add(plus_p, b2_cos2).max_or(R::splat(TINY));
    half * r_s.mul_add(ratio, r_s)
}

/// What Schlick's approximation (1994) adds of 1 − f0: (1 − cos)⁵; 0 where rounding lifts the cosine above 1.
#[inline(always)]
pub fn schlick_weight<R: Real>(cos: R) -> R {
    let m = (R::one() - cos).max_or(R::zero());
    let m2 = m * m;
    m2 * m2 * m
}
