//! The known factor p of the integrand, and what the covariance integrates to against it.

use super::covariance::Covariance;
use crate::estimate::rules::Gauss;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// p(ω), symmetric about +z, not normalised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// cosᵐθ on the upper hemisphere: 0 uniform, 1 Lambert's cosine. Domain: 0 ≤ m ≤ 256.
    PowerCosine { exponent: f64 },
    /// amplitude · exp(λ(cosθ − 1)) on the whole sphere. Domain: 0 < λ ≤ 1e4.
    Lobe { sharpness: f64, amplitude: f64 },
    /// (1 + κ(1 − cosθ))⁻² on the whole sphere, with the tail of a GGX lobe about the mirror direction where
    /// κ = 1/2α²: D falls as (1 + tan²θ_h/α²)⁻², and θ = 2θ_h. Domain: 0 < κ ≤ 1e4.
    Microfacet { kappa: f64 },
}

impl Measure {
    pub const UNIFORM: Self = Self::PowerCosine { exponent: 0.0 };
    pub const COSINE: Self = Self::PowerCosine { exponent: 1.0 };

    /// Is it 0 below the horizon?
    pub fn has_horizon(self) -> bool {
        matches!(self, Self::PowerCosine { .. })
    }

    /// P = ∫ p.
    pub fn total(self) -> f64 {
        match self {
            Self::PowerCosine { exponent } => TAU / (exponent + 1.0),
            Self::Lobe { sharpness, amplitude } => TAU * amplitude * -f64::exp_m1(-2.0 * sharpness) / sharpness,
            Self::Microfacet { kappa } => 2.0 * TAU / (1.0 + 2.0 * kappa),
        }
    }

    /// p at cosθ.
    pub fn density(self, cos_theta: f64) -> f64 {
        match self {
            Self::PowerCosine { .. } if cos_theta < 0.0 => 0.0,
            Self::PowerCosine { exponent: 0.0 } => 1.0,
            Self::PowerCosine { exponent } => cos_theta.powf(exponent),
            Self::Lobe { sharpness, amplitude } => amplitude * (sharpness * (cos_theta - 1.0)).exp(),
            Self::Microfacet { kappa } => (1.0 + kappa * (1.0 - cos_theta)).powi(-2),
        }
    }

    /// cosθ of which a fraction `u` of p lies nearer to the axis: u = 0 is the axis.
    pub fn inverse_cdf(self, u: f64) -> f64 {
        match self {
            Self::PowerCosine { exponent } => (1.0 - u).powf(1.0 / (exponent + 1.0)),
            Self::Lobe { sharpness, .. } => {
                let rest = f64::exp_m1(-2.0 * sharpness);
                (1.0 + (u * rest).ln_1p() / sharpness).clamp(-1.0, 1.0)
            }
            Self::Microfacet { kappa } => {
                let part = 2.0 * u / (1.0 + 2.0 * kappa);
                (1.0 - part / (1.0 - kappa * part)).clamp(-1.0, 1.0)
            }
        }
    }

    /// z(ω′) = ∫ k(ω′, ω) p(ω) dω for ω′ at polar angle `theta`: where p > 0, so up to π/2 for a power of the cosine.
    pub fn embedding(self, k: Covariance, theta: f64, rules: &Rules) -> f64 {
        if let (Self::Lobe { sharpness, amplitude }, Covariance::SquaredExponential { length }) = (self, k) {
            return lobe_product(sharpness, amplitude, length, theta.cos());
        }
        // In polar coordinates about ω′ the covariance depends on the angle γ alone, its kink sits at the end γ = 0,
        // and p needs only its mean around each circle.
        let (sin, cos) = theta.sin_cos();
        let ring = |gamma: f64| {
            let (s, c) = gamma.sin_cos();
            let half = (0.5 * gamma).sin();
            k.of_chord2(4.0 * half * half) * s * self.around(cos * c, sin * s, rules)
        };
        match self {
            Self::PowerCosine { exponent } => {
                // Circles about ω′ lie above the horizon up to the first angle and cut it up to the second.
                let fine = 1.0 + 0.25 * exponent.sqrt();
                let (whole, cut) = (FRAC_PI_2 - theta, FRAC_PI_2 + theta);
                squared(rules, k, fine, [0.0, whole], ring) + rounded(rules, k, fine, [whole, cut], ring)
            }
            Self::Lobe { sharpness, .. } | Self::Microfacet { kappa: sharpness } => {
                let fine = 1.0 + 0.5 * sharpness.sqrt();
                squared(rules, k, fine, [0.0, theta], ring) + rounded(rules, k, fine, [theta, PI], ring)
            }
        }
    }

    /// ∫₀^2π p(a + b cosψ) dψ, b ≥ 0.
    fn around(self, a: f64, b: f64, rules: &Rules) -> f64 {
        match self {
            Self::PowerCosine { exponent } => {
                let last = if a >= b {
                    PI
                } else if a <= -b {
                    return 0.0;
                } else {
                    (-a / b).acos()
                };
                match exponent {
                    0.0 => 2.0 * last,
                    1.0 => 2.0 * (a * last + b * last.sin()),
                    m => {
                        let panels = 1 + (m.sqrt() / 4.0) as usize;
                        let arc = |psi: f64| (a + b * psi.cos()).max(0.0).powf(m);
                        2.0 * rules.angle.integrate([0.0, last], panels, arc)
                    }
                }
            }
            Self::Lobe { sharpness, amplitude } => {
                let peak = (sharpness * (a + b - 1.0)).exp();
                TAU * amplitude * peak * bessel_i0e(sharpness * b)
            }
            // ∫ dψ/(A − B cosψ)² = 2πA/(A² − B²)^(3/2), the difference by its factors.
            Self::Microfacet { kappa } => {
                let (middle, half) = (1.0 + kappa * (1.0 - a), kappa * b);
                TAU * middle * ((middle - half) * (middle + half)).powf(-1.5)
            }
        }
    }

    /// V₀ = ∬ k p p.
    pub fn self_energy(self, k: Covariance, rules: &Rules) -> f64 {
        // t² keeps a power of cosθ smooth at the horizon, and at the axis spreads a narrow lobe.
        match self {
            Self::PowerCosine { exponent } => {
                let panels = 1 + (exponent.sqrt() / 4.0) as usize;
                let ring = |t: f64| {
                    let u = t * t;
                    2.0 * t * self.density(u) * self.embedding(k, u.acos(), rules)
                };
                TAU * rules.outer.integrate([0.0, 1.0], panels, ring)
            }
            Self::Lobe { sharpness, .. } | Self::Microfacet { kappa: sharpness } => {
                let panels = 1 + (sharpness.sqrt() / 3.0) as usize;
                let ring = |t: f64| {
                    let u = 1.0 - 2.0 * t * t;
                    4.0 * t * self.density(u) * self.embedding(k, u.acos(), rules)
                };
                TAU * rules.outer.integrate([0.0, 1.0], panels, ring)
            }
        }
    }
}

/// The quadratures of this room, made once.
#[derive(Clone, Debug)]
pub struct Rules {
    polar: Gauss,
    angle: Gauss,
    outer: Gauss,
}

impl Rules {
    pub fn new() -> Self {
        Self { polar: Gauss::new(32), angle: Gauss::new(32), outer: Gauss::new(48) }
    }
}

impl Default for Rules {
    fn default() -> Self {
        Self::new()
    }
}

fn panels(k: Covariance, fine: f64, length: f64) -> usize {
    (fine * length / (4.0 * k.scale())).ceil().max(1.0) as usize
}

/// Over [a, b] with γ = a + (b − a)t²: for a power of γ − a at the start.
fn squared(rules: &Rules, k: Covariance, fine: f64, [a, b]: [f64; 2], ring: impl Fn(f64) -> f64) -> f64 {
    if b <= a {
        return 0.0;
    }
    let inside = |t: f64| 2.0 * t * (b - a) * ring(a + (b - a) * t * t);
    rules.polar.integrate([0.0, 1.0], panels(k, fine, b - a), inside)
}

/// Over [a, b] with γ = middle + half·sin(πt/2): for square roots at both ends.
fn rounded(rules: &Rules, k: Covariance, fine: f64, [a, b]: [f64; 2], ring: impl Fn(f64) -> f64) -> f64 {
    if b <= a {
        return 0.0;
    }
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let inside = |t: f64| {
        let (s, c) = (FRAC_PI_2 * t).sin_cos();
        FRAC_PI_2 * half * c * ring(middle + half * s)
    };
    rules.polar.integrate([-1.0, 1.0], 1 + panels(k, fine, b - a), inside)
}

/// ∫ of the product of two spherical Gaussians, one of them A·exp(λ_p(ω·m − 1)): 2πA(e^(ρ−λ−λ_p) − e^(−ρ−λ−λ_p))/ρ
/// with ρ = |λω′ + λ_p m|.
fn lobe_product(sharpness: f64, amplitude: f64, length: f64, cos_theta: f64) -> f64 {
    let lambda = 1.0 / (length * length);
    let sum = lambda + sharpness;
    let rho = (lambda * lambda + sharpness * sharpness + 2.0 * lambda * sharpness * cos_theta).max(0.0).sqrt();
    if rho < 1e-8 * sum {
        return 2.0 * TAU * amplitude * (-sum).exp();
    }
    // ρ² − (λ + λ_p)² without cancellation.
    let exponent = 2.0 * lambda * sharpness * (cos_theta - 1.0) / (rho + sum);
    TAU * amplitude * exponent.exp() * -f64::exp_m1(-2.0 * rho) / rho
}

/// e^−b I₀(b), b ≥ 0: the mean of exp(b(cosψ − 1)) around a circle. Equal steps of 0.7/√b converge to the last bits.
pub fn bessel_i0e(b: f64) -> f64 {
    let n = 16 + (9.0 * b.sqrt()) as usize;
    let step = PI / n as f64;
    let term = |i: usize| {
        let half = (0.5 * step * i as f64).sin();
        (-2.0 * b * half * half).exp()
    };
    let inner: f64 = (1..n).map(term).sum();
    (inner + 0.5 * (term(0) + term(n))) / n as f64
}
