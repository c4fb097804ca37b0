//! Scattering models: against f64 formulas, closed forms, their own densities, and themselves at other widths.

mod chi2;
mod coated;
mod consistency;
mod delta;
mod fresnel;
mod ggx;
mod grazing;
mod phong;
mod reference;
mod widths;

use octolux::bsdf::{Coated, Conductor, ConductorFresnel, Dielectric, Phong, Sample};
use octolux::lane::{Mask, Real, Vec3};

/// GGX that reflects everything.
fn white_metal<R: Real>(alpha: f32, separable: bool) -> Conductor<R> {
    let fresnel = ConductorFresnel::constant(Vec3::all(R::one()));
    Conductor { alpha: R::splat(alpha), separable: R::Mask::splat(separable), fresnel }
}

fn glass<R: Real>(alpha: f32, separable: bool, ior: f32) -> Dielectric<R> {
    Dielectric { alpha: R::splat(alpha), separable: R::Mask::splat(separable), ior: R::splat(ior) }
}

fn phong<R: Real>(diffuse: f32, specular: f32, exponent: f32) -> Phong<R> {
    let grey = |x| Vec3::all(R::splat(x));
    Phong { diffuse: grey(diffuse), specular: grey(specular), exponent: R::splat(exponent) }
}

fn coat<R: Real>(reflectance: f32, alpha: f32, separable: bool, ior: f32) -> Coated<R> {
    Coated {
        reflectance: Vec3::all(R::splat(reflectance)),
        alpha: R::splat(alpha),
        separable: R::Mask::splat(separable),
        ior: R::splat(ior),
    }
}

/// The unit vector at cosine `mu` and azimuth `phi`, rounded from f64.
fn at<R: Real>(mu: f64, phi: f64) -> Vec3<R> {
    let s = (1.0 - mu * mu).sqrt();
    Vec3::splat([(s * phi.cos()) as f32, (s * phi.sin()) as f32, mu as f32])
}

fn to_f64(v: [f32; 3]) -> [f64; 3] {
    v.map(f64::from)
}

/// A unit vector of `w`'s direction, rounded to f32.
fn to_lane<R: Real>(w: [f64; 3]) -> Vec3<R> {
    Vec3::splat(w.map(|x| x as f32))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The sampled direction of a lane, if it counts and has a density, made a unit vector in f64 (1 − cos of a narrow lobe has few f32 steps).
fn direction<R: Real>(s: &Sample<R>, lane: usize) -> Option<[f64; 3]> {
    let wi = to_f64(s.wi.lane(lane));
    let length = dot(wi, wi).sqrt();
    (s.valid & !s.delta).lane(lane).then(|| {
        assert!((length - 1.0).abs() < 1e-6, "length {length} of {wi:?}");
        wi.map(|x| x / length)
    })
}
