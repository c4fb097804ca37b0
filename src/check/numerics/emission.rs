//! Lights: solid angles from 1e-12 to 2π, a million of them with powers over twelve decades.

use super::random::Random;
use super::ulp::Worst;
use super::{Effort, Row};
use crate::lane::{Bits, Real, Vec3, f32x8};
use crate::light::{Emitter, EmitterShape, Lights, NO_PRIMITIVE, sphere_pdf, triangle_pdf};
use rayon::prelude::*;
use std::f64::consts::PI;

const GROUP: &str = "lights";
const JOB: usize = 4096;

pub fn rows(effort: Effort) -> Vec<Row> {
    let count = effort.pick(20_000, 1_000_000, 50_000_000);
    vec![sphere_cones(count), triangle_density(count), many(effort.pick(10_000, 1_000_000, 1_000_000), count / 4)]
}

/// The density in the cone of a sphere whose angular radius has a sine from 5e-7 (1e-12 sr) to .95.
///
/// In units of u = 2⁻²⁴: components of centre − origin 1, |·|² 4, D 3, s = r/D 4, s² 9; D − r is off by 3u·D ≤ 60u of itself at
/// D = 1.05 r, so cos² by 64u and 1 + cos (cos ≤ .31 there) by 8u; the quotient, 2π, its product and the reciprocal 4: 22u, 11 ε.
fn sphere_cones(count: usize) -> Row {
    let job = |job: usize| {
        let mut rng = Random::new(0xf1 + job as u64);
        let (mut worst, mut naive) = (Worst::<String>::default(), 0f64);
        for _ in 0..JOB {
            let (origin, center) = (rng.point(1.0), rng.point(1.0));
            let d2: f64 = (0..3).map(|k| (f64::from(center[k]) - f64::from(origin[k])).powi(2)).sum();
            let sine = rng.log_uniform(-21.0, 0.0).min(0.952);
            let radius = (d2.sqrt() * f64::from(sine)) as f32;
            let s2 = f64::from(radius).powi(2) / d2;
            let exact = (1.0 + (1.0 - s2).sqrt()) / (2.0 * PI * s2);
            let found = sphere_pdf(1.0f32, Vec3::splat(center), radius, Vec3::splat(origin));
            let relative = |x: f64| (x / exact - 1.0).abs() / f64::from(f32::EPSILON);
            worst.see(relative(found.into()), format!("sine {sine:e}"));
            let cos = (1.0 - (radius * radius) / d2 as f32).sqrt();
            naive = naive.max(relative((1.0 / (std::f32::consts::TAU * (1.0 - cos))).into()));
        }
        (worst, naive)
    };
    let jobs = (0..count.div_ceil(JOB)).into_par_iter().map(job);
    let (worst, naive) = jobs.reduce(Default::default, |a, b| (a.0.or(b.0), a.1.max(b.1)));
    Row::of(GROUP, "sphere, 1e-12 … 2π sr: density", count as u64, &worst, 11.0, "ε")
        .naive(format!("1/2π(1 − cos θ): off by {:.1e}", naive * f64::from(f32::EPSILON)))
}

/// t²/(A cos) from rounded t and cos: 4 roundings.
fn triangle_density(count: usize) -> Row {
    let job = |job: usize| {
        let mut rng = Random::new(0x101 + job as u64);
        let mut worst = Worst::<String>::default();
        for _ in 0..JOB {
            let (row, t, cos) = (rng.log_uniform(0.0, 60.0), rng.log_uniform(-20.0, 1.0), rng.log_uniform(-20.0, 0.0));
            let exact = f64::from(row) * f64::from(t).powi(2) / f64::from(cos);
            let found = f64::from(triangle_pdf(row, t, cos));
            worst.see(
                (found / exact - 1.0).abs() / f64::from(f32::EPSILON),
                format!("row {row:e}, t {t:e}, cos {cos:e}"),
            );
        }
        worst
    };
    let worst = (0..count.div_ceil(JOB)).into_par_iter().map(job).reduce(Worst::default, Worst::or);
    Row::of(GROUP, "triangle: density from t and cos", count as u64, &worst, 2.0, "ε")
}

/// Emitters of powers over twelve decades: the density of a sample is that of its hit, none is drawn that has none.
fn many(emitters: usize, draws: usize) -> Row {
    let mut rng = Random::new(0x107);
    let lights: Vec<_> = (0..emitters)
        .map(|i| {
            let size = 1e-3 * rng.log_uniform(-6.0, 0.0);
            let edge = |rng: &mut Random| rng.direction().map(|x| x * size);
            let (e1, e2) = (edge(&mut rng), edge(&mut rng));
            let radiance = [rng.log_uniform(-28.0, 0.0); 3];
            Emitter { primitive: i as u32, shape: EmitterShape::Triangle { p0: rng.point(1.0), e1, e2 }, radiance }
        })
        .collect();
    let Ok(lights) = Lights::build(lights, None) else {
        return Row::never(GROUP, "many emitters", 0, 1, "tables that cannot be built");
    };
    let job = |job: usize| {
        let mut rng = Random::new(0x109 + job as u64);
        let mut worst = Worst::<String>::default();
        for _ in 0..JOB / 8 {
            let origin = Vec3::splat(rng.point(1.0));
            let mut draw = || f32x8::from_fn(|_| rng.unit());
            let (choice, u) = (draw(), [draw(), draw()]);
            let sample = lights.sample(origin, choice, u, crate::lane::Mask::splat(true));
            let cos = -sample.wi.dot(sample.ng);
            let again = lights.pdf_area(sample.primitive, origin, sample.distance, cos);
            for i in 0..8 {
                let drawn = sample.primitive.lane(i) != NO_PRIMITIVE;
                let same = sample.pdf.lane(i).to_bits() == again.lane(i).to_bits();
                let valid = !drawn || (same && sample.pdf.lane(i) > 0.0);
                worst.see(if valid { 0.0 } else { 1.0 }, format!("emitter {}", sample.primitive.lane(i)));
            }
        }
        worst
    };
    let worst = (0..draws.div_ceil(JOB)).into_par_iter().map(job).reduce(Worst::default, Worst::or);
    let case = format!("{emitters} emitters, powers over 12 decades: density of sample and hit");
    Row::of(GROUP, case, draws as u64, &worst, 0.0, "that differ")
}
