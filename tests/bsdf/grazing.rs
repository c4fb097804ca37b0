//! Everything finite where formulas on paper divide by zero.

use super::{at, coat, glass, phong, to_f64, white_metal};
use crate::stats::Rng;
use octolux::bsdf::{ALPHA_MIN, Conductor, ConductorFresnel, Diffuse, EXPONENT_MAX, Eval, Model, Sample};
use octolux::lane::Vec3;
use octolux::sampling::ONE_BELOW;

const COSINES: [f64; 10] = [1.0, 0.5, 1e-2, 1e-4, 1e-6, 1e-9, 1e-20, 1e-30, 1e-40, 0.0];
const ALPHAS: [f32; 7] = [0.0, ALPHA_MIN, 2e-4, 1e-3, 0.03, 0.5, 1.0];

fn assert_sound(name: &str, s: &Sample<f32>) {
    let finite = s.weight.lane(0).iter().chain(&s.wi.lane(0)).chain([&s.pdf, &s.eta]).all(|x| x.is_finite());
    assert!(finite && s.pdf >= 0.0 && s.weight.lane(0).iter().all(|&x| x >= 0.0), "{name}: {s:?}");
    assert!(s.valid || (s.pdf == 0.0 && s.weight.lane(0) == [0.0; 3]), "{name}: {s:?}");
    if s.valid {
        let length = to_f64(s.wi.lane(0)).iter().map(|x| x * x).sum::<f64>().sqrt();
        // wo's own 2 ulp, and h's length, twice, times the projections of wo.
        assert!((length - 1.0).abs() < 16.0 / f64::from(1u32 << 24), "{name}: length {length}, {s:?}");
        assert!(s.wi.z != 0.0, "{name}: {s:?}");
    }
}

fn assert_finite(name: &str, e: &Eval<f32>) {
    let sound = |x: &f32| x.is_finite() && *x >= 0.0;
    assert!(sound(&e.pdf) && e.value.lane(0).iter().all(sound), "{name}: {e:?}");
}

fn probe(name: &str, model: &impl Model<f32>, wo: Vec3<f32>, rng: &mut Rng) {
    let ends = [0.0, 2f32.powi(-24), 0.25, 0.5, 0.75, ONE_BELOW];
    let mut directions: Vec<Vec3<f32>> =
        COSINES.iter().flat_map(|&mu| [at(mu, 2.0), at(-mu, 0.4), at(mu, 0.4 + std::f64::consts::PI)]).collect();
    directions.extend([wo, Vec3::new(-wo.x, -wo.y, wo.z), -wo]);
    for u0 in ends {
        for u1 in ends {
            for lobe in [0.0, 0.5, ONE_BELOW, rng.f32()] {
                let s = model.sample(wo, lobe, [u0, u1]);
                assert_sound(&format!("{name}, u {lobe} {u0} {u1}"), &s);
                directions.push(s.wi);
            }
        }
    }
    for wi in directions {
        assert_finite(&format!("{name}, wi {wi:?}"), &model.eval(wo, wi));
    }
}

#[test]
fn everything_is_finite() {
    let mut rng = Rng::new(71);
    let metal = ConductorFresnel::exact(Vec3::splat([0.143, 0.375, 1.442]), Vec3::splat([3.98, 2.39, 1.6]));
    for mu in COSINES.iter().flat_map(|&mu| [mu, -mu]) {
        let wo = at::<f32>(mu, 0.4);
        probe("diffuse", &Diffuse { reflectance: Vec3::splat([0.5; 3]) }, wo, &mut rng);
        for exponent in [0.0, 0.5, 1.0, 30.0, 1e4, EXPONENT_MAX] {
            for (diffuse, specular) in [(0.0, 1.0), (0.5, 0.5), (1.0, 0.0), (1e-30, 1e-38), (0.0, 0.0)] {
                let name = format!("phong {diffuse} {specular} {exponent}, cosine {mu}");
                probe(&name, &phong::<f32>(diffuse, specular, exponent), wo, &mut rng);
            }
        }
        for alpha in ALPHAS {
            for separable in [false, true] {
                let name = format!("alpha {alpha}, cosine {mu}");
                probe(&format!("conductor, {name}"), &white_metal::<f32>(alpha, separable), wo, &mut rng);
                probe(&format!("metal, {name}"), &Conductor { alpha, separable, fresnel: metal }, wo, &mut rng);
                for ior in [1.5, 1.0, 1.0 + 1e-6, 1.001, 0.7, 3.0] {
                    probe(&format!("glass {ior}, {name}"), &glass::<f32>(alpha, separable, ior), wo, &mut rng);
                    for reflectance in [0.0, 0.5, 1.0] {
                        let coat = coat::<f32>(reflectance, alpha, separable, ior);
                        probe(&format!("coat {ior} on {reflectance}, {name}"), &coat, wo, &mut rng);
                    }
                }
            }
        }
    }
}
