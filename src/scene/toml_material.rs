//! `[materials.NAME]`.

use super::domain::{Domain, EXPONENT, EXTINCTION, METAL_INDEX, NON_NEGATIVE, POSITIVE, UNIT};
use super::draft::{Draft, MapUse, Slot};
use super::error::SceneError;
use super::load::beside;
use super::toml_text::{Colour, Paint, TomlText};
use super::{Bsdf, ConductorFresnel, Masking, Material};
use serde::Deserialize;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;

/// The keys of all types of material; which belong to which is decided once the type is known.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    r#type: Spanned<String>,
    reflectance: Option<Spanned<Paint>>,
    emission: Option<Spanned<Paint>>,
    opacity: Option<Spanned<Paint>>,
    normal_map: Option<Spanned<String>>,
    alpha: Option<Spanned<f64>>,
    masking: Option<Spanned<String>>,
    eta: Option<Spanned<Colour>>,
    k: Option<Spanned<Colour>>,
    f0: Option<Spanned<Paint>>,
    ior: Option<Spanned<f64>>,
    diffuse: Option<Spanned<Paint>>,
    specular: Option<Spanned<Paint>>,
    exponent: Option<Spanned<f64>>,
}

impl MaterialTable {
    /// The material it describes.
    pub fn read(&self, name: &str, text: &TomlText) -> Result<Draft, SceneError> {
        let reading = Reading { table: self, text, maps: RefCell::default() };
        let emission = reading.paint("emission", &self.emission, &NON_NEGATIVE, Slot::Emission)?.unwrap_or_default();
        let opacity = reading.opacity()?;
        let bsdf = reading.bsdf()?;
        if let Some(image) = &self.normal_map {
            reading.map("normal_map", image.as_ref(), image.span(), Slot::Normal);
        }
        let material = Material { name: name.to_owned(), bsdf, emission, opacity, ..Material::default() };
        Ok(Draft { material, maps: reading.maps.into_inner() })
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
    /// The images named so far.
    maps: RefCell<Vec<MapUse>>,
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
        let diffuse = self.paint("diffuse", &self.table.diffuse, &UNIT, Slot::Colour)?;
        let diffuse = diffuse.ok_or_else(|| self.missing("diffuse"))?;
        let specular = self.paint("specular", &self.table.specular, &UNIT, Slot::Specular)?;
        let specular = specular.ok_or_else(|| self.missing("specular"))?;
        let exponent = self.table.exponent.as_ref().ok_or_else(|| self.missing("exponent"))?;
        let exponent = self.text.number("exponent", exponent, &EXPONENT)?;
        // What the rounding of both to f32 may add.
        let most = 1.0 + f64::from(f32::EPSILON);
        // Images are held to it point by point.
        let is_number = self.maps.borrow().iter().all(|map| !matches!(map.slot, Slot::Colour | Slot::Specular));
        if is_number && diffuse.iter().zip(specular).any(|(&kd, ks)| f64::from(kd) + f64::from(ks) > most) {
            let place = self.table.specular.as_ref().map_or(0..0, Spanned::span);
            let message = "`diffuse` + `specular` is more than 1 in a channel: the surface would make light";
            return Err(self.text.error(place, message, "lower one of them"));
        }
        Ok(Bsdf::Phong { diffuse, specular, exponent })
    }

    fn reflectance(&self) -> Result<[f32; 3], SceneError> {
        let reflectance = self.paint("reflectance", &self.table.reflectance, &UNIT, Slot::Colour)?;
        reflectance.ok_or_else(|| self.missing("reflectance"))
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
                format!("known here: type, emission, opacity, normal_map, {}", known.join(", ")),
            )),
        }
    }

    fn fresnel(&self) -> Result<ConductorFresnel, SceneError> {
        let eta = self.colour("eta", &self.table.eta, &METAL_INDEX)?;
        let k = self.colour("k", &self.table.k, &EXTINCTION)?;
        let f0 = self.paint("f0", &self.table.f0, &UNIT, Slot::Colour)?;
        let reflectance = self.paint("reflectance", &self.table.reflectance, &UNIT, Slot::Colour)?;
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

    /// A colour; or 1 for an image, which will be multiplied by it.
    fn paint(
        &self,
        key: &str,
        value: &Option<Spanned<Paint>>,
        domain: &Domain,
        slot: Slot,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        let Some(value) = value else { return Ok(None) };
        match value.as_ref() {
            Paint::Colour(colour) => Ok(Some(self.text.colour(key, &Spanned::new(value.span(), *colour), domain)?)),
            Paint::Image(image) => {
                self.map(key, image, value.span(), slot);
                Ok(Some([1.0; 3]))
            }
        }
    }

    fn opacity(&self) -> Result<f32, SceneError> {
        match (self.paint("opacity", &self.table.opacity, &UNIT, Slot::Opacity)?, &self.table.opacity) {
            (Some([r, g, b]), Some(value)) if r != g || r != b => {
                Err(self.text.error(value.span(), "`opacity` has no colour", "give one number, or an image"))
            }
            (opacity, _) => Ok(opacity.map_or(1.0, |[opacity, ..]| opacity)),
        }
    }

    fn map(&self, key: &str, image: &str, span: Range<usize>, slot: Slot) {
        self.maps.borrow_mut().push(MapUse {
            slot,
            image: beside(self.text.file, image),
            file: self.text.file.to_path_buf(),
            line: self.text.line(span.start),
            key: key.to_owned(),
            channel: None,
            scale: [1.0; 2],
            offset: [0.0; 2],
            strength: 1.0,
        });
    }

    fn missing(&self, key: &str) -> SceneError {
        self.at_type(format!("a {} material needs `{key}`", self.table.r#type.as_ref()), "add it")
    }

    fn at_type(&self, message: impl Into<String>, mend: &str) -> SceneError {
        self.text.error(self.table.r#type.span(), message, mend)
    }
}
