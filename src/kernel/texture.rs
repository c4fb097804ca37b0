//! Images in lanes: bilinear look-ups, and where the materials use which.

use crate::geometry::Rows;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, array};
use crate::scene::{Channel, Image, Material, Texture};
use std::sync::Arc;

/// A place in a material's row: the number of its image, from 1; 0 for none.
pub(super) const COLOUR: usize = 0;
pub(super) const SPECULAR: usize = 1;
pub(super) const ROUGHNESS: usize = 2;
pub(super) const METALLIC: usize = 3;
pub(super) const EMISSION: usize = 4;
pub(super) const NORMAL: usize = 5;
pub(super) const OPACITY_MAP: usize = 6;
/// The number that the opacity map multiplies.
pub(super) const OPACITY: usize = 7;
/// Factors of a normal map's x and y.
pub(super) const STRENGTH: usize = 8;
pub(super) const METAL_ALPHA: usize = 10;
/// 1 where an image changes how the material scatters or emits.
pub(super) const SHADES: usize = 11;

/// All images in use, and a row a material that says where.
pub struct TextureTable {
    maps: Rows<16>,
    entries: Vec<Entry>,
}

/// A texture as look-ups read it.
struct Entry {
    image: Arc<Image>,
    srgb: bool,
    /// Width and height.
    size: [f32; 2],
    scale: [f32; 2],
    offset: [f32; 2],
    /// What a map of one number reads: the sum of the channels so weighted.
    weights: [f32; 4],
}

impl TextureTable {
    /// Of the materials of a scene; what [`Plan`](crate::plan::Plan) leaves out need not be asked for.
    pub fn new(materials: &[Material]) -> Self {
        let mut entries = Vec::new();
        let rows: Vec<_> = materials.iter().map(|material| row(material, &mut entries)).collect();
        Self { maps: Rows::new(&rows), entries }
    }

    /// Bytes of tables and images, an image counted as often as it is used.
    pub fn bytes(&self) -> usize {
        self.maps.bytes() + self.entries.iter().map(|entry| entry.image.memory()).sum::<usize>()
    }

    /// The rows of materials, read at the names above.
    #[inline(always)]
    pub(super) fn maps<R: Real>(&self, material: R::Bits, valid: R::Mask) -> [R; 16] {
        self.maps.fetch::<R>(material, valid)
    }

    /// Red, green, blue and alpha of image `number` (from 1) at texture coordinates; 1 where the number is 0 and in
    /// lanes that are not `active`. Coordinates that are not finite read some texel.
    #[inline(never)]
    pub fn look_up<R: Real>(&self, number: R, uv: [R; 2], active: R::Mask) -> [R; 4] {
        let wanted = active & number.gt(R::zero());
        if wanted.none() {
            return [R::one(); 4];
        }
        let index = (number - R::one()).masked(wanted).to_int();
        let of = |f: fn(&Entry) -> f32| R::from_fn(|lane| f(&self.entries[index.lane(lane) as usize]));
        let x = uv[0].mul_add(of(|e| e.scale[0]), of(|e| e.offset[0]));
        let y = uv[1].mul_add(of(|e| e.scale[1]), of(|e| e.offset[1]));
        let (columns, x) = between_centres(x, of(|e| e.size[0]));
        let (rows, y) = between_centres(y, of(|e| e.size[1]));
        // Lower left, lower right, upper left, upper right.
        let mut texels = [[[1.0; 4]; MAX_WIDTH]; 4];
        let bits = wanted.bits();
        for lane in (0..R::WIDTH).filter(|lane| bits >> lane & 1 != 0) {
            let entry = &self.entries[index.lane(lane) as usize];
            let top = entry.image.height as usize - 1;
            for (corner, texels) in texels.iter_mut().enumerate() {
                let (column, row) = (columns[corner & 1].lane(lane), rows[corner >> 1].lane(lane));
                texels[lane] = entry.image.texel(column as usize, top - row as usize, entry.srgb);
            }
        }
        let own_row = R::Bits::from_fn(|lane| lane as u32);
        let [a, b, c, d] = array::map(texels, |texels| R::fetch_rows(&texels, own_row));
        array::from_fn(|k| {
            let value = lerp(lerp(a[k], b[k], x), lerp(c[k], d[k], x), y);
            R::select(wanted, value, R::one())
        })
    }

    /// The number that a map of one number says; 1 where there is none.
    #[inline(always)]
    pub(super) fn look_up_number<R: Real>(&self, number: R, uv: [R; 2], active: R::Mask) -> R {
        let texel = self.look_up(number, uv, active);
        let wanted = active & number.gt(R::zero());
        let index = (number - R::one()).masked(wanted).to_int();
        let weight = |k: usize| {
            R::from_fn(|lane| match self.entries.get(index.lane(lane) as usize) {
                Some(entry) => entry.weights[k],
                None => 0.0,
            })
        };
        let sum = (0..4).rev().fold(R::zero(), |sum, k| weight(k).mul_add(texel[k], sum));
        R::select(wanted, sum, R::one())
    }
}

/// The two neighbouring texel centres of coordinate `x`, wrapped into 0 … size − 1, and how far it is from the first
/// to the second.
#[inline(always)]
fn between_centres<R: Real>(x: R, size: R) -> ([R::Bits; 2], R) {
    let last = size - R::one();
    // The fraction may round to 1: its place is then that of 0, seen from the other side of the seam.
    let from_centre = (x - x.floor()).mul_add(size, R::splat(-0.5));
    let low = from_centre.floor();
    let fraction = from_centre - low;
    // The second bound is what a coordinate without a value falls to.
    let low = R::select(low.lt(R::zero()), last, low).max_or(R::zero()).min_or(last);
    let high = R::select(low.lt(last), low + R::one(), R::zero());
    ([low.to_int(), high.to_int()], fraction)
}

/// `(1 − t)·a + t·b`.
#[inline(always)]
fn lerp<R: Real>(a: R, b: R, t: R) -> R {
    b.mul_add(t, a * (R::one() - t))
}

fn row(material: &Material, entries: &mut Vec<Entry>) -> [f32; 16] {
    let mut number = |texture: &Option<Texture>| {
        let Some(texture) = texture else { return 0.0 };
        entries.push(Entry::new(texture));
        entries.len() as f32
    };
    let maps = &material.maps;
    let mut row = [0.0; 16];
    row[COLOUR] = number(&maps.colour);
    row[SPECULAR] = number(&maps.specular);
    row[ROUGHNESS] = number(&maps.roughness);
    row[METALLIC] = number(&maps.metallic);
    row[EMISSION] = number(&maps.emission);
    row[NORMAL] = number(&maps.normal);
    row[OPACITY_MAP] = number(&maps.opacity);
    row[OPACITY] = material.opacity;
    row[STRENGTH..STRENGTH + 2].copy_from_slice(&maps.strength);
    row[METAL_ALPHA] = maps.metal_alpha;
    row[SHADES] = if maps.shade() { 1.0 } else { 0.0 };
    row
}

impl Entry {
    fn new(texture: &Texture) -> Self {
        let Texture { image, srgb, channel, scale, offset, file: _ } = texture;
        let is_grey = image.channels < 3;
        let weights = match channel {
            Channel::Mean if is_grey => [1.0, 0.0, 0.0, 0.0],
            Channel::Mean => [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0],
            Channel::Red => [1.0, 0.0, 0.0, 0.0],
            Channel::Green => [0.0, 1.0, 0.0, 0.0],
            Channel::Blue => [0.0, 0.0, 1.0, 0.0],
            Channel::Alpha => [0.0, 0.0, 0.0, 1.0],
        };
        let size = [image.width as f32, image.height as f32];
        Entry { image: image.clone(), srgb: *srgb, size, scale: *scale, offset: *offset, weights }
    }
}
