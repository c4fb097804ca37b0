//! The formulas as the papers print them, in f64, with unit vectors made exact first.

use super::dot;
use std::f64::consts::PI;

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

/// Walter et al. 2007, eq. 33.
pub fn ggx_d(h: [f64; 3], alpha: f64) -> f64 {
    let cos2 = h[2] * h[2];
    let tan2 = (h[0] * h[0] + h[1] * h[1]) / cos2;
    alpha * alpha / (PI * cos2 * cos2 * (alpha * alpha + tan2).powi(2))
}

fn lambda(w: [f64; 3], alpha: f64) -> f64 {
    let tan2 = (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2]);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

fn g1(w: [f64; 3], alpha: f64) -> f64 {
    1.0 / (1.0 + lambda(w, alpha))
}

fn g2(wo: [f64; 3], wi: [f64; 3], alpha: f64, separable: bool) -> f64 {
    if separable { g1(wo, alpha) * g1(wi, alpha) } else { 1.0 / (1.0 + lambda(wo, alpha) + lambda(wi, alpha)) }
}

/// Fresnel equations with Snell's law; `eta` = n_t/n_i.
pub fn dielectric_f(cos_i: f64, eta: f64) -> f64 {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    0.5 * (s * s + p * p)
}

/// The same with a complex index, in complex arithmetic.
pub fn conductor_f(cos_i: f64, eta: f64, k: f64) -> f64 {
    type C = (f64, f64);
    let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let norm = |a: C| a.0 * a.0 + a.1 * a.1;
    let n2 = mul((eta, k), (eta, k));
    // n cosθt = √(n² − sin²), the root with a positive real part.
    let z = (n2.0 - (1.0 - cos_i * cos_i), n2.1);
    let r = norm(z).sqrt();
    let root = ((0.5 * (r + z.0)).max(0.0).sqrt(), (0.5 * (r - z.0)).max(0.0).sqrt());
    let ratio = |a: C, b: C| norm((a.0 - b.0, a.1 - b.1)) / norm((a.0 + b.0, a.1 + b.1));
    0.5 * (ratio((cos_i, 0.0), root) + ratio(mul(n2, (cos_i, 0.0)), root))
}

/// (f·|cosθi|, pdf) of GGX reflection without Fresnel, `wo` and `wi` above the horizon.
pub fn conductor(wo: [f64; 3], wi: [f64; 3], alpha: f64, separable: bool) -> [f64; 2] {
    let (wo, wi) = (unit(wo), unit(wi));
    let h = unit([wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]]);
    let d = ggx_d(h, alpha);
    [d * g2(wo, wi, alpha, separable) / (4.0 * wo[2]), g1(wo, alpha) * d * dot(wo, h) / wo[2] / (4.0 * dot(wo, h))]
}

/// (f·|cosθi|, pdf) of a rough dielectric, Walter et al. 2007, eqs. 16–21, radiance transported.
pub fn dielectric(wo: [f64; 3], wi: [f64; 3], alpha: f64, separable: bool, ior: f64) -> [f64; 2] {
    let (wo, wi) = (unit(wo), unit(wi));
    let (n_o, n_i) = if wo[2] > 0.0 { (1.0, ior) } else { (ior, 1.0) };
    let reflects = wo[2] * wi[2] > 0.0;
    let n_i = if reflects { n_o } else { n_i };
    let up = |v: [f64; 3]| if v[2] < 0.0 { v.map(|x| -x) } else { v };
    let h = up(unit(std::array::from_fn(|k| n_o * wo[k] + n_i * wi[k])));
    // The normal on the side of wo.
    let m = if wo[2] > 0.0 { h } else { h.map(|x| -x) };
    let (c_o, c_i) = (dot(wo, m), dot(wi, m));
    if c_o <= 0.0 || (c_i > 0.0) != reflects {
        return [0.0; 2];
    }
    let f = dielectric_f(c_o, ior.powf(wo[2].signum()));
    let (d, g) = (ggx_d(h, alpha), g2(wo, wi, alpha, separable));
    let visible = g1(wo, alpha) * d * c_o / wo[2].abs();
    if reflects {
        return [f * d * g / (4.0 * wo[2].abs()), f * visible / (4.0 * c_o)];
    }
    let squared = (n_o * c_o + n_i * c_i).powi(2);
    let importance = (c_i * c_o).abs() / wo[2].abs() * n_i * n_i * (1.0 - f) * g * d / squared;
    // Radiance is compressed by (n_o/n_i)² on its way from wi's side.
    [importance * (n_o / n_i).powi(2), (1.0 - f) * visible * n_i * n_i * c_i.abs() / squared]
}
