//! Emitters whose radiance an image says: their mean for the choice of lights, and the value at a sampled point.

use super::maps::{on_sphere, on_triangle};
use super::texture::{EMISSION, OPACITY, OPACITY_MAP};
use super::world::World;
use crate::geometry::Hit;
use crate::lane::{Bits, Mask, Real, Vec3, array};
use crate::light::LightSample;
use crate::scene::{Material, NO_TEXCOORD, Scene};
use std::f64::consts::PI;

/// Mean radiance times opacity over an emitter (triangles in file order, then spheres): what it is chosen by. Where the
/// quadrature misses a bright spot and the mean is 0, the emitter is left to the rays that run into it.
pub fn mean_radiance(scene: &Scene, primitive: usize) -> [f32; 3] {
    let triangles = scene.mesh.triangles.len();
    let material = match scene.mesh.material.get(primitive) {
        Some(&material) => material,
        None => scene.spheres[primitive - triangles].material,
    };
    let material = &scene.materials[material as usize];
    if !material.is_patterned() {
        return material.emission;
    }
    let mean = match scene.mesh.triangles.get(primitive) {
        Some(_) => over_triangle(material, corners(scene, primitive)),
        None => over_sphere(material),
    };
    mean.map(|c| c as f32)
}

fn corners(scene: &Scene, triangle: usize) -> [[f64; 2]; 3] {
    let mesh = &scene.mesh;
    let Some(indices) = mesh.texcoord_indices.get(triangle) else { return [[0.0; 2]; 3] };
    indices.map(|i| if i == NO_TEXCOORD { [0.0; 2] } else { mesh.texcoords[i as usize].map(f64::from) })
}

/// Radiance times opacity at texture coordinates.
fn radiance(material: &Material, uv: [f64; 2]) -> [f64; 3] {
    let texel = material.maps.emission.as_ref().map_or([1.0; 4], |map| map.at(uv));
    let seen = material.maps.opacity.as_ref().map_or(1.0, |map| map.scalar(map.at(uv)));
    let scale = |k: usize| f64::from(material.emission[k]) * f64::from(material.opacity);
    std::array::from_fn(|k| scale(k) * seen * texel[k])
}

/// Twice as many points along a side as there are texels, within bounds: one emitter may span many repeats.
const FEWEST: f64 = 4.0;
const MOST: f64 = 512.0;

fn over_triangle(material: &Material, [a, b, c]: [[f64; 2]; 3]) -> [f64; 3] {
    let edge = |p: [f64; 2]| [p[0] - a[0], p[1] - a[1]];
    let (ab, ac) = (edge(b), edge(c));
    let maps = [&material.maps.emission, &material.maps.opacity].into_iter().flatten();
    let texels = maps.map(|map| {
        let area = (ab[0] * ac[1] - ab[1] * ac[0]).abs() * f64::from(map.scale[0] * map.scale[1]).abs();
        area * f64::from(map.image.width) * f64::from(map.image.height)
    });
    let side = (2.0 * texels.fold(0.0, f64::max).sqrt()).clamp(FEWEST, MOST).ceil() as usize;
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    // Centroids of the small triangles, upright and turned, of a regular division.
    for i in 0..side {
        for j in 0..side - i {
            for turned in 0..=usize::from(i + j + 2 <= side) {
                let third = if turned == 1 { 2.0 / 3.0 } else { 1.0 / 3.0 };
                let (s, t) = ((i as f64 + third) / side as f64, (j as f64 + third) / side as f64);
                let uv = [0, 1].map(|k| a[k] + s * ab[k] + t * ac[k]);
                radiance(material, uv).iter().zip(&mut sum).for_each(|(c, sum)| *sum += c);
                count += 1.0;
            }
        }
    }
    sum.map(|c| c / count)
}

fn over_sphere(material: &Material) -> [f64; 3] {
    let maps = [&material.maps.emission, &material.maps.opacity].into_iter().flatten();
    let columns = maps.map(|map| f64::from(map.image.width) * f64::from(map.scale[0]).abs()).fold(FEWEST, f64::max);
    let columns = (2.0 * columns).clamp(FEWEST, MOST) as usize;
    let rows = columns.div_ceil(2);
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for j in 0..rows {
        let v = (j as f64 + 0.5) / rows as f64;
        let weight = (PI * v).sin();
        for i in 0..columns {
            let uv = [(i as f64 + 0.5) / columns as f64, v];
            radiance(material, uv).iter().zip(&mut sum).for_each(|(c, sum)| *sum += weight * c);
            weights += weight;
        }
    }
    sum.map(|c| c / weights)
}

/// Puts the radiance times opacity at the sampled points in place of the mean.
#[inline(never)]
pub fn look_up<R: Real>(world: &World, light: &mut LightSample<R>, active: R::Mask) {
    // Primitives are fewer than 2³¹; what is none is counted down from 2³².
    let on_primitive = active & light.primitive.shr::<31>().eq(R::Bits::splat(0));
    let [material, _] = world.tags.fetch::<R>(light.primitive, on_primitive);
    let material = material.to_int();
    let maps = world.textures.maps::<R>(material, on_primitive);
    let mapped = maps[EMISSION].gt(R::zero()) | maps[OPACITY_MAP].gt(R::zero()) | maps[OPACITY].lt(R::one());
    let patterned = on_primitive & mapped;
    if patterned.none() {
        return;
    }
    let spheres = patterned & world.on_sphere::<R>(light.primitive);
    let [u, v] = light.place;
    let hit = Hit { t: R::zero(), primitive: light.primitive, u, v };
    let mut uv = on_triangle(world, &hit, patterned & !spheres).uv;
    if spheres.any() {
        let of_sphere = on_sphere(light.ng);
        uv = array::from_fn(|k| R::select(spheres, of_sphere[k], uv[k]));
    }
    let emission = world.materials.fetch::<R>(material, patterned).emission;
    let [r, g, b, _] = world.textures.look_up(maps[EMISSION], uv, patterned);
    let opacity = maps[OPACITY] * world.textures.look_up_number(maps[OPACITY_MAP], uv, patterned);
    let radiance = emission.hadamard(Vec3::new(r, g, b)) * opacity;
    light.radiance = Vec3::select(patterned, radiance, light.radiance);
}
