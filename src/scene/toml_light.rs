//! `[environment]`, `[[point_light]]`, `[[directional_light]]` and `[[spot_light]]`.

use super::domain::{FINITE, HALF_ANGLE, NON_NEGATIVE};
use super::error::SceneError;
use super::load::beside;
use super::toml_file::named_file;
use super::toml_text::{Colour, Numbers, TomlText};
use super::transform::unit;
use super::{DeltaLight, Environment, environment as image};
use glam::DVec3;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentTable {
    radiance: Option<Spanned<Colour>>,
    file: Option<Spanned<String>>,
    rotation: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointTable {
    position: Spanned<Numbers<3>>,
    intensity: Spanned<Colour>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DirectionalTable {
    direction: Spanned<Numbers<3>>,
    irradiance: Spanned<Colour>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpotTable {
    position: Spanned<Numbers<3>>,
    direction: Spanned<Numbers<3>>,
    intensity: Spanned<Colour>,
    angle: Spanned<f64>,
}

impl EnvironmentTable {
    /// The image that it names.
    pub fn image(&self, scene: &Path) -> Option<PathBuf> {
        Some(beside(scene, self.file.as_ref()?.as_ref()))
    }
}

/// The environment; its image is read.
pub(super) fn environment(table: &Spanned<EnvironmentTable>, text: &TomlText) -> Result<Environment, SceneError> {
    let EnvironmentTable { radiance, file, rotation } = table.as_ref();
    let scale = radiance.as_ref().map(|radiance| text.colour("radiance", radiance, &NON_NEGATIVE)).transpose()?;
    if let Some(idle) = rotation.as_ref().filter(|_| file.is_none()) {
        text.warn_idle(idle.span(), "rotation", "this environment is the same all around");
    }
    let rotation = rotation.as_ref().map_or(Ok(0.0), |rotation| text.number("rotation", rotation, &FINITE))?;
    match (file, scale) {
        (Some(file), scale) => {
            let path = named_file(file, "an .exr image", "exr", text)?;
            let mut image = image::read(&path, scale.unwrap_or([1.0; 3]))?;
            image.rotation = rotation;
            Ok(Environment::Image(image))
        }
        (None, Some(radiance)) => Ok(Environment::Constant(radiance)),
        (None, None) => Err(text.error(table.span(), "the environment is empty", "give it `radiance` or `file`")),
    }
}

/// The lights without extent: points, then directions, then spots.
pub(super) fn delta_lights(
    points: &[PointTable],
    directions: &[DirectionalTable],
    spots: &[SpotTable],
    text: &TomlText,
) -> Result<Vec<DeltaLight>, SceneError> {
    let position = |value: &Spanned<Numbers<3>>| text.vector("position", value, &FINITE);
    let intensity = |value: &Spanned<Colour>| text.colour("intensity", value, &NON_NEGATIVE);
    let points = points.iter().map(|table| {
        Ok(DeltaLight::Point { position: position(&table.position)?, intensity: intensity(&table.intensity)? })
    });
    let directions = directions.iter().map(|table| {
        let irradiance = text.colour("irradiance", &table.irradiance, &NON_NEGATIVE)?;
        Ok(DeltaLight::Directional { direction: direction(&table.direction, text)?, irradiance })
    });
    let spots = spots.iter().map(|table| {
        Ok(DeltaLight::Spot {
            position: position(&table.position)?,
            direction: direction(&table.direction, text)?,
            intensity: intensity(&table.intensity)?,
            angle: text.number("angle", &table.angle, &HALF_ANGLE)?,
        })
    });
    points.chain(directions).chain(spots).collect()
}

/// At unit length.
fn direction(value: &Spanned<Numbers<3>>, text: &TomlText) -> Result<[f32; 3], SceneError> {
    text.vector("direction", value, &FINITE)?;
    unit(DVec3::from(value.as_ref().0))
        .ok_or_else(|| text.error(value.span(), "`direction` is zero", "give the way that the light travels"))
}
