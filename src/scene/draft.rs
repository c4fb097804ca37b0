//! A material as it is written, before the images it names are read: that happens only if something wears it.

use super::Material;
use super::domain::{Domain, NON_NEGATIVE, UNIT};
use super::error::SceneError;
use super::image_file::ImageFiles;
use super::notes::Notes;
use super::texture::{Channel, FileName, Image, Texels, Texture};
use std::path::PathBuf;

/// A material and the images it names.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub material: Material,
    pub maps: Vec<MapUse>,
}

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    Colour,
    Specular,
    Roughness,
    Metallic,
    Emission,
    Opacity,
    Normal,
    /// A normal map, if the image is one; else not honoured.
    Bump,
}

/// An image as a key of a file names it.
#[derive(Clone, Debug)]
pub(super) struct MapUse {
    pub slot: Slot,
    pub image: PathBuf,
    /// Where it is named.
    pub file: PathBuf,
    pub line: usize,
    pub key: String,
    /// `None`: alpha where an opacity map has one, else the mean.
    pub channel: Option<Channel>,
    pub scale: [f32; 2],
    pub offset: [f32; 2],
    pub strength: f32,
}

impl From<Material> for Draft {
    fn from(material: Material) -> Self {
        Draft { material, maps: Vec::new() }
    }
}

impl Draft {
    /// Reads the images.
    ///
    /// # Errors
    /// An image that cannot be read or holds what its use does not allow, at the line that names it.
    pub fn finish(self, images: &mut ImageFiles, notes: &mut Notes) -> Result<Material, SceneError> {
        let Draft { mut material, maps } = self;
        for map in maps {
            let wrong = |what: String| {
                let message = format!("`{}`: `{}` {what}", map.key, map.image.display());
                SceneError::at(
                    &map.file,
                    map.line,
                    message,
                    "mend the path or the image; PNG, JPEG and OpenEXR are read",
                )
            };
            notes.files.push(map.image.clone());
            let image = images.read(&map.image).map_err(wrong)?;
            map.check_values(&image).map_err(wrong)?;
            if map.slot == Slot::Bump && !is_normal_map(&image) {
                notes.not_honoured(
                    &map.file,
                    map.line,
                    &map.key,
                    "a map of heights; tangent-space normal maps are rendered",
                );
                continue;
            }
            let has_alpha = image.channels.is_multiple_of(2);
            let channel = map.channel.unwrap_or(match map.slot {
                Slot::Opacity if has_alpha => Channel::Alpha,
                _ => Channel::Mean,
            });
            let srgb = matches!(map.slot, Slot::Colour | Slot::Specular | Slot::Emission);
            let file = FileName(map.image.display().to_string());
            let texture = Texture { image, srgb, channel, scale: map.scale, offset: map.offset, file };
            let maps = &mut material.maps;
            let place = match map.slot {
                Slot::Colour => &mut maps.colour,
                Slot::Specular => &mut maps.specular,
                Slot::Roughness => &mut maps.roughness,
                Slot::Metallic => &mut maps.metallic,
                Slot::Emission => &mut maps.emission,
                Slot::Opacity => &mut maps.opacity,
                Slot::Normal | Slot::Bump => {
                    // Where a scale mirrors the image, its tangents point the other way.
                    maps.strength = map.scale.map(|scale| map.strength.copysign(scale));
                    &mut maps.normal
                }
            };
            *place = Some(texture);
        }
        Ok(material)
    }
}

impl MapUse {
    /// Values that are not 8- or 16-bit may be anything; they must be what they stand for.
    fn check_values(&self, image: &Image) -> Result<(), String> {
        let Texels::Floats(values) = &image.texels else { return Ok(()) };
        let (what, domain): (_, &Domain) = match self.slot {
            Slot::Emission => ("emission", &NON_NEGATIVE),
            Slot::Colour | Slot::Specular => ("reflectance", &UNIT),
            _ => ("such a map", &UNIT),
        };
        match values.iter().position(|&value| domain.admit(value.into()).is_none()) {
            None => Ok(()),
            Some(i) => {
                let texel = i / image.channels;
                let (column, row) = (texel % image.width as usize, texel / image.width as usize);
                Err(format!("holds {} at column {column}, row {row}: {what} is {}", values[i], domain.words))
            }
        }
    }
}

/// Normals point out of the surface on average: blue is high, red and green are about the middle. A map of heights is
/// grey.
fn is_normal_map(image: &Image) -> bool {
    if image.channels < 3 {
        return false;
    }
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    // A few thousand texels tell; an odd stride meets all columns.
    let texels = image.width as usize * image.height as usize;
    for i in (0..texels).step_by((texels / 4096).max(1) | 1) {
        let [r, g, b, _] = image.texel(i % image.width as usize, i / image.width as usize, false);
        [r, g, b].iter().zip(&mut sum).for_each(|(c, sum)| *sum += f64::from(*c));
        count += 1.0;
    }
    let [r, g, b] = sum.map(|c| c / count);
    let is_middle = |c: f64| (0.35..0.65).contains(&c);
    b > 0.7 && is_middle(r) && is_middle(g)
}
