//! BSDFs at their ends: α from 1e-5 to 1, grazing incidence, indices from nearly 1 to 100.

use super::random::Random;
use super::ulp::Worst;
use super::{Effort, Row};
use crate::bsdf::fresnel::RelativeIor;
use crate::bsdf::ggx::Ggx;
use crate::bsdf::{ALPHA_MIN, Conductor, ConductorFresnel, Dielectric, Model};
use crate::lane::{Real, Vec3, f32x8};
use rayon::prelude::*;
use std::f64::consts::PI;

const GROUP: &str = "scattering";
type R = f32x8;

pub fn rows(effort: Effort) -> Vec<Row> {
    let count = effort.pick(20_000, 1_000_000, 50_000_000);
    vec![
        energy("conductor, α 1e-5 … 1, μ 1e-6 … 1: weight − 1", count, conductor_excess),
        energy("dielectric, η 1 + 1e-7 … 100, from both sides: weight·η² − 1", count, dielectric_excess),
        ggx_density(count),
        fresnel_near_one(count),
        mirror_limit(count),
    ]
}

/// The largest of `one` over `count` draws, eight a call.
fn largest(count: usize, one: impl Fn(&mut Random) -> (f64, String) + Sync) -> Worst<String> {
    const JOB: usize = 4096;
    let job = |job: usize| {
        let mut rng = Random::new(0xb5 + job as u64);
        let mut worst = Worst::default();
        for _ in 0..JOB.min(count - job * JOB).div_ceil(8) {
            let (error, at) = one(&mut rng);
            worst.see(error, at);
        }
        worst
    };
    (0..count.div_ceil(JOB)).into_par_iter().map(job).reduce(Worst::default, Worst::or)
}

/// By cosine: half of them log-uniform down to 1e-6.
fn incidence(rng: &mut Random) -> Vec3<R> {
    let at = |rng: &mut Random| {
        let z = if rng.below(2) == 0 { rng.unit().max(1e-6) } else { rng.log_uniform(-19.93, 0.0) };
        let (sin, cos) = (std::f32::consts::TAU * rng.unit()).sin_cos();
        let flat = (1.0 - z * z).max(0.0).sqrt();
        [flat * cos, flat * sin, z]
    };
    Vec3::from_fn(|_| at(rng))
}

fn lanes(f: impl FnMut(usize) -> f32) -> R {
    R::from_fn(f)
}

/// Numbers as the generator draws them, the ends more often.
fn number(rng: &mut Random) -> f32 {
    match rng.below(8) {
        0 => 0.0,
        1 => crate::sampling::ONE_BELOW,
        _ => rng.unit(),
    }
}

fn energy(case: &str, count: usize, excess: fn(&mut Random) -> (f64, String)) -> Row {
    let worst = largest(count, excess);
    // The weight is clamped to 1 where it is a ratio; F and the index's square are rounded four times.
    Row::of(GROUP, case, count as u64, &worst, 4.0, "ulp of 1")
}

/// How far a weight is above 1, in ulp; infinite where anything is not finite.
fn excess(weight: f32, pdf: f32, wi: [f32; 3]) -> f64 {
    let finite = weight.is_finite() && pdf.is_finite() && wi.iter().all(|x| x.is_finite());
    if !finite || weight < 0.0 || pdf < 0.0 {
        return f64::INFINITY;
    }
    (f64::from(weight) - 1.0) / f64::from(f32::EPSILON)
}

fn conductor_excess(rng: &mut Random) -> (f64, String) {
    let alpha = lanes(|_| rng.log_uniform(-16.6, 0.0));
    let separable = rng.below(2) == 0;
    let fresnel = ConductorFresnel::constant(Vec3::splat([1.0; 3]));
    let bsdf = Conductor { alpha, separable: crate::lane::Mask::splat(separable), fresnel };
    let wo = incidence(rng);
    let sample = bsdf.sample(wo, R::zero(), [lanes(|_| number(rng)), lanes(|_| number(rng))]);
    let eval = bsdf.eval(wo, sample.wi);
    let at = |i: usize| {
        let value = excess(eval.value.x.lane(i), eval.pdf.lane(i), [0.0; 3]);
        let value = if value.is_infinite() { value } else { 0.0 };
        value.max(excess(sample.weight.x.lane(i), sample.pdf.lane(i), sample.wi.lane(i)))
    };
    let (i, most) = (0..8).map(|i| (i, at(i))).fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
    (most, format!("α {:e}, wo {:?}", alpha.lane(i), wo.lane(i)))
}

fn dielectric_excess(rng: &mut Random) -> (f64, String) {
    let alpha = lanes(|_| if rng.below(4) == 0 { 0.0 } else { rng.log_uniform(-16.6, 0.0) });
    let ior = lanes(|_| if rng.below(2) == 0 { 1.0 + rng.log_uniform(-23.0, 0.0) } else { rng.log_uniform(0.0, 6.64) });
    let bsdf = Dielectric { alpha, separable: crate::lane::Mask::splat(rng.below(2) == 0), ior };
    let above = incidence(rng);
    let wo = Vec3::new(above.x, above.y, if rng.below(2) == 0 { above.z } else { -above.z });
    let sample = bsdf.sample(wo, lanes(|_| number(rng)), [lanes(|_| number(rng)), lanes(|_| number(rng))]);
    let eval = bsdf.eval(wo, sample.wi);
    let energy = sample.weight.x * (sample.eta * sample.eta);
    let at = |i: usize| {
        let value = excess(eval.value.x.lane(i), eval.pdf.lane(i), [0.0; 3]);
        let value = if value.is_infinite() { value } else { 0.0 };
        value.max(excess(energy.lane(i), sample.pdf.lane(i), sample.wi.lane(i)))
    };
    let (i, most) = (0..8).map(|i| (i, at(i))).fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
    (most, format!("α {:e}, η {}, wo {:?}", alpha.lane(i), ior.lane(i), wo.lane(i)))
}

/// D of a normal given by its slope against f64. In units of u = 2⁻²⁴: |h|² 3, az² + hx² + hy² 4, so the quotient 9, its square
/// 19; 1/π and its product 1.5: 20.5u, 10.25 ε.
fn ggx_density(count: usize) -> Row {
    let naive = std::sync::Mutex::new(0f64);
    let worst = largest(count, |rng| {
        let alpha = lanes(|_| rng.log_uniform(ALPHA_MIN.log2(), 0.0));
        let slope = lanes(|i| alpha.lane(i) * rng.log_uniform(-6.0, 3.0));
        let h = Vec3::new(slope, R::zero(), R::one());
        let found = Ggx { alpha, separable: crate::lane::Mask::splat(false) }.density(h, h.length_squared());
        let error = |i: usize| {
            let (a, s) = (f64::from(alpha.lane(i)), f64::from(slope.lane(i)));
            let exact = (a * (1.0 + s * s) / (a * a + s * s)).powi(2) / PI;
            let relative = |x: f32| (f64::from(x) / exact - 1.0).abs() / f64::from(f32::EPSILON);
            // cos² = 1/(1 + slope²) rounded, then D = α²/(π (cos²(α² − 1) + 1)²), as in Walter et al. 2007.
            let (a, cos2) = (alpha.lane(i), 1.0 / (1.0 + slope.lane(i) * slope.lane(i)));
            let t = cos2 * (a * a - 1.0) + 1.0;
            (relative(found.lane(i)), relative(a * a / (std::f32::consts::PI * t * t)))
        };
        let errors: Vec<_> = (0..8).map(error).collect();
        let textbook = errors.iter().map(|e| e.1).fold(0.0, f64::max);
        if let Ok(mut naive) = naive.lock() {
            *naive = naive.max(textbook);
        }
        let (i, most) = (0..8).fold((0, 0.0), |a, i| if errors[i].0 > a.1 { (i, errors[i].0) } else { a });
        (most, format!("α {:e}, slope {:e}", alpha.lane(i), slope.lane(i)))
    });
    let naive = naive.into_inner().unwrap_or(f64::NAN) * f64::from(f32::EPSILON);
    Row::of(GROUP, "GGX density, α 1e-4 … 1", count as u64, &worst, 10.25, "ε")
        .naive(format!("by cos²: off by {naive:.1e}"))
}

/// Reflectance of a denser medium against f64, down to grazing. η² − 1 is off by 1.5u, g² by 2.5u, g by 1.75u, the sums by
/// 2.75u, an amplitude by 8u, its square by 16u, their mean by 18u: 9 ε.
fn fresnel_near_one(count: usize) -> Row {
    let naive = std::sync::Mutex::new(0f64);
    let worst = largest(count, |rng| {
        let ior =
            lanes(|_| if rng.below(2) == 0 { 1.0 + rng.log_uniform(-23.0, 0.0) } else { rng.log_uniform(0.1, 6.64) });
        let cos = incidence(rng).z;
        let (found, _) = RelativeIor::new(ior, crate::lane::Mask::splat(true)).fresnel(cos);
        let error = |i: usize| {
            let (n, c) = (f64::from(ior.lane(i)), f64::from(cos.lane(i)));
            let exact = reflectance(n, c);
            let relative = |x: f32| (f64::from(x) - exact).abs() / exact / f64::from(f32::EPSILON);
            (relative(found.lane(i)), relative(textbook_reflectance(ior.lane(i), cos.lane(i))))
        };
        let errors: Vec<_> = (0..8).map(error).collect();
        let textbook = errors.iter().map(|e| e.1).fold(0.0, f64::max);
        if let Ok(mut naive) = naive.lock() {
            *naive = naive.max(textbook);
        }
        let (i, most) = (0..8).fold((0, 0.0), |a, i| if errors[i].0 > a.1 { (i, errors[i].0) } else { a });
        (most, format!("η {}, μ {:e}", ior.lane(i), cos.lane(i)))
    });
    let naive = naive.into_inner().unwrap_or(f64::NAN) * f64::from(f32::EPSILON);
    let case = "Fresnel, η 1 + 1e-7 … 100, μ 1e-6 … 1";
    Row::of(GROUP, case, count as u64, &worst, 9.0, "ε").naive(format!("by cosines: off by {naive:.1e}"))
}

fn reflectance(n: f64, c: f64) -> f64 {
    let d = (n - 1.0) * (n + 1.0);
    let g = (d + c * c).sqrt();
    // Numerators multiplied out: (c − g)(c + g) = −d.
    let s = d / (c + g).powi(2);
    let p = d * ((d + 2.0) * c * c - 1.0) / (n * n * c + g).powi(2);
    0.5 * (s * s + p * p)
}

/// From the cosines on both sides, as the formula is usually written.
fn textbook_reflectance(n: f32, c: f32) -> f32 {
    let t = (1.0 - (1.0 - c * c) / (n * n)).max(0.0).sqrt();
    let s = (c - n * t) / (c + n * t);
    let p = (n * c - t) / (n * c + t);
    0.5 * (s * s + p * p)
}

/// At α just above [`ALPHA_MIN`] the lobe is where the mirror is: at normal incidence the facets' slopes have the mean απ/2,
/// and a direction turns by twice its facet's angle.
fn mirror_limit(count: usize) -> Row {
    let alpha = ALPHA_MIN * 1.0001;
    let fresnel = ConductorFresnel::constant(Vec3::splat([1.0; 3]));
    let bsdf = |alpha: f32| Conductor { alpha: R::splat(alpha), separable: crate::lane::Mask::splat(false), fresnel };
    let wo = Vec3::splat([0.0, 0.0, 1.0]);
    const JOB: usize = 4096;
    let job = |job: usize| {
        let mut rng = Random::new(0xd1 + job as u64);
        let (mut sum, mut squares) = (0f64, 0f64);
        for _ in 0..JOB / 8 {
            let u = [lanes(|_| rng.unit()), lanes(|_| rng.unit())];
            let (rough, mirror) =
                (bsdf(alpha).sample(wo, R::zero(), u), bsdf(ALPHA_MIN * 0.9999).sample(wo, R::zero(), u));
            for i in 0..8 {
                let (a, b) = (rough.wi.lane(i), mirror.wi.lane(i));
                let turn: f64 = (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
                let lost = f64::from(mirror.weight.x.lane(i) - rough.weight.x.lane(i)).abs();
                (sum, squares) = (sum + turn + lost, squares + (turn + lost).powi(2));
            }
        }
        [sum, squares]
    };
    let jobs = count.div_ceil(JOB);
    let [sum, squares] = (0..jobs).into_par_iter().map(job).reduce(|| [0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let n = (jobs * JOB) as f64;
    let (mean, error) = (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt());
    let bound = PI * f64::from(alpha) + 4.0 * error;
    let case = "mirror below α = 1e-4, lobe above: mean change of direction and weight";
    Row::new(GROUP, case, n as u64, mean, bound, "")
}
