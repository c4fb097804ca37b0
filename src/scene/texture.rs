//! Images in place of numbers: what a material's values are multiplied by, point by point.

use std::sync::{Arc, LazyLock};

/// An image as its file holds it, row 0 at the top; 8-bit texels stay 8-bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// In texels, each side at least 1.
    pub width: u32,
    /// In texels.
    pub height: u32,
    /// 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha.
    pub channels: usize,
    /// `width · height · channels` values, row by row.
    pub texels: Texels,
}

/// Values of an image.
#[derive(Clone, PartialEq)]
pub enum Texels {
    /// 0 … 255 means 0 … 1.
    Bytes(Vec<u8>),
    /// 0 … 65,535 means 0 … 1.
    Words(Vec<u16>),
    /// Linear, as they are.
    Floats(Vec<f32>),
}

impl std::fmt::Debug for Texels {
    /// The kind and the number of values.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Texels::Bytes(values) => write!(f, "{} bytes", values.len()),
            Texels::Words(values) => write!(f, "{} words", values.len()),
            Texels::Floats(values) => write!(f, "{} floats", values.len()),
        }
    }
}

/// An image, and how it is read.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Shared by all that wear it.
    pub image: Arc<Image>,
    /// Are its colours (never its alpha, never floats) encoded by the sRGB curve?
    pub srgb: bool,
    /// Which channel a map of one number reads.
    pub channel: Channel,
    /// The image is looked up at `scale · (u, v) + offset`, repeating; v = 0 is the bottom edge.
    pub scale: [f32; 2],
    /// See [`Texture::scale`].
    pub offset: [f32; 2],
    /// Where the image came from.
    pub file: FileName,
}

/// Where an image came from, for people; empty where it was made in code. Its `Debug` text says nothing: what an image is
/// called does not make a scene another.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct FileName(pub String);

impl std::fmt::Debug for FileName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("FileName")
    }
}

/// What a map of one number reads of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// The mean of red, green and blue.
    Mean,
    /// The first.
    Red,
    /// The second.
    Green,
    /// The third.
    Blue,
    /// Opacity.
    Alpha,
}

/// What images say of a material. Each multiplies the number that the material holds, unless it says otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Times the BSDF's first colour: reflectance, diffuse reflectance, or reflectance at normal incidence.
    pub colour: Option<Texture>,
    /// Times the specular reflectance of a BSDF with two colours, which is then held to 1 − the first colour.
    pub specular: Option<Texture>,
    /// In place of `alpha`: its root.
    pub roughness: Option<Texture>,
    /// From .5 on the surface is a conductor with the BSDF's first colour as f0.
    pub metallic: Option<Texture>,
    /// `alpha` of that conductor, where no image says it.
    pub metal_alpha: f32,
    /// Times the emission.
    pub emission: Option<Texture>,
    /// Times the opacity.
    pub opacity: Option<Texture>,
    /// The shading normal in tangent space, 2·(r, g, b) − 1, after its x and y are multiplied by `strength`.
    pub normal: Option<Texture>,
    /// Factors of the normal map's x and y.
    pub strength: [f32; 2],
}

impl Maps {
    /// All there are, with what they are for.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &Texture)> {
        let Maps { colour, specular, roughness, metallic, metal_alpha: _, emission, opacity, normal, strength: _ } =
            self;
        let named = [
            ("colour", colour),
            ("specular", specular),
            ("roughness", roughness),
            ("metallic", metallic),
            ("emission", emission),
            ("opacity", opacity),
            ("normal", normal),
        ];
        named.into_iter().filter_map(|(name, texture)| Some((name, texture.as_ref()?)))
    }

    /// All there are.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        self.named().map(|(_, texture)| texture)
    }

    /// Does any of them change how the surface scatters or emits?
    pub fn shade(&self) -> bool {
        self.textures().count() > usize::from(self.opacity.is_some())
    }

    /// Are there any?
    pub fn any(&self) -> bool {
        self.textures().next().is_some()
    }
}

impl Image {
    /// Bytes held.
    pub fn memory(&self) -> usize {
        match &self.texels {
            Texels::Bytes(values) => size_of_val(&**values),
            Texels::Words(values) => size_of_val(&**values),
            Texels::Floats(values) => size_of_val(&**values),
        }
    }

    /// Red, green, blue and alpha of a texel, linear. Panics outside the image.
    #[inline]
    pub fn texel(&self, column: usize, row: usize, srgb: bool) -> [f32; 4] {
        let first = (row * self.width as usize + column) * self.channels;
        let range = first..first + self.channels;
        match &self.texels {
            Texels::Bytes(values) => {
                let (colour, linear) = (if srgb { &*SRGB_8 } else { &*LINEAR_8 }, &*LINEAR_8);
                rgba(&values[range], |c| colour[usize::from(c)], |a| linear[usize::from(a)])
            }
            Texels::Words(values) => {
                let linear = |w: u16| f32::from(w) / 65_535.0;
                let curve = |w: u16| if srgb { SRGB_16[usize::from(w)] } else { linear(w) };
                rgba(&values[range], curve, linear)
            }
            Texels::Floats(values) => rgba(&values[range], |c| c, |a| a),
        }
    }
}

#[inline(always)]
fn rgba<T: Copy>(texel: &[T], colour: impl Fn(T) -> f32, alpha: impl Fn(T) -> f32) -> [f32; 4] {
    match *texel {
        [y] => {
            let y = colour(y);
            [y, y, y, 1.0]
        }
        [y, a] => {
            let y = colour(y);
            [y, y, y, alpha(a)]
        }
        [r, g, b] => [colour(r), colour(g), colour(b), 1.0],
        [r, g, b, a, ..] => [colour(r), colour(g), colour(b), alpha(a)],
        [] => [1.0; 4],
    }
}

static LINEAR_8: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| (i as f64 / 255.0) as f32));
static SRGB_8: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| from_srgb(i as f64 / 255.0)));
static SRGB_16: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..65_536).map(|i| from_srgb(f64::from(i) / 65_535.0)).collect());

/// IEC 61966-2-1, rounded once.
fn from_srgb(encoded: f64) -> f32 {
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

impl Texture {
    /// The whole image, of colours or of numbers.
    pub fn new(image: Arc<Image>, srgb: bool) -> Self {
        Texture { image, srgb, channel: Channel::Mean, scale: [1.0; 2], offset: [0.0; 2], file: FileName::default() }
    }

    /// Bilinear between texel centres at texture coordinates, in double precision: for what is tabulated at set-up.
    pub fn at(&self, uv: [f64; 2]) -> [f64; 4] {
        let size = [self.image.width, self.image.height];
        let (mut low, mut fraction) = ([0; 2], [0.0; 2]);
        for k in 0..2 {
            let x = f64::from(self.scale[k]) * uv[k] + f64::from(self.offset[k]);
            let from_centre = (x - x.floor()) * f64::from(size[k]) - 0.5;
            low[k] = from_centre.floor().rem_euclid(f64::from(size[k])) as u32;
            fraction[k] = from_centre - from_centre.floor();
        }
        let mut sum = [0.0; 4];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let side = |k: usize, far: u32| if far == 1 { fraction[k] } else { 1.0 - fraction[k] };
            let column = (low[0] + dx) % size[0];
            let row = size[1] - 1 - (low[1] + dy) % size[1];
            let texel = self.image.texel(column as usize, row as usize, self.srgb);
            let weight = side(0, dx) * side(1, dy);
            sum.iter_mut().zip(texel).for_each(|(sum, value)| *sum += weight * f64::from(value));
        }
        sum
    }

    /// The number that a map of one number reads of a texel.
    pub fn scalar(&self, [r, g, b, a]: [f64; 4]) -> f64 {
        match self.channel {
            Channel::Mean => (r + g + b) / 3.0,
            Channel::Red => r,
            Channel::Green => g,
            Channel::Blue => b,
            Channel::Alpha => a,
        }
    }
}
