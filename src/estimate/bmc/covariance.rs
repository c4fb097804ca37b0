//! Covariances of radiance in two directions.

use serde::Serialize;

/// k(ω, ω′) for unit vectors, a function of their angle alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Covariance {
    /// exp(−|ω−ω′|²/2ℓ²), the spherical Gaussian exp((ω·ω′ − 1)/ℓ²). Analytic functions: it is stiff where ℓ is long.
    SquaredExponential { length: f64 },
    /// 2^(2s−1)/s − |ω−ω′|^(2s−2), 1 < s < 2: the Sobolev space H^s of the sphere (Brauchart & Dick 2013; for
    /// rendering Marques, Bouville, Santos, Bouatouch 2015, "Efficient Quadrature Rules for Illumination Integrals").
    Sobolev { smoothness: f64 },
}

impl Covariance {
    /// s of [`Self::SOBOLEV`], by measurement: on good points s changes nothing behind a visibility edge, and under smooth
    /// skies 1.7 errs by 30 % less than 1.5. Beyond, random points are ill-conditioned (`scenes/course/README.md`).
    pub const SMOOTHNESS: f64 = 1.7;
    /// The default.
    pub const SOBOLEV: Self = Self::Sobolev { smoothness: Self::SMOOTHNESS };

    /// Is it a covariance? Else what its parameter must be.
    pub fn check(self) -> Result<Self, String> {
        match self {
            Self::SquaredExponential { length } if !(0.01..=100.0).contains(&length) => {
                Err(format!("a length-scale of {length}; give one from 0.01 to 100 (of the chord of the unit sphere)"))
            }
            Self::Sobolev { smoothness } if !(1.05..=1.95).contains(&smoothness) => {
                Err(format!("a smoothness of {smoothness}; give one from 1.05 to 1.95"))
            }
            _ => Ok(self),
        }
    }

    /// Of the squared chord |ω−ω′|², in [0, 4].
    #[inline]
    pub fn of_chord2(self, chord2: f64) -> f64 {
        match self {
            Self::SquaredExponential { length } => (-0.5 * chord2 / (length * length)).exp(),
            Self::Sobolev { smoothness: 1.5 } => 8.0 / 3.0 - chord2.sqrt(),
            Self::Sobolev { smoothness: s } => (2.0 * s - 1.0).exp2() / s - chord2.powf(s - 1.0),
        }
    }

    /// Of two unit vectors. Through their difference: 2 − 2ω·ω′ would cancel between neighbours.
    pub fn between(self, a: [f64; 3], b: [f64; 3]) -> f64 {
        let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        self.of_chord2(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    }

    /// The smallest angle over which it changes: what a quadrature must resolve.
    pub(super) fn scale(self) -> f64 {
        match self {
            Self::SquaredExponential { length } => length.min(1.0),
            Self::Sobolev { .. } => 1.0,
        }
    }
}
