//! Images in place of numbers: look-ups, cut-outs, emission, normal maps.

mod cutouts;
mod emission;
mod look_up;
mod normal_maps;

use crate::renders::{Point, Set};
use octolux::scene::{Image, Material, NO_TEXCOORD, Texels, Texture};
use std::sync::Arc;

/// Means tested in this folder, rounded up: the family of Šidák's bound. Seeds are fixed.
const TESTS: usize = 150;

/// A float RGB image from a function of column and row (0 at the top).
fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> Texture {
    let texels = (0..width * height).flat_map(|i| texel(i % width, i / width)).collect();
    Texture::new(Arc::new(Image { width, height, channels: 3, texels: Texels::Floats(texels) }), false)
}

/// A float image of one channel.
fn grey_image(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Texture {
    let texels = (0..width * height).map(|i| texel(i % width, i / width)).collect();
    Texture::new(Arc::new(Image { width, height, channels: 1, texels: Texels::Floats(texels) }), false)
}

/// A quad whose corners have the texture coordinates (0, 0), (1, 0), (1, 1), (0, 1).
fn mapped_quad(set: &mut Set, material: u32, corners: [Point; 4]) {
    let first = set.scene().mesh.triangles.len();
    set.quad(material, corners);
    let mesh = &mut set.scene_mut().mesh;
    let base = mesh.texcoords.len() as u32;
    mesh.texcoords.extend([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    mesh.texcoord_indices.resize(first, [NO_TEXCOORD; 3]);
    mesh.texcoord_indices.extend([[0, 1, 2], [0, 2, 3]].map(|triangle: [u32; 3]| triangle.map(|i| base + i)));
}

/// Gives every triangle a place in the list of texture coordinates.
fn complete(mut set: Set) -> octolux::scene::Scene {
    let mesh = &mut set.scene_mut().mesh;
    if !mesh.texcoords.is_empty() {
        mesh.texcoord_indices.resize(mesh.triangles.len(), [NO_TEXCOORD; 3]);
    }
    set.finish()
}

/// The material under construction.
fn edit(set: &mut Set, material: u32) -> &mut Material {
    &mut set.scene_mut().materials[material as usize]
}
