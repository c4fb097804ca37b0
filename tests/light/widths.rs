//! The same bits at width 1, 8 and 16; dead lanes change nothing.

use super::scenes::*;
use crate::stats::Rng;
use octolux::lane::{Bits, Mask, Real, Vec3, f32x8, f32x16};
use octolux::light::{Emitter, EnvironmentMap, Extent, Lights};
use octolux::scene::{DeltaLight, Environment};

/// All a lane's outputs as bit patterns.
type Out = Vec<u32>;

/// Inputs of 16 lanes.
struct Inputs {
    p: [[f32; 3]; 16],
    d: [[f32; 3]; 16],
    u: [[f32; 3]; 16],
    active: u32,
}

fn run<R: Real>(lights: &Lights, inputs: &Inputs, first: usize) -> Vec<Out> {
    let pick = |from: &[[f32; 3]; 16]| Vec3::<R>::from_fn(|i| from[first + i]);
    let (p, d, u) = (pick(&inputs.p), pick(&inputs.d), pick(&inputs.u));
    let s = lights.sample(p, u.x, [u.y, u.z], R::Mask::from_bits(inputs.active >> first));
    let (radiance, pdf) = lights.environment(d);
    let area = lights.pdf_area(R::Bits::from_fn(|i| (first + i) as u32), p, u.x, u.y);
    let lane = |i: usize| {
        let mut out = vec![s.pdf.lane(i), pdf.lane(i), area.lane(i)];
        out.extend(radiance.lane(i));
        out.extend(s.radiance.lane(i));
        if s.pdf.lane(i) > 0.0 {
            out.push(s.distance.lane(i));
            [s.wi, s.target, s.target_error, s.ng].iter().for_each(|v| out.extend(v.lane(i)));
        }
        let mut bits: Out = out.into_iter().map(f32::to_bits).collect();
        bits.extend([s.primitive.lane(i), u32::from(s.is_environment.lane(i))]);
        bits
    };
    (0..R::WIDTH).map(lane).collect()
}

#[test]
fn same_bits_at_every_width() {
    let lamp =
        |i: u32, c: V| triangle(i, [c, [c[0] + 0.3, c[1], c[2]], [c[0], c[1] + 0.4, c[2] + 0.1]], [1.0, 2.0, 3.0]);
    let triangles = [lamp(0, [0.1, 0.2, -1.0]), lamp(3, [0.5, -0.5, -1.2])];
    let other_half = |i: u32, c: V| {
        let across = [c[0] + 0.3, c[1] + 0.4, c[2] + 0.1];
        triangle(i, [[c[0], c[1] + 0.4, c[2] + 0.1], [c[0] + 0.3, c[1], c[2]], across], [1.0, 2.0, 3.0])
    };
    let pair = [triangles[0], other_half(1, [0.1, 0.2, -1.0])];
    let spheres = [sphere(5, [1.0, 1.0, 1.0], 0.4, [1.0; 3]), sphere(9, [-1.0, 0.4, 0.0], 0.01, [900.0; 3])];
    let all: Vec<Emitter> = triangles.iter().chain(&spheres).copied().collect();
    let paired: Vec<Emitter> = pair.iter().chain(&triangles[1..]).copied().collect();
    let everything: Vec<Emitter> = paired.iter().chain(&spheres).copied().collect();
    let sky = Environment::Image(noise(13, 7, 0.0, 1.0, 1));
    let grey = Environment::Constant([0.5; 3]);
    let turned = {
        let Environment::Image(mut image) = sky.clone() else { unreachable!() };
        image.rotation = 77.0;
        Environment::Image(image)
    };
    let (direction, intensity) = ([0.6, 0.0, -0.8], [3.0, 2.0, 1.0]);
    let delta = [
        DeltaLight::Point { position: [0.1, 0.9, 0.2], intensity },
        DeltaLight::Directional { direction, irradiance: [1.0, 2.0, 0.5] },
        DeltaLight::Spot { position: [0.3, -0.4, 0.9], direction, intensity, angle: 50.0 },
    ];
    let extent = Extent { scale: 0.5, radius: 2.0 };
    let scenes: [(&[Emitter], Option<&Environment>, &[DeltaLight]); 15] = [
        (&triangles[..1], None, &[]),
        (&triangles, None, &[]),
        (&spheres, None, &[]),
        (&pair, None, &[]),
        (&paired, None, &[]),
        (&everything, Some(&grey), &delta),
        (&all, None, &[]),
        (&all, Some(&sky), &[]),
        (&all, Some(&grey), &[]),
        (&[], Some(&sky), &[]),
        (&[], Some(&turned), &[]),
        (&[], None, &delta),
        (&all, None, &delta),
        (&[], Some(&grey), &delta),
        (&all, Some(&turned), &delta),
    ];
    let mut rng = Rng::new(2);
    for (emitters, environment, delta) in scenes {
        let lights =
            Lights::with_delta(emitters.to_vec(), environment.and_then(EnvironmentMap::build), delta, extent).unwrap();
        for _ in 0..500 {
            let inputs = Inputs {
                p: std::array::from_fn(|_| f32s(scaled(rng.sphere(), 0.2))),
                d: std::array::from_fn(|_| f32s(rng.sphere())),
                u: std::array::from_fn(|_| [rng.f32(), rng.f32(), rng.f32()]),
                active: rng.u32() | 1,
            };
            let one: Vec<Out> = (0..16).flat_map(|i| run::<f32>(&lights, &inputs, i)).collect();
            let eight: Vec<Out> = [0, 8].into_iter().flat_map(|i| run::<f32x8>(&lights, &inputs, i)).collect();
            assert_eq!(one, eight);
            assert_eq!(one, run::<f32x16>(&lights, &inputs, 0));
            for (i, out) in one.iter().enumerate() {
                assert!(inputs.active >> i & 1 == 1 || out[0] == 0, "a dead lane has pdf 0");
            }
        }
    }
}
