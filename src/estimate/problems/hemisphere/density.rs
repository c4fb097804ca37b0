//! Densities of directions about the normal, for importance sampling.

use super::field::{Field, Sky};
use super::learned::{Learned, spherical};
use crate::lane::{Real, Vec3, math};
use crate::sampling::{Frame, rescale, warp};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

#[derive(Clone, Debug, PartialEq)]
pub enum Density {
    /// 1/2π.
    Uniform,
    /// cosθ/π.
    Cosine,
    /// (n + 1)/2π cosⁿθ: a Phong lobe about the normal.
    Phong(f64),
    /// Normals of a GGX surface of roughness α, D(ω) cosθ.
    Ggx(f64),
    /// Half by cosine, half uniform in a cone (axis, cosine): one-sample multiple importance sampling with the balance
    /// heuristic (Veach & Guibas 1995).
    Mis([f64; 3], f64),
    /// From a pilot of the integrand.
    Learned(Arc<Learned>),
}

impl Density {
    /// From its name: uniform, cosine, phongN, ggxA, mis (towards the sun of `field`), learned (from `field`).
    pub fn parse(name: &str, field: &Field) -> Option<Self> {
        let number = |prefix: &str| name.strip_prefix(prefix)?.parse::<f64>().ok().filter(|x| x.is_finite());
        match (name, field) {
            ("uniform", _) => Some(Self::Uniform),
            ("cosine", _) => Some(Self::Cosine),
            ("learned", _) => Some(Self::Learned(Arc::new(Learned::new(field)))),
            ("mis", Field::Sky(Sky { sun: Some((axis, cos, _)), .. })) => Some(Self::Mis(*axis, *cos)),
            _ => number("phong")
                .filter(|n| (0.0..=1e4).contains(n))
                .map(Self::Phong)
                .or_else(|| number("ggx").filter(|a| (0.01..=1.0).contains(a)).map(Self::Ggx)),
        }
    }

    /// Per steradian.
    pub fn at(&self, w: [f64; 3]) -> f64 {
        match *self {
            Self::Uniform => 1.0 / TAU,
            Self::Cosine => w[2] / PI,
            Self::Phong(n) => (n + 1.0) / TAU * w[2].powf(n),
            Self::Ggx(alpha) => {
                let (a2, c2) = (alpha * alpha, w[2] * w[2]);
                // sin² + cos²·α² is what is left of 1 + cos²(α² − 1).
                let shape = (1.0 - c2) + c2 * a2;
                a2 * w[2] / (PI * shape * shape)
            }
            Self::Mis(axis, cos) => {
                let inside = axis[0] * w[0] + axis[1] * w[1] + axis[2] * w[2] >= cos;
                0.5 * w[2] / PI + if inside { 0.5 / (TAU * (1.0 - cos)) } else { 0.0 }
            }
            Self::Learned(ref learned) => learned.at(w),
        }
    }

    /// A direction and its density.
    #[inline(always)]
    pub fn sample<R: Real>(&self, u: [R; 2]) -> (Vec3<R>, R) {
        match *self {
            Self::Uniform => {
                let w = warp::uniform_hemisphere(u);
                (w, warp::uniform_hemisphere_pdf(w.z))
            }
            Self::Cosine => {
                let w = warp::cosine_hemisphere(u);
                (w, warp::cosine_hemisphere_pdf(w.z))
            }
            Self::Phong(n) => {
                // cosθ = (1 − u)^(1/(n+1)); 1 − cos² by the same exponential keeps its digits near the axis.
                let log = math::ln(R::one() - u[0]) * R::splat((1.0 / (n + 1.0)) as f32);
                let cos = math::exp(log);
                let pdf = R::splat(((n + 1.0) / TAU) as f32) * math::exp(log * R::splat(n as f32));
                (spherical(cos, u[1]), pdf)
            }
            Self::Ggx(alpha) => {
                let a2 = R::splat((alpha * alpha) as f32);
                // tan²θ = α² u/(1 − u) (Walter et al. 2007, eq. 35).
                let cos2 = (R::one() - u[0]) / (R::one() - u[0] + a2 * u[0]);
                let cos = cos2.sqrt();
                let shape = (R::one() - cos2) + cos2 * a2;
                (spherical(cos, u[1]), a2 * cos / (R::splat(PI as f32) * shape * shape))
            }
            Self::Mis(axis, cos) => {
                let half = R::splat(0.5);
                let first = u[0].lt(half);
                let low = rescale(u[0], R::zero(), half);
                let high = rescale(u[0], half, R::one());
                let cosine = warp::cosine_hemisphere([low, u[1]]);
                let narrow = R::splat((1.0 - cos) as f32);
                let axis = Vec3::splat(axis.map(|a| a as f32));
                let cone = Frame::from_normal(axis).to_world(warp::uniform_cone([high, u[1]], narrow));
                let w = Vec3::new(
                    R::select(first, cosine.x, cone.x),
                    R::select(first, cosine.y, cone.y),
                    R::select(first, cosine.z, cone.z),
                );
                let inside = w.dot(axis).ge(R::splat(cos as f32)) | !first;
                let pdf =
                    half * warp::cosine_hemisphere_pdf(w.z) + (half * warp::uniform_cone_pdf(narrow)).masked(inside);
                (w, pdf)
            }
            Self::Learned(ref learned) => {
                let (cos, turn, pdf) = learned.sample(u);
                (spherical(cos, turn), pdf)
            }
        }
    }
}
