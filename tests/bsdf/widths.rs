//! Every model gives the bits of width 1 at widths 8 and 16, whatever stands in the other lanes.

use crate::lane::widths::{LaneFunction, assert_same_bits, truth};
use crate::stats::Rng;
use octolux::bsdf::{Coated, Conductor, ConductorFresnel, Dielectric, Diffuse, Model, Phong};
use octolux::lane::{Real, Vec3};

fn all<R: Real>(model: &impl Model<R>, wo: Vec3<R>, wi: Vec3<R>, u: [R; 3]) -> Vec<R> {
    let s = model.sample(wo, u[0], [u[1], u[2]]);
    let (towards, back) = (model.eval(wo, wi), model.eval(wo, s.wi));
    let vectors = [s.wi, s.weight, towards.value, back.value].into_iter().flat_map(|v| [v.x, v.y, v.z]);
    vectors.chain([s.pdf, s.eta, truth(s.delta), truth(s.valid), towards.pdf, back.pdf]).collect()
}

struct Models;
impl LaneFunction for Models {
    fn call<R: Real>(&self, x: &[R]) -> Vec<R> {
        let vector = |i: usize| Vec3::new(x[i], x[i + 1], x[i + 2]);
        let (wo, wi, u) = (vector(0), vector(3), [x[6], x[7], x[8]]);
        let (alpha, ior) = (x[9], x[10]);
        let above = |value: R, bound: f32| value.gt(R::splat(bound));
        let separable = above(x[11], 0.5);
        let (exact, schlick) = (above(x[12], 0.6), above(x[12], 0.3) & !above(x[12], 0.6));
        let fresnel = ConductorFresnel { a: vector(13), b: vector(16), exact, schlick };
        let mut results = all(&Diffuse { reflectance: vector(13) }, wo, wi, u);
        results.extend(all(&Conductor { alpha, separable, fresnel }, wo, wi, u));
        results.extend(all(&Dielectric { alpha, separable, ior }, wo, wi, u));
        results.extend(all(&Coated { reflectance: vector(13), alpha, separable, ior }, wo, wi, u));
        results.extend(all(&Phong { diffuse: vector(13), specular: vector(16), exponent: x[19] }, wo, wi, u));
        results
    }
}

#[test]
fn the_same_bits_at_every_width() {
    let mut rng = Rng::new(81);
    let mut rows = Vec::new();
    // A third of the blocks of 16 is smooth throughout: there whole registers skip the microfacets.
    for block in 0..10_000 {
        for _ in 0..16 {
            let mut row: Vec<f32> = [rng.sphere(), rng.sphere()].concat().iter().map(|&x| x as f32).collect();
            row.extend((0..3).map(|_| rng.f32()));
            let smooth = block % 3 == 0 || rng.f64() < 0.2;
            row.push(if smooth { 0.0 } else { 10f64.powf(rng.range(-4.5, 0.0)) as f32 });
            row.push(if rng.f64() < 0.1 { 1.0 } else { 2f64.powf(rng.range(-1.0, 1.0)) as f32 });
            row.extend((0..2).map(|_| rng.f32()));
            row.extend((0..6).map(|_| rng.f32()));
            row.push(10f64.powf(rng.range(-1.0, 7.0)) as f32);
            rows.push(row);
        }
    }
    assert_same_bits(&Models, &rows);
}
