//! What the materials of a Wavefront MTL file mean here.

use super::domain::{Domain, NON_NEGATIVE, POSITIVE, UNIT};
use super::draft::{Draft, MapUse, Slot};
use super::error::SceneError;
use super::mtl_file::{Entry, Library};
use super::mtl_maps;
use super::notes::Notes;
use super::{Bsdf, ConductorFresnel, Masking, Material};
use crate::bsdf::EXPONENT_MAX;
use std::path::Path;

/// What the material of that name means; `None` where the library has none.
pub(super) fn material(library: &Library, name: &str, notes: &mut Notes) -> Option<Result<Draft, SceneError>> {
    let entry = library.entry(name)?;
    Some(Reading { file: &library.file, entry, notes, maps: Vec::new() }.material())
}

/// One material on its way to meaning something.
struct Reading<'a> {
    file: &'a Path,
    entry: &'a Entry,
    notes: &'a mut Notes,
    /// The images that are honoured.
    maps: Vec<MapUse>,
}

/// Roughness that is assumed where a metal gives none (`Pr`).
const ASSUMED_ROUGHNESS: f32 = 0.5;
/// Reflectance that is assumed where a material gives none (`Kd`).
pub(super) const ASSUMED_GREY: f32 = 0.8;
/// Index of refraction that is assumed where glass gives none (`Ni`).
const ASSUMED_IOR: f32 = 1.5;

impl Reading<'_> {
    fn material(mut self) -> Result<Draft, SceneError> {
        let mut emission = self.colour("Ke", self.entry.parsed.emissive, &NON_NEGATIVE)?.unwrap_or_default();
        // Exporters leave Ke at 0 beside a map; where it is not, it is the map's strength.
        if self.map("map_Ke", Slot::Emission)? && emission == [0.0; 3] {
            emission = [1.0; 3];
        }
        let bsdf = self.bsdf()?;
        let opacity = if matches!(bsdf, Bsdf::Dielectric { .. }) { 1.0 } else { self.opacity()? };
        if !self.map("norm", Slot::Normal)? {
            for key in ["map_Bump", "map_bump", "bump"] {
                if self.map(key, Slot::Bump)? {
                    break;
                }
            }
        }
        let metal_alpha = if self.is_mapped(Slot::Metallic) { self.alpha()? } else { 0.0 };
        self.pass_over();
        let name = self.entry.parsed.name.clone();
        let mut material = Material { name, bsdf, emission, opacity, ..Material::default() };
        material.maps.metal_alpha = metal_alpha;
        Ok(Draft { material, maps: self.maps })
    }

    /// `d` (or 1 − `Tr`), with `map_d`.
    fn opacity(&mut self) -> Result<f32, SceneError> {
        let dissolve = self.scalar("d", self.entry.parsed.dissolve, &UNIT)?;
        let transparency = self.scalar("Tr", self.unknown("Tr"), &UNIT)?;
        let opacity = dissolve.or(transparency.map(|tr| 1.0 - tr)).unwrap_or(1.0);
        // Nothing is mapped onto nothing: some exporters write 0 beside a map.
        Ok(if self.map("map_d", Slot::Opacity)? && opacity == 0.0 { 1.0 } else { opacity })
    }

    /// Honours a texture statement, if there is one of that key.
    fn map(&mut self, key: &str, slot: Slot) -> Result<bool, SceneError> {
        let Some(value) = self.entry.maps.get(key) else { return Ok(false) };
        let line = self.line(key);
        let statement = mtl_maps::parse(key, value, slot, self.file, line).map_err(|what| {
            SceneError::at(self.file, line, format!("`{key}` {what}"), "write `map_Kd [options] FILE`")
        })?;
        for option in statement.passed_over {
            self.notes.not_honoured(self.file, line, &option, "textures repeat, and are read as they are");
        }
        self.maps.push(statement.map);
        Ok(true)
    }

    fn bsdf(&mut self) -> Result<Bsdf, SceneError> {
        let parsed = &self.entry.parsed;
        match parsed.illumination_model {
            Some(4 | 6 | 7 | 9) => {
                let ior = self.scalar("Ni", parsed.optical_density, &POSITIVE)?;
                let ior = ior.unwrap_or_else(|| self.assume("index of refraction (Ni)", ASSUMED_IOR));
                return Ok(Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior });
            }
            Some(5) => {
                let reflectance = self.colour("Ks", parsed.specular, &UNIT)?.unwrap_or([1.0; 3]);
                let reflectance = if self.map("map_Ks", Slot::Colour)? { [1.0; 3] } else { reflectance };
                return Ok(conductor(0.0, ConductorFresnel::Constant { reflectance }));
            }
            _ => {}
        }
        let metallic = self.scalar("Pm", self.unknown("Pm"), &UNIT)?.is_some_and(|metallic| metallic >= 0.5);
        let metallic = metallic & !self.map("map_Pm", Slot::Metallic)?;
        let albedo = self.colour("Kd", parsed.diffuse, &UNIT)?;
        // A map replaces Kd: exporters leave there what the number was before the image came.
        let albedo = if self.map("map_Kd", Slot::Colour)? { Some([1.0; 3]) } else { albedo };
        let albedo = albedo.unwrap_or_else(|| [self.assume("diffuse reflectance (Kd)", ASSUMED_GREY); 3]);
        if metallic {
            self.map("map_Pr", Slot::Roughness)?;
            return Ok(conductor(self.alpha()?, ConductorFresnel::Schlick { f0: albedo }));
        }
        let is_mapped = self.map("map_Pr", Slot::Roughness)?;
        if is_mapped || self.entry.lines.contains_key("Pr") {
            let ior = self.scalar("Ni", parsed.optical_density, &POSITIVE)?;
            let ior = ior.unwrap_or_else(|| self.assume("index of refraction (Ni)", ASSUMED_IOR));
            let alpha = self.alpha()?;
            return Ok(Bsdf::Coated { reflectance: albedo, alpha, masking: Masking::Correlated, ior });
        }
        self.phong(albedo)
    }

    /// Kd with a lobe of Ks where there is one (`Ns` > 0), Lambert where not.
    fn phong(&mut self, diffuse: [f32; 3]) -> Result<Bsdf, SceneError> {
        let parsed = &self.entry.parsed;
        let Some(exponent) = parsed.shininess.filter(|&ns| ns > 0.0) else {
            return Ok(Bsdf::Diffuse { reflectance: diffuse });
        };
        let specular = self.colour("Ks", parsed.specular, &NON_NEGATIVE)?.unwrap_or_default();
        // As with Kd: the image says it alone.
        let specular = if self.map("map_Ks", Slot::Specular)? { [1.0; 3] } else { specular };
        if exponent > EXPONENT_MAX {
            self.warn("Ns", "it is lowered to 1e7, the narrowest lobe that is rendered");
        }
        // Where an image says Kd or Ks, both are held to 1 together point by point.
        let is_mapped = self.is_mapped(Slot::Colour) || self.is_mapped(Slot::Specular);
        let most = |c: usize| if is_mapped { 1.0 } else { 1.0 - diffuse[c] };
        let room = std::array::from_fn(|c| specular[c].min(most(c)));
        if room != specular {
            self.warn("Ks", "Kd + Ks is more than 1 in a channel, and Ks lowered to 1 - Kd there");
        }
        if room == [0.0; 3] {
            return Ok(Bsdf::Diffuse { reflectance: diffuse });
        }
        Ok(Bsdf::Phong { diffuse, specular: room, exponent: exponent.min(EXPONENT_MAX) })
    }

    /// GGX width of a metal, a coat, or of where `map_Pm` makes it a metal.
    fn alpha(&mut self) -> Result<f32, SceneError> {
        let roughness = match self.scalar("Pr", self.unknown("Pr"), &UNIT)? {
            Some(roughness) => roughness,
            None if self.is_mapped(Slot::Roughness) => 1.0,
            None => self.assume("roughness (Pr)", ASSUMED_ROUGHNESS),
        };
        Ok(roughness * roughness)
    }

    fn is_mapped(&self, slot: Slot) -> bool {
        self.maps.iter().any(|map| map.slot == slot)
    }

    /// Warns of the keys that change nothing for any material yet.
    fn pass_over(&mut self) {
        for key in self.entry.lines.keys() {
            let why = match key.as_str() {
                "newmtl" | "Kd" | "Ks" | "Ke" | "Ns" | "Ni" | "d" | "Tr" | "illum" | "Pm" | "Pr" => continue,
                "Ka" if self.entry.parsed.ambient == Some([0.0; 3]) => continue,
                "Ka" => "ambient light is computed, not given",
                key if self.unknown(key) == Some(0.0) => continue,
                key if self.maps.iter().any(|map| map.key == key) => continue,
                key if mtl_maps::is_map(key) => "no material here has such a map",
                _ => "no material here has such a property",
            };
            self.notes.not_honoured(self.file, self.entry.lines[key], key, why);
        }
    }

    fn warn(&mut self, key: &str, why: &str) {
        self.notes.not_honoured(self.file, self.line(key), key, why);
    }

    fn assume(&mut self, what: &str, value: f32) -> f32 {
        let name = &self.entry.parsed.name;
        self.notes.assume(format!("material `{name}` gives no {what}: {value} is assumed"));
        value
    }

    fn line(&self, key: &str) -> usize {
        self.entry.lines.get(key).copied().unwrap_or(1)
    }

    /// A key that tobj keeps as text.
    fn unknown(&self, key: &str) -> Option<f32> {
        self.entry.parsed.unknown_param.get(key)?.parse().ok()
    }

    fn parameter(&self, key: &str, value: Option<f32>) -> Option<f32> {
        value.filter(|_| self.entry.lines.contains_key(key))
    }

    fn scalar(&self, key: &str, value: Option<f32>, domain: &Domain) -> Result<Option<f32>, SceneError> {
        let Some(value) = self.parameter(key, value) else { return Ok(None) };
        if domain.admit(value.into()).is_none() {
            let message = format!("`{key}` = {value} is not {}", domain.words);
            return Err(SceneError::at(
                self.file,
                self.line(key),
                message,
                "change it, or replace the material in a scene file",
            ));
        }
        Ok(Some(value))
    }

    fn colour(&self, key: &str, value: Option<[f32; 3]>, domain: &Domain) -> Result<Option<[f32; 3]>, SceneError> {
        for channel in value.into_iter().flatten() {
            self.scalar(key, Some(channel), domain)?;
        }
        Ok(value)
    }
}

fn conductor(alpha: f32, fresnel: ConductorFresnel) -> Bsdf {
    Bsdf::Conductor { alpha, masking: Masking::Correlated, fresnel }
}
