//! Scattering functions in the local frame (z = n_s), their plain sampling, and their albedo by quadrature.

use super::fresnel::{fresnel_conductor, fresnel_dielectric, fresnel_schlick};
use super::ggx::Ggx;
use super::vec3::{Frame, V3};
use crate::stats::Rng;
use crate::stats::quadrature::{Adaptive, Rect};
use octolux::scene::{Bsdf, ConductorFresnel};
use std::f64::consts::PI;

/// f(wo, wi)·|cosθi| a channel, for radiance arriving from `wi` (both unit vectors point away from the surface).
///
/// 0 for mirrors and smooth glass. Through a dielectric, radiance is carried: f includes (η_o/η_i)², the indices on the
/// sides of `wo` and `wi`.
pub fn bsdf_eval(bsdf: &Bsdf, wo: [f64; 3], wi: [f64; 3]) -> [f64; 3] {
    let (wo, wi) = (V3(wo), V3(wi));
    if wo.z() == 0.0 || wi.z() == 0.0 {
        return [0.0; 3];
    }
    let same_side = wo.z() * wi.z() > 0.0;
    match *bsdf {
        Bsdf::Diffuse { reflectance } if same_side => reflectance.map(|r| f64::from(r) / PI * wi.z().abs()),
        Bsdf::Conductor { alpha, masking, fresnel } if same_side && alpha > 0.0 => {
            let m = upward(wo + wi);
            let value = reflection(&Ggx { alpha: alpha.into(), masking }, wo, wi, m);
            conductor_fresnel(&fresnel, wo.dot(m).abs()).map(|f| f * value)
        }
        Bsdf::Dielectric { alpha, masking, ior } if alpha > 0.0 && ior != 1.0 => {
            let ggx = Ggx { alpha: alpha.into(), masking };
            [rough_dielectric(&ggx, ior.into(), wo, wi, same_side); 3]
        }
        Bsdf::Phong { diffuse, specular, exponent } if same_side => {
            let lobe = phong_lobe(exponent.into(), wo, wi);
            std::array::from_fn(|c| {
                (f64::from(diffuse[c]) / PI + f64::from(specular[c]) * (f64::from(exponent) + 2.0) * lobe)
                    * wi.z().abs()
            })
        }
        Bsdf::Coated { reflectance, alpha, masking, ior } if same_side => {
            let through = |w: V3| 1.0 - fresnel_dielectric(w.z().abs(), ior.into());
            let base = through(wo) * through(wi) / PI * wi.z().abs();
            let coat = if alpha > 0.0 {
                let m = upward(wo + wi);
                let f = fresnel_dielectric(wo.dot(m).abs(), ior.into());
                f * reflection(&Ggx { alpha: alpha.into(), masking }, wo, wi, m)
            } else {
                0.0
            };
            reflectance.map(|r| f64::from(r) * base + coat)
        }
        _ => [0.0; 3],
    }
}

/// Is all of its scattering into single directions?
pub fn is_delta(bsdf: &Bsdf) -> bool {
    match *bsdf {
        Bsdf::Diffuse { .. } | Bsdf::Phong { .. } | Bsdf::Coated { .. } => false,
        Bsdf::Conductor { alpha, .. } => alpha == 0.0,
        Bsdf::Dielectric { alpha, ior, .. } => alpha == 0.0 || ior == 1.0,
    }
}

/// cosⁿα/2π, α between `wi` and the mirror direction of `wo`; 0 from 90° on.
fn phong_lobe(n: f64, wo: V3, wi: V3) -> f64 {
    let cos = reflect(wo, V3::Z).dot(wi);
    if cos > 0.0 { cos.powf(n) / (2.0 * PI) } else { 0.0 }
}

/// Index behind the surface over index in front, as seen from `w`.
fn relative_eta(ior: f64, w: V3) -> f64 {
    if w.z() > 0.0 { ior } else { 1.0 / ior }
}

fn upward(v: V3) -> V3 {
    v.unit() * v.z().signum()
}

fn conductor_fresnel(fresnel: &ConductorFresnel, cos: f64) -> [f64; 3] {
    std::array::from_fn(|c| match fresnel {
        ConductorFresnel::Exact { eta, k } => fresnel_conductor(cos, eta[c].into(), k[c].into()),
        ConductorFresnel::Schlick { f0 } => fresnel_schlick(cos, f0[c].into()),
        ConductorFresnel::Constant { reflectance } => reflectance[c].into(),
    })
}

/// Walter et al. 2007, eq. 20 without F, times |cosθi|.
fn reflection(ggx: &Ggx, wo: V3, wi: V3, m: V3) -> f64 {
    ggx.d(m) * ggx.g2(wo, wi, m) / (4.0 * wo.z().abs())
}

/// Walter et al. 2007, eqs. 20 and 21 times |cosθi|; the density of half vectors turns into one of `wi` by eqs. 14 and 17.
fn rough_dielectric(ggx: &Ggx, ior: f64, wo: V3, wi: V3, same_side: bool) -> f64 {
    let eta = relative_eta(ior, wo); // η_i/η_o: `wi` is behind
    if same_side {
        let m = upward(wo + wi);
        return fresnel_dielectric(wo.dot(m).abs(), eta) * reflection(ggx, wo, wi, m);
    }
    let m = upward(wo + wi * eta);
    let (o, i) = (wo.dot(m), wi.dot(m));
    if o * i >= 0.0 {
        return 0.0;
    }
    let transmitted = 1.0 - fresnel_dielectric(o.abs(), eta);
    (o * i).abs() / wo.z().abs() * transmitted * ggx.d(m) * ggx.g2(wo, wi, m) / (o + eta * i).powi(2)
}

/// A direction and its throughput f·|cosθ|/pdf.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    pub wi: V3,
    pub weight: V3,
    /// `wi` is the only direction of its lobe.
    pub delta: bool,
}

/// Samples `wi`: cosine for Lambert, half vectors from D(m) m_z for GGX, Fresnel's share for what passes. The weight is
/// [`bsdf_eval`] over the density, not a cancelled form.
pub fn sample(bsdf: &Bsdf, wo: V3, rng: &mut Rng) -> Option<Sampled> {
    let u = [rng.f64(), rng.f64()];
    let (wi, density) = match *bsdf {
        Bsdf::Diffuse { .. } => {
            let wi = cosine(wo, u);
            (wi, wi.z().abs() / PI)
        }
        Bsdf::Phong { exponent, .. } => {
            let n = f64::from(exponent);
            let wi = if rng.f64() < 0.5 { about_mirror(n, wo, u) } else { cosine(wo, u) };
            (wi, 0.5 * (wi.z().abs() / PI + (n + 1.0) * phong_lobe(n, wo, wi)))
        }
        Bsdf::Coated { alpha, masking, ior, .. } => {
            let to_coat = rng.f64() < 0.5;
            let ggx = Ggx { alpha: alpha.into(), masking };
            if alpha == 0.0 {
                if to_coat {
                    let f = fresnel_dielectric(wo.z().abs(), ior.into());
                    return Some(Sampled { wi: reflect(wo, V3::Z), weight: V3([2.0 * f; 3]), delta: true });
                }
                let wi = cosine(wo, u);
                (wi, 0.5 * wi.z().abs() / PI)
            } else {
                let wi = if to_coat { reflect(wo, ggx.normal(u)) } else { cosine(wo, u) };
                let m = upward(wo + wi);
                (wi, 0.5 * (wi.z().abs() / PI + ggx.d(m) * m.z() / (4.0 * wo.dot(m).abs())))
            }
        }
        Bsdf::Conductor { alpha, masking, fresnel } => {
            if alpha == 0.0 {
                let weight = V3(conductor_fresnel(&fresnel, wo.z().abs()));
                return Some(Sampled { wi: reflect(wo, V3::Z), weight, delta: true });
            }
            let ggx = Ggx { alpha: alpha.into(), masking };
            let m = ggx.normal(u);
            (reflect(wo, m), ggx.d(m) * m.z() / (4.0 * wo.dot(m).abs()))
        }
        Bsdf::Dielectric { alpha, masking, ior } => return dielectric(bsdf, (alpha, masking, ior), wo, u, rng.f64()),
    };
    let weight = V3(bsdf_eval(bsdf, wo.0, wi.0)) * (1.0 / density);
    (weight.max_component() > 0.0).then_some(Sampled { wi, weight, delta: false })
}

/// The hemisphere of `wo` by cosine.
fn cosine(wo: V3, u: [f64; 2]) -> V3 {
    let (s, c) = (2.0 * PI * u[1]).sin_cos();
    let (r, z) = (u[0].sqrt(), (1.0 - u[0]).sqrt());
    V3::new(r * c, r * s, z * wo.z().signum())
}

/// With density (n + 1)/2π cosⁿα.
fn about_mirror(n: f64, wo: V3, u: [f64; 2]) -> V3 {
    let cos = u[0].powf(1.0 / (n + 1.0));
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (2.0 * PI * u[1]).sin_cos();
    Frame::about(reflect(wo, V3::Z)).to_world(V3::new(sin * c, sin * s, cos))
}

fn dielectric(
    bsdf: &Bsdf,
    (alpha, masking, ior): (f32, octolux::scene::Masking, f32),
    wo: V3,
    u: [f64; 2],
    choice: f64,
) -> Option<Sampled> {
    let eta = relative_eta(ior.into(), wo);
    let smooth = is_delta(bsdf);
    let ggx = Ggx { alpha: alpha.into(), masking };
    let m = if smooth { V3::Z } else { ggx.normal(u) };
    if wo.dot(m) * wo.z() <= 0.0 {
        return None;
    }
    let f = fresnel_dielectric(wo.dot(m).abs(), eta);
    let reflected = choice < f;
    let wi = if reflected { reflect(wo, m) } else { refract(wo, m, eta)? };
    if smooth {
        let scale = if reflected { 1.0 } else { 1.0 / (eta * eta) };
        return Some(Sampled { wi, weight: V3([scale; 3]), delta: true });
    }
    // A "reflection" through the surface, or a "refraction" that stays, is no path of this single-scattering model.
    if (wi.z() * wo.z() > 0.0) != reflected {
        return None;
    }
    let density = ggx.d(m) * m.z() * if reflected { f } else { 1.0 - f } / jacobian(wo, wi, m, eta, reflected);
    let weight = V3(bsdf_eval(bsdf, wo.0, wi.0)) * (1.0 / density);
    (weight.max_component() > 0.0).then_some(Sampled { wi, weight, delta: false })
}

fn reflect(wo: V3, m: V3) -> V3 {
    m * (2.0 * wo.dot(m)) - wo
}

/// Snell's law about `m`; None under total internal reflection.
fn refract(wo: V3, m: V3, eta: f64) -> Option<V3> {
    let c = wo.dot(m);
    let cos2_t = 1.0 - (1.0 - c * c) / (eta * eta);
    (cos2_t > 0.0).then(|| m * (c / eta - c.signum() * cos2_t.sqrt()) - wo * (1.0 / eta))
}

/// dω_i/dω_m.
fn jacobian(wo: V3, wi: V3, m: V3, eta: f64, reflected: bool) -> f64 {
    if reflected {
        return 4.0 * wo.dot(m).abs();
    }
    (wo.dot(m) + eta * wi.dot(m)).powi(2) / (eta * eta * wi.dot(m).abs())
}

/// What leaves for a unit of light from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    /// ∫ f |cosθi| dω_i over the side of `wo`.
    pub reflected: [f64; 3],
    /// … over the other side, radiance's (η_o/η_i)² taken out: the fraction of power.
    pub transmitted: [f64; 3],
}

/// The directional albedo of `wo`, by adaptive quadrature of [`bsdf_eval`] (over half vectors for GGX); absolute error
/// about 1e-7, for rough glass 1e-5. Smooth mirrors and glass by their Fresnel terms.
pub fn directional_albedo(bsdf: &Bsdf, wo: [f64; 3]) -> Albedo {
    let wo = V3(wo);
    let none = [0.0; 3];
    match *bsdf {
        Bsdf::Diffuse { .. } => Albedo { reflected: diffuse_albedo(bsdf, wo), transmitted: none },
        Bsdf::Conductor { alpha: 0.0, fresnel, .. } => {
            Albedo { reflected: conductor_fresnel(&fresnel, wo.z().abs()), transmitted: none }
        }
        Bsdf::Conductor { alpha, masking, .. } => {
            let ggx = Ggx { alpha: alpha.into(), masking };
            Albedo { reflected: half_vector_integral(bsdf, ggx, 1.0, wo, true), transmitted: none }
        }
        Bsdf::Dielectric { ior, .. } if is_delta(bsdf) => {
            let f = fresnel_dielectric(wo.z().abs(), relative_eta(ior.into(), wo));
            Albedo { reflected: [f; 3], transmitted: [1.0 - f; 3] }
        }
        Bsdf::Dielectric { alpha, masking, ior } => {
            let (ggx, eta) = (Ggx { alpha: alpha.into(), masking }, relative_eta(ior.into(), wo));
            let part = |reflected| half_vector_integral(bsdf, ggx, eta, wo, reflected);
            Albedo { reflected: part(true), transmitted: part(false).map(|t| t * eta * eta) }
        }
        Bsdf::Phong { diffuse, specular, exponent } => {
            let n = f64::from(exponent);
            let lobe = |u: f64, v: f64| {
                let wi = about_mirror(n, wo, [u, v]);
                if wi.z() * wo.z() > 0.0 { wi.z().abs() * (n + 2.0) / (n + 1.0) } else { 0.0 }
            };
            let lobe = Adaptive::new(1e-8, lobe).integrate(Rect { x: [0.0, 1.0], y: [0.0, 1.0] }, 3).0;
            let channel = |c: usize| f64::from(diffuse[c]) + f64::from(specular[c]) * lobe;
            Albedo { reflected: std::array::from_fn(channel), transmitted: none }
        }
        Bsdf::Coated { reflectance, alpha, masking, ior } => {
            let f = |z: f64| fresnel_dielectric(z, ior.into());
            let smooth = Bsdf::Coated { reflectance, alpha: 0.0, masking, ior };
            let base = diffuse_albedo(&smooth, wo);
            let coat = if alpha == 0.0 {
                f(wo.z().abs())
            } else {
                let bare = Bsdf::Coated { reflectance: [0.0; 3], alpha, masking, ior };
                half_vector_integral(&bare, Ggx { alpha: alpha.into(), masking }, 1.0, wo, true)[0]
            };
            Albedo { reflected: base.map(|b| b + coat), transmitted: none }
        }
    }
}

fn diffuse_albedo(bsdf: &Bsdf, wo: V3) -> [f64; 3] {
    let square = Rect { x: [0.0, 1.0], y: [0.0, 2.0 * PI] };
    std::array::from_fn(|c| {
        let f = |z: f64, phi: f64| {
            let r = (1.0 - z * z).sqrt();
            bsdf_eval(bsdf, wo.0, [r * phi.cos(), r * phi.sin(), z * wo.z().signum()])[c]
        };
        Adaptive::new(1e-9, f).integrate(square, 1).0
    })
}

/// ∫ f |cosθi| dω_i = ∫ f |cosθi| |dω_i/dω_m| / (D m_z) · D m_z dω_m over half vectors m, in polar coordinates: azimuth
/// from that of `wo`, half way round (the other half is its mirror image), and ψ with tanθm = α tanψ, for which
/// D m_z dω_m = 2 sinψ cosψ dψ dφ/2π is smooth.
fn half_vector_integral(bsdf: &Bsdf, ggx: Ggx, eta: f64, wo: V3, reflected: bool) -> [f64; 3] {
    // From behind, it is the opposite azimuth whose facets lean towards `wo`.
    let azimuth = (wo.y() * wo.z()).atan2(wo.x() * wo.z());
    let tan_o = wo.x().hypot(wo.y()) / wo.z().abs();
    // Total reflection starts with a root, which the adaptive rule follows along a curve.
    let tolerance = if eta == 1.0 { 1e-8 } else { 1e-6 };
    let channel = |c: usize| {
        let f = |t: f64, half_turn: f64| {
            let phi = PI * half_turn;
            // Facets too steep reflect below the horizon: slopes r with (r cosφ − tanθo)² + (r sinφ)² > 1/cos²θo.
            let x = tan_o * phi.cos();
            let steepest = if x > 0.0 { x + x.hypot(1.0) } else { 1.0 / (x.hypot(1.0) - x) };
            let psi_max = if reflected { (steepest / ggx.alpha).atan() } else { 0.5 * PI };
            // Crowds ψ near its end: for small alphas everything of slope 1 is there.
            let rest = 1.0 - t;
            let psi = psi_max * (1.0 - rest * rest * rest);
            let (sin, cos) = psi.sin_cos();
            let m =
                V3::new(ggx.alpha * sin * (azimuth + phi).cos(), ggx.alpha * sin * (azimuth + phi).sin(), cos).unit();
            let wi = if reflected { Some(reflect(wo, m)) } else { refract(wo, m, eta) };
            let Some(wi) = wi.filter(|wi| (wi.z() * wo.z() > 0.0) == reflected) else { return 0.0 };
            let jacobian = jacobian(wo, wi, m, eta, reflected);
            let value = bsdf_eval(bsdf, wo.0, wi.0)[c] * jacobian / (ggx.d(m) * m.z());
            value * 2.0 * sin * cos * psi_max * 3.0 * rest * rest
        };
        Adaptive::new(tolerance, f).integrate(Rect { x: [0.0, 1.0], y: [0.0, 1.0] }, 3).0
    };
    let red = channel(0);
    let grey = match bsdf {
        Bsdf::Conductor { fresnel: ConductorFresnel::Constant { reflectance: [r, g, b] }, .. } => r == g && g == b,
        _ => matches!(bsdf, Bsdf::Dielectric { .. } | Bsdf::Coated { .. }),
    };
    if grey { [red; 3] } else { [red, channel(1), channel(2)] }
}
