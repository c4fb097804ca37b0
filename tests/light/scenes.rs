//! Small light scenes, and f64 geometry that shares nothing with `src`.

use crate::stats::Rng;
use octolux::lane::Vec3;
use octolux::light::{Emitter, EmitterShape, LightSample, Lights};
use octolux::scene::{Environment, EnvironmentImage};

pub type V = [f64; 3];

pub fn sub(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] - b[i])
}
pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
pub fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
pub fn norm(a: V) -> f64 {
    dot(a, a).sqrt()
}
pub fn scaled(a: V, s: f64) -> V {
    a.map(|c| c * s)
}
pub fn unit(a: V) -> V {
    scaled(a, 1.0 / norm(a))
}
pub fn f32s(a: V) -> [f32; 3] {
    a.map(|c| c as f32)
}
pub fn f64s(a: [f32; 3]) -> V {
    a.map(f64::from)
}
pub fn vec1(a: [f32; 3]) -> Vec3<f32> {
    Vec3::splat(a)
}

pub fn triangle(primitive: u32, p: [V; 3], radiance: [f32; 3]) -> Emitter {
    let p = p.map(f32s);
    let edge = |i: usize| std::array::from_fn(|k| p[i][k] - p[0][k]);
    Emitter { primitive, shape: EmitterShape::Triangle { p0: p[0], e1: edge(1), e2: edge(2) }, radiance }
}

pub fn sphere(primitive: u32, center: V, radius: f64, radiance: [f32; 3]) -> Emitter {
    let shape = EmitterShape::Sphere { center: f32s(center), radius: radius as f32 };
    Emitter { primitive, shape, radiance }
}

pub fn area_lights(emitters: &[Emitter]) -> Lights {
    Lights::build(emitters.to_vec(), None).unwrap()
}

/// One sample from `p` at width 1.
pub fn draw(lights: &Lights, p: [f32; 3], rng: &mut Rng) -> LightSample<f32> {
    let (choice, u) = (rng.f32(), [rng.f32(), rng.f32()]);
    lights.sample(vec1(p), choice, u, true)
}

/// Where the ray from `o` along `d` meets the emitter from its emitting side: distance and cosine there.
pub fn hit(emitter: &Emitter, o: V, d: V) -> Option<(f64, f64)> {
    match emitter.shape {
        EmitterShape::Triangle { p0, e1, e2 } => {
            let (p0, e1, e2) = (f64s(p0), f64s(e1), f64s(e2));
            let n = cross(e1, e2);
            let cos = -dot(d, unit(n));
            if cos <= 0.0 {
                return None;
            }
            let t = dot(sub(p0, o), n) / dot(d, n);
            let q = sub([o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]], p0);
            let (b1, b2) = (dot(cross(q, e2), n) / dot(n, n), dot(cross(e1, q), n) / dot(n, n));
            (t > 0.0 && b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0).then_some((t, cos))
        }
        EmitterShape::Sphere { center, radius } => {
            let (c, r) = (sub(f64s(center), o), f64::from(radius));
            let along = dot(c, d);
            let off = norm(sub(c, scaled(d, along)));
            let outside = dot(c, c) > r * r;
            let t = along - (r * r - off * off).max(0.0).sqrt();
            (outside && off < r && t > 0.0).then(|| (t, (r * r - off * off).sqrt() / r))
        }
    }
}

/// The pdf that `lights` states for direction `d` from `p`: the sum over every light along it, in f64 geometry.
pub fn stated_pdf(lights: &Lights, emitters: &[Emitter], p: [f32; 3], d: V) -> f64 {
    let on_areas = emitters.iter().filter_map(|e| {
        let (t, cos) = hit(e, f64s(p), d)?;
        Some(f64::from(lights.pdf_area::<f32>(bits(e.primitive), vec1(p), t as f32, cos as f32)))
    });
    on_areas.sum::<f64>() + f64::from(lights.environment(vec1(f32s(d))).1)
}

pub fn bits(value: u32) -> <f32 as octolux::lane::Real>::Bits {
    octolux::lane::Bits::splat(value)
}

/// Texels from a function of (row, column).
pub fn image(width: usize, height: usize, mut texel: impl FnMut(usize, usize) -> [f32; 3]) -> EnvironmentImage {
    let texels = (0..width * height).map(|i| texel(i / width, i % width)).collect();
    EnvironmentImage { width, height, texels, rotation: 0.0 }
}

/// Grey texels, uniform in [lo, hi).
pub fn noise(width: usize, height: usize, lo: f32, hi: f32, seed: u64) -> EnvironmentImage {
    let mut rng = Rng::new(seed);
    image(width, height, |_, _| [lo + (hi - lo) * rng.f32(); 3])
}

pub fn image_lights(image: &EnvironmentImage) -> Lights {
    Lights::build(Vec::new(), Some(&Environment::Image(image.clone()))).unwrap()
}
