//! Values of a TOML file with the place they stand at.

use super::domain::Domain;
use super::error::SceneError;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Unexpected, Visitor};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// A TOML file being read.
pub(super) struct TomlText<'a> {
    pub file: &'a Path,
    pub text: &'a str,
}

impl TomlText<'_> {
    /// An error at a place in the file.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>, mend: impl Into<String>) -> SceneError {
        SceneError::at(self.file, self.line(span.start), message, mend)
    }

    /// Warns of a key that changes nothing.
    pub fn warn_idle(&self, span: Range<usize>, key: &str, why: &str) {
        log::warn!("{}:{}: `{key}` changes nothing: {why}", self.file.display(), self.line(span.start));
    }

    /// What the parser or serde has to complain of, in our words.
    pub fn complaint(&self, error: &toml::de::Error) -> SceneError {
        let span = error.span().unwrap_or(0..0);
        let message = error.message();
        if let Some((key, known)) =
            message.strip_prefix("unknown field ").and_then(|rest| rest.split_once(", expected "))
        {
            return self.error(
                span,
                format!("unknown key {key}"),
                format!("known here: {}", known.replace("one of ", "")),
            );
        }
        if let Some(key) = message.strip_prefix("missing field ") {
            return self.error(span, format!("{key} is missing"), "add it");
        }
        let key = self.text.get(span.clone()).and_then(|_| self.key_at(span.start)).unwrap_or_default();
        if let Some((what, wanted)) = message.rsplit_once(", expected ").filter(|_| message.starts_with("invalid ")) {
            let wanted = match wanted {
                "f64" => "a number",
                "i64" => "a whole number",
                "digits" => "digits on both sides of the point, as in 0.5",
                "a boolean" => "true or false",
                "a sequence" => "a list ([[NAME]] for tables)",
                table if table.starts_with("struct ") => "a table",
                other => other,
            };
            return self.error(span, format!("{key}{what}"), format!("write {wanted}"));
        }
        self.error(span, format!("{key}{message}"), "mend the TOML here")
    }

    /// The key that is set on the line of a byte.
    fn key_at(&self, offset: usize) -> Option<String> {
        let line = self.text.get(..offset)?.rsplit('\n').next()?;
        let key = line.split_once('=')?.0.trim();
        let is_plain = !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c));
        is_plain.then(|| format!("`{key}`: "))
    }

    /// A number of the domain, in single precision.
    pub fn number(&self, key: &str, value: &Spanned<f64>, domain: &Domain) -> Result<f32, SceneError> {
        domain.admit(*value.as_ref()).ok_or_else(|| self.outside(key, value, domain))
    }

    /// A vector whose components are in the domain.
    pub fn vector(&self, key: &str, value: &Spanned<Numbers<3>>, domain: &Domain) -> Result<[f32; 3], SceneError> {
        domain.admit3(value.as_ref().0).ok_or_else(|| self.outside(key, value, domain))
    }

    /// A colour whose channels are in the domain.
    pub fn colour(&self, key: &str, value: &Spanned<Colour>, domain: &Domain) -> Result<[f32; 3], SceneError> {
        domain.admit3(value.as_ref().0).ok_or_else(|| self.outside(key, value, domain))
    }

    /// Where a byte is, counted in lines from 1.
    pub fn line(&self, offset: usize) -> usize {
        let before = self.text.as_bytes().get(..offset).unwrap_or(self.text.as_bytes());
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    fn outside<T>(&self, key: &str, value: &Spanned<T>, domain: &Domain) -> SceneError {
        let written = self.text.get(value.span()).unwrap_or_default();
        self.error(value.span(), format!("`{key}` = {written} is out of range"), format!("it must be {}", domain.words))
    }
}

/// Exactly `N` numbers. (serde's own arrays let more than `N` pass.)
#[derive(Clone, Copy)]
pub(super) struct Numbers<const N: usize>(pub [f64; N]);

impl<'de, const N: usize> Deserialize<'de> for Numbers<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumbersVisitor { grey: false }).map(Numbers)
    }
}

/// Red, green and blue; written as three numbers, or as one for a grey.
#[derive(Clone, Copy)]
pub(super) struct Colour(pub [f64; 3]);

impl<'de> Deserialize<'de> for Colour {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumbersVisitor { grey: true }).map(Colour)
    }
}

/// A colour, or the name of an image in its place.
#[derive(Clone)]
pub(super) enum Paint {
    Colour(Colour),
    Image(String),
}

impl<'de> Deserialize<'de> for Paint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PaintVisitor(NumbersVisitor { grey: true }))
    }
}

struct PaintVisitor(NumbersVisitor<3>);

impl<'de> Visitor<'de> for PaintVisitor {
    type Value = Paint;

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str("three numbers [red, green, blue], one for a grey, or the name of an image")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Paint, E> {
        self.0.visit_i64(value).map(|rgb| Paint::Colour(Colour(rgb)))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Paint, E> {
        self.0.visit_f64(value).map(|rgb| Paint::Colour(Colour(rgb)))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Paint, E> {
        Ok(Paint::Image(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Paint, A::Error> {
        self.0.visit_seq(sequence).map(|rgb| Paint::Colour(Colour(rgb)))
    }
}

/// Reads `N` numbers or, where they are a colour's, one in place of all.
struct NumbersVisitor<const N: usize> {
    grey: bool,
}

impl<'de, const N: usize> Visitor<'de> for NumbersVisitor<N> {
    type Value = [f64; N];

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.grey {
            false => write!(formatter, "{N} numbers in brackets"),
            true => formatter.write_str("three numbers [red, green, blue], or one for a grey"),
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        if self.grey { Ok([value as f64; N]) } else { Err(E::invalid_type(Unexpected::Signed(value), &self)) }
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        if self.grey { Ok([value; N]) } else { Err(E::invalid_type(Unexpected::Float(value), &self)) }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Self::Value, A::Error> {
        let mut numbers = [0.0; N];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = sequence.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        match sequence.next_element::<f64>()? {
            None => Ok(numbers),
            Some(_) => Err(A::Error::invalid_length(N + 1, &self)),
        }
    }
}
