//! A function of x as a user writes it.

use exmex::{Express, FlatEx};

/// An expression in x: + − * / ^, sin, cos, tan, exp, ln, log10, sqrt, abs, floor, signum …, PI, E.
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    /// Boxed: it is some 20 kB.
    parsed: Box<FlatEx<f64>>,
    constant: bool,
}

impl Expression {
    /// # Errors
    /// What is wrong with the text, and what to write instead.
    pub fn parse(text: &str) -> Result<Self, String> {
        // A comma or an empty text are no expressions, and parentheses nest as deep as memory: bound both.
        if text.trim().is_empty() || text.len() > 2000 {
            return Err(format!("an expression of {} letters; write one in x, as in x^2*exp(-x)", text.len()));
        }
        let parsed: FlatEx<f64> =
            exmex::parse(text).map_err(|e| format!("{text:?}: {e}; write an expression in x, as in x^2*exp(-x)"))?;
        let names = parsed.var_names();
        if let Some(unknown) = names.iter().find(|name| name.as_str() != "x") {
            return Err(format!("{text:?} speaks of {unknown:?}; the only variable is x"));
        }
        let constant = names.is_empty();
        Ok(Self { text: text.to_owned(), parsed: Box::new(parsed), constant })
    }

    /// NaN where it has no value.
    pub fn at(&self, x: f64) -> f64 {
        let arguments: &[f64] = if self.constant { &[] } else { &[x] };
        self.parsed.eval(arguments).unwrap_or(f64::NAN)
    }

    pub fn text(&self) -> &str {
        &self.text
    }
}
