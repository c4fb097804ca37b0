//! The GGX distribution of microfacet normals (Walter, Marschner, Li, Torrance 2007) and Smith's masking (Heitz 2014).

use super::vec3::V3;
use octolux::scene::Masking;
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    pub alpha: f64,
    pub masking: Masking,
}

impl Ggx {
    /// D(m), per steradian of m; 0 below the horizon. Walter eq. 33 in terms of tan².
    pub fn d(&self, m: V3) -> f64 {
        if m.z() <= 0.0 {
            return 0.0;
        }
        let (c2, a2) = (m.z() * m.z(), self.alpha * self.alpha);
        let tan2 = (m.x() * m.x() + m.y() * m.y()) / c2;
        a2 / (PI * c2 * c2 * (a2 + tan2).powi(2))
    }

    /// Heitz 2014, eq. 72.
    fn lambda(&self, w: V3) -> f64 {
        let tan2 = (w.x() * w.x() + w.y() * w.y()) / (w.z() * w.z());
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// The part of facets of normal `m` seen from both `wo` and `wi`; 0 where either sees the facet from behind.
    pub fn g2(&self, wo: V3, wi: V3, m: V3) -> f64 {
        if wo.dot(m) * wo.z() <= 0.0 || wi.dot(m) * wi.z() <= 0.0 {
            return 0.0;
        }
        let (lo, li) = (self.lambda(wo), self.lambda(wi));
        match self.masking {
            Masking::Correlated => 1.0 / (1.0 + lo + li),
            Masking::Separable => 1.0 / ((1.0 + lo) * (1.0 + li)),
        }
    }

    /// A normal with density D(m) m_z: `u[0]` is the distribution of tan²θ/(α² + tan²θ).
    pub fn normal(&self, u: [f64; 2]) -> V3 {
        let tan = self.alpha * (u[0] / (1.0 - u[0])).sqrt();
        let z = 1.0 / (1.0 + tan * tan).sqrt();
        let (s, c) = (2.0 * PI * u[1]).sin_cos();
        V3::new(tan * z * c, tan * z * s, z)
    }
}
