//! How much is reflected.

/// Unpolarised reflectance of a dielectric; `eta` = index behind / index in front, `cos_i` in [0, 1] on the incident side.
/// 1 under total internal reflection. Hecht, Optics, § 4.6.
pub fn fresnel_dielectric(cos_i: f64, eta: f64) -> f64 {
    // sin²θt = (1 − cos²θi)/η², so cos²θt = ((η − 1)(η + 1) + cos²θi)/η², which keeps its digits for η near 1.
    let g2 = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
    if g2 <= 0.0 {
        return if eta == 1.0 { 0.0 } else { 1.0 };
    }
    let g = g2.sqrt(); // η cosθt
    // r_s = (c − g)/(c + g) and c − g = (c² − g²)/(c + g) = −(η² − 1)/(c + g).
    let m = (eta - 1.0) * (eta + 1.0);
    let rs = -m / ((cos_i + g) * (cos_i + g));
    // r_p = (η² c − g)/(η² c + g), with η² c − g = m c + (c − g).
    let rp = (m * cos_i - m / (cos_i + g)) / (eta * eta * cos_i + g);
    0.5 * (rs * rs + rp * rp)
}

/// Unpolarised reflectance of a metal of index η + ik seen from index 1 (Born & Wolf, § 14.2).
pub fn fresnel_conductor(cos_i: f64, eta: f64, k: f64) -> f64 {
    // With n² = (η + ik)² and (a + ib)² = n² − sin²θ: r_s = (c − (a + ib))/(c + (a + ib)), r_p = (n²c − (a + ib))/(n²c + (a + ib)).
    let sin2 = 1.0 - cos_i * cos_i;
    let (n2_re, n2_im) = (eta * eta - k * k, 2.0 * eta * k);
    let (re, im) = (n2_re - sin2, n2_im);
    let modulus = re.hypot(im);
    let a = (0.5 * (modulus + re)).max(0.0).sqrt();
    let b = (0.5 * (modulus - re)).max(0.0).sqrt();
    let ratio = |x_re: f64, x_im: f64| {
        let top = (x_re - a).powi(2) + (x_im - b).powi(2);
        top / ((x_re + a).powi(2) + (x_im + b).powi(2))
    };
    0.5 * (ratio(cos_i, 0.0) + ratio(n2_re * cos_i, n2_im * cos_i))
}

/// Schlick 1994.
pub fn fresnel_schlick(cos_i: f64, f0: f64) -> f64 {
    f0 + (1.0 - f0) * (1.0 - cos_i).powi(5)
}
