//! `[materials.NAME]`.

use super::domain::{Domain, EXPONENT, NON_NEGATIVE, POSITIVE, UNIT};
use super::error::SceneError;
use super::toml_text::{Colour, TomlText};
use super::{Bsdf, ConductorFresnel, Masking, Material};
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// The keys of all types of material; which belong to which is decided once the type is known.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    r#type: Spanned<String>,
    reflectance: Option<Spanned<Colour>>,
    emission: Option<Spanned<Colour>>,
    alpha: Option<Spanned<f64>>,
    masking: Option<Spanned<String>>,
    eta: Option<Spanned<Colour>>,
    k: Option<Spanned<Colour>>,
    f0: Option<Spanned<Colour>>,
    ior: Option<Spanned<f64>>,
    diffuse: Option<Spanned<Colour>>,
    specular: Option<Spanned<Colour>>,
    exponent: Option<Spanned<f64>>,
}

impl MaterialTable {
    /// The material it describes.
    pub fn read(&self, name: &str, text: &TomlText) -> Result<Material, SceneError> {
        let reading = Reading { table: self, text };
        let emission = reading.colour("emission", &self.emission, &NON_NEGATIVE)?.unwrap_or_default();
        Ok(Material { name: name.to_owned(), bsdf: reading.bsdf()?, emission })
    }

    /// The keys that are set, with their places.
    fn present(&self) -> impl Iterator<Item = (&'static str, Range<usize>)> {
        fn place<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
            value.as_ref().map(Spanned::span)
        }
        [
            ("reflectance", place(&self.reflectance)),
            ("alpha", place(&self.alpha)),
            ("masking", place(&self.masking)),
            ("eta", place(&self.eta)),
            ("k", place(&self.k)),
            ("f0", place(&self.f0)),
            ("ior", place(&self.ior)),
            ("diffuse", place(&self.diffuse)),
            ("specular", place(&self.specular)),
            ("exponent", place(&self.exponent)),
        ]
        .into_iter()
        .filter_map(|(key, place)| Some((key, place?)))
    }
}

struct Reading<'a> {
    table: &'a MaterialTable,
    text: &'a TomlText<'a>,
}

impl Reading<'_> {
    fn bsdf(&self) -> Result<Bsdf, SceneError> {
        match self.table.r#type.as_ref().as_str() {
            "diffuse" => {
                self.only(&["reflectance"])?;
                Ok(Bsdf::Diffuse { reflectance: self.reflectance()? })
            }
            "conductor" => {
                self.only(&["alpha", "masking", "eta", "k", "f0", "reflectance"])?;
                Ok(Bsdf::Conductor { alpha: self.alpha()?, masking: self.masking()?, fresnel: self.fresnel()? })
            }
            "dielectric" => {
                self.only(&["alpha", "masking", "ior"])?;
                Ok(Bsdf::Dielectric { alpha: self.alpha()?, masking: self.masking()?, ior: self.ior()? })
            }
            "phong" => {
                self.only(&["diffuse", "specular", "exponent"])?;
                self.phong()
            }
            "coated" => {
                self.only(&["reflectance", "ior", "alpha", "masking"])?;
                let (reflectance, ior) = (self.reflectance()?, self.ior()?);
                Ok(Bsdf::Coated { reflectance, alpha: self.alpha()?, masking: self.masking()?, ior })
            }
            other => Err(self.at_type(
                format!("unknown material type `{other}`"),
                "use diffuse, phong, conductor, dielectric or coated",
            )),
        }
    }

    fn phong(&self) -> Result<Bsdf, SceneError> {
        let diffuse = self.colour("diffuse", &self.table.diffuse, &UNIT)?.ok_or_else(|| self.missing("diffuse"))?;
        let specular = self.colour("specular", &self.table.specular, &UNIT)?.ok_or_else(|| self.missing("specular"))?;
        let exponent = self.table.exponent.as_ref().ok_or_else(|| self.missing("exponent"))?;
        let exponent = self.text.number("exponent", exponent, &EXPONENT)?;
        // What the rounding of both to f32 may add.
        let most = 1.0 + f64::from(f32::EPSILON);
        if diffuse.iter().zip(specular).any(|(&kd, ks)| f64::from(kd) + f64::from(ks) > most) {
            let place = self.table.specular.as_ref().map_or(0..0, Spanned::span);
            let message = "`diffuse` + `specular` is more than 1 in a channel: the surface would make light";
            return Err(self.text.error(place, message, "lower one of them"));
        }
        Ok(Bsdf::Phong { diffuse, specular, exponent })
    }

    fn reflectance(&self) -> Result<[f32; 3], SceneError> {
        self.colour("reflectance", &self.table.reflectance, &UNIT)?.ok_or_else(|| self.missing("reflectance"))
    }

    fn ior(&self) -> Result<f32, SceneError> {
        let ior = self.table.ior.as_ref().ok_or_else(|| self.missing("ior"))?;
        self.text.number("ior", ior, &POSITIVE)
    }

    fn only(&self, known: &[&str]) -> Result<(), SceneError> {
        match self.table.present().find(|(key, _)| !known.contains(key)) {
            None => Ok(()),
            Some((key, place)) => Err(self.text.error(
                place,
                format!("a {} material has no key `{key}`", self.table.r#type.as_ref()),
                format!("known here: type, emission, {}", known.join(", ")),
            )),
        }
    }

    fn fresnel(&self) -> Result<ConductorFresnel, SceneError> {
        let eta = self.colour("eta", &self.table.eta, &POSITIVE)?;
        let k = self.colour("k", &self.table.k, &NON_NEGATIVE)?;
        let f0 = self.colour("f0", &self.table.f0, &UNIT)?;
        let reflectance = self.colour("reflectance", &self.table.reflectance, &UNIT)?;
        match (eta, k, f0, reflectance) {
            (Some(eta), Some(k), None, None) => Ok(ConductorFresnel::Exact { eta, k }),
            (None, None, Some(f0), None) => Ok(ConductorFresnel::Schlick { f0 }),
            (None, None, None, Some(reflectance)) => Ok(ConductorFresnel::Constant { reflectance }),
            (Some(_), None, None, None) => Err(self.missing("k")),
            (None, Some(_), None, None) => Err(self.missing("eta")),
            _ => Err(self.at_type("a conductor's Fresnel term is not clear", "give eta and k, or f0, or reflectance")),
        }
    }

    fn alpha(&self) -> Result<f32, SceneError> {
        self.table.alpha.as_ref().map_or(Ok(0.0), |alpha| self.text.number("alpha", alpha, &UNIT))
    }

    fn masking(&self) -> Result<Masking, SceneError> {
        let Some(masking) = &self.table.masking else { return Ok(Masking::Correlated) };
        match masking.as_ref().as_str() {
            "correlated" => Ok(Masking::Correlated),
            "separable" => Ok(Masking::Separable),
            other => {
                let message = format!("unknown masking `{other}`");
                Err(self.text.error(masking.span(), message, "use correlated or separable"))
            }
        }
    }

    fn colour(
        &self,
        key: &str,
        value: &Option<Spanned<Colour>>,
        domain: &Domain,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        value.as_ref().map(|value| self.text.colour(key, value, domain)).transpose()
    }

    fn missing(&self, key: &str) -> SceneError {
        self.at_type(format!("a {} material needs `{key}`", self.table.r#type.as_ref()), "add it")
    }

    fn at_type(&self, message: impl Into<String>, mend: &str) -> SceneError {
        self.text.error(self.table.r#type.span(), message, mend)
    }
}
