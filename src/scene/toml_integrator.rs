//! `[integrator]`.

use super::domain::{Domain, NON_NEGATIVE, POSITIVE, UNIT};
use super::error::SceneError;
use super::gather::{MOST_DIRECTIONS, MOST_SETS};
use super::toml_text::{Colour, TomlText};
use super::{
    Gather, GatherCovariance, GatherLights, GatherMethod, GatherPdf, GatherShrinkage, GatherWeights, Integrator,
    IntegratorKind, LightPaths, MOST_BOUNCES, PathReuse, Roulette,
};
use crate::estimate::bmc::{Covariance, Points};
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

type Word = Option<Spanned<String>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IntegratorTable {
    kind: Word,
    max_bounces: Option<Spanned<i64>>,
    max_depth: Option<Spanned<f64>>,
    ambient: Option<Spanned<Colour>>,
    samples: Option<Spanned<i64>>,
    method: Word,
    points: Word,
    pdf: Word,
    covariance: Word,
    length: Option<Spanned<f64>>,
    smoothness: Option<Spanned<f64>>,
    sets: Option<Spanned<i64>>,
    rotate: Word,
    weights: Word,
    shrinkage: Word,
    lights: Word,
    light_paths: Word,
    path_reuse: Word,
    roulette_after: Option<Spanned<i64>>,
    roulette_below: Option<Spanned<f64>>,
}

const KINDS: [(&str, IntegratorKind); 7] = [
    ("path", IntegratorKind::Path),
    ("direct", IntegratorKind::Direct),
    ("gather", IntegratorKind::Gather),
    ("phong", IntegratorKind::Phong),
    ("normals", IntegratorKind::Normals),
    ("depth", IntegratorKind::Depth),
    ("hit", IntegratorKind::Hit),
];
const METHODS: [(&str, GatherMethod); 4] = [
    ("mc", GatherMethod::Mc),
    ("mc-is", GatherMethod::McIs),
    ("bmc", GatherMethod::Bmc),
    ("bmc-is", GatherMethod::BmcIs),
];
const POINTS: [(&str, Points); 3] =
    [("random", Points::Random), ("owen", Points::Owen), ("fibonacci", Points::Fibonacci)];
const PDFS: [(&str, GatherPdf); 3] =
    [("uniform", GatherPdf::Uniform), ("cosine", GatherPdf::Cosine), ("lobe", GatherPdf::Lobe)];
const ROTATIONS: [(&str, bool); 2] = [("none", false), ("random", true)];
const WEIGHTS: [(&str, GatherWeights); 2] = [("per-hit", GatherWeights::PerHit), ("shared", GatherWeights::Shared)];
const SHRINKAGES: [(&str, GatherShrinkage); 2] = [("pilot", GatherShrinkage::Pilot), ("none", GatherShrinkage::None)];
const LIGHT_PATHS: [(&str, LightPaths); 3] =
    [("auto", LightPaths::Auto), ("on", LightPaths::On), ("off", LightPaths::Off)];
const PATH_REUSE: [(&str, PathReuse); 2] = [("auto", PathReuse::Auto), ("off", PathReuse::Off)];
const LIGHTS: [(&str, GatherLights); 2] = [("seen", GatherLights::Seen), ("sampled", GatherLights::Sampled)];

/// A length-scale or smoothness where the scene gives none.
const DEFAULT_LENGTH: f64 = 0.5;
const DEFAULT_SMOOTHNESS: f64 = Covariance::SMOOTHNESS;

pub(super) fn integrator(table: Option<&IntegratorTable>, text: &TomlText) -> Result<Integrator, SceneError> {
    let mut integrator = Integrator::default();
    let Some(table) = table else { return Ok(integrator) };
    integrator.kind = choice("integrator", &table.kind, &KINDS, integrator.kind, text)?;
    if let Some(bounces) = &table.max_bounces {
        let possible = u32::try_from(*bounces.as_ref()).ok().filter(|&n| n <= MOST_BOUNCES);
        integrator.max_bounces = possible.ok_or_else(|| {
            let message = format!("`max_bounces` = {} is out of range", bounces.as_ref());
            text.error(bounces.span(), message, format!("give a whole number from 0 to {MOST_BOUNCES}"))
        })?;
    }
    if let Some(depth) = &table.max_depth {
        integrator.max_depth = text.number("max_depth", depth, &POSITIVE)?;
    }
    if let Some(ambient) = &table.ambient {
        integrator.ambient = text.colour("ambient", ambient, &NON_NEGATIVE)?;
    }
    integrator.light_paths =
        choice("way of `light_paths`", &table.light_paths, &LIGHT_PATHS, integrator.light_paths, text)?;
    integrator.path_reuse = choice("way of `path_reuse`", &table.path_reuse, &PATH_REUSE, integrator.path_reuse, text)?;
    integrator.roulette = roulette(table, text)?;
    integrator.gather = gather(table, text)?;
    table.warn_of_idle_keys(integrator.kind, text);
    Ok(integrator)
}

/// A key, where it stands if it does, and the kinds that read it.
type ReadBy = (&'static str, Option<Range<usize>>, &'static [IntegratorKind]);

impl IntegratorTable {
    /// Keys that this kind does not read. No error: who looks at a view for a moment changes `kind` alone.
    fn warn_of_idle_keys(&self, kind: IntegratorKind, text: &TomlText) {
        use IntegratorKind::{Depth, Direct, Gather, Path, Phong};
        fn at<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
            value.as_ref().map(Spanned::span)
        }
        // Field by field, so that a new one cannot be forgotten here.
        let IntegratorTable {
            kind: _,
            max_bounces,
            roulette_after,
            roulette_below,
            light_paths,
            path_reuse,
            ambient,
            max_depth,
            samples,
            method,
            points,
            pdf,
            covariance,
            length,
            smoothness,
            sets,
            rotate,
            weights,
            shrinkage,
            lights,
        } = self;
        let read_by: [ReadBy; 19] = [
            ("max_bounces", at(max_bounces), &[Path, Direct, Gather]),
            ("roulette_after", at(roulette_after), &[Path, Gather]),
            ("roulette_below", at(roulette_below), &[Path, Gather]),
            ("light_paths", at(light_paths), &[Path]),
            ("path_reuse", at(path_reuse), &[Path]),
            ("ambient", at(ambient), &[Phong]),
            ("max_depth", at(max_depth), &[Depth]),
            ("samples", at(samples), &[Gather]),
            ("method", at(method), &[Gather]),
            ("points", at(points), &[Gather]),
            ("pdf", at(pdf), &[Gather]),
            ("covariance", at(covariance), &[Gather]),
            ("length", at(length), &[Gather]),
            ("smoothness", at(smoothness), &[Gather]),
            ("sets", at(sets), &[Gather]),
            ("rotate", at(rotate), &[Gather]),
            ("weights", at(weights), &[Gather]),
            ("shrinkage", at(shrinkage), &[Gather]),
            ("lights", at(lights), &[Gather]),
        ];
        let name = KINDS.iter().find(|(_, known)| *known == kind).map_or("", |(name, _)| name);
        for (key, span, kinds) in read_by {
            if let Some(span) = span.filter(|_| !kinds.contains(&kind)) {
                text.warn_idle(span, key, &format!("kind = \"{name}\" does not read it"));
            }
        }
    }
}

fn roulette(table: &IntegratorTable, text: &TomlText) -> Result<Roulette, SceneError> {
    let default = Roulette::default();
    let below = table.roulette_below.as_ref().map(|share| text.number("roulette_below", share, &UNIT));
    Ok(Roulette {
        after: count("roulette_after", &table.roulette_after, default.after, u32::MAX, text)?,
        below: below.transpose()?.unwrap_or(default.below),
    })
}

fn gather(table: &IntegratorTable, text: &TomlText) -> Result<Gather, SceneError> {
    let default = Gather::default();
    let method = choice("method", &table.method, &METHODS, default.method, text)?;
    let weights = choice("way of `weights`", &table.weights, &WEIGHTS, default.weights, text)?;
    let per_hit = weights == GatherWeights::PerHit;
    if let Some(sets) = table.sets.as_ref().filter(|_| per_hit) {
        let mend = "leave `sets` out, or say weights = \"shared\"";
        return Err(text.error(sets.span(), "per-hit weights come without sets made beforehand", mend));
    }
    Ok(Gather {
        samples: count("samples", &table.samples, default.samples, MOST_DIRECTIONS, text)?,
        method,
        points: choice("kind of points", &table.points, &POINTS, default.points, text)?,
        pdf: pdf(table, method, text)?,
        covariance: covariance(table, text)?,
        sets: count("sets", &table.sets, default.sets, MOST_SETS, text)?,
        rotate: choice("way to `rotate`", &table.rotate, &ROTATIONS, !per_hit, text)?,
        weights,
        shrinkage: choice("way of `shrinkage`", &table.shrinkage, &SHRINKAGES, default.shrinkage, text)?,
        lights: choice("way of `lights`", &table.lights, &LIGHTS, default.lights, text)?,
    })
}

/// The value that a word stands for.
fn choice<T: Copy>(what: &str, word: &Word, known: &[(&str, T)], default: T, text: &TomlText) -> Result<T, SceneError> {
    let Some(word) = word else { return Ok(default) };
    known.iter().find(|(name, _)| *name == word.as_ref().as_str()).map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        let mend = match names.split_last() {
            Some((last, others)) => format!("use {} or {last}", others.join(", ")),
            None => String::new(),
        };
        text.error(word.span(), format!("unknown {what} `{}`", word.as_ref()), mend)
    })
}

fn count(key: &str, n: &Option<Spanned<i64>>, default: u32, most: u32, text: &TomlText) -> Result<u32, SceneError> {
    let Some(n) = n else { return Ok(default) };
    u32::try_from(*n.as_ref()).ok().filter(|n| (1..=most).contains(n)).ok_or_else(|| {
        text.error(n.span(), format!("`{key}` = {} is out of range", n.as_ref()), format!("give 1 to {most}"))
    })
}

/// `mc` and `bmc` are the uniform ones by definition.
fn pdf(table: &IntegratorTable, method: GatherMethod, text: &TomlText) -> Result<GatherPdf, SceneError> {
    let default = if method.is_importance() { GatherPdf::Cosine } else { GatherPdf::Uniform };
    let pdf = choice("pdf", &table.pdf, &PDFS, default, text)?;
    match &table.pdf {
        Some(word) if (pdf == GatherPdf::Uniform) == method.is_importance() => {
            let (message, mend) = if method.is_importance() {
                ("directions by importance are not uniform", "use cosine or lobe, or drop `-is` from the method")
            } else {
                ("mc and bmc draw uniform directions", "use the method with `-is`, or leave `pdf` out")
            };
            Err(text.error(word.span(), message, mend))
        }
        _ => Ok(pdf),
    }
}

fn covariance(table: &IntegratorTable, text: &TomlText) -> Result<GatherCovariance, SceneError> {
    const NAMES: [(&str, &str); 3] = [("sobolev", "smoothness"), ("se", "length"), ("fitted", "")];
    const ANY: Domain = Domain { contains: f32::is_finite, words: "finite" };
    let parameter = choice("covariance", &table.covariance, &NAMES, "smoothness", text)?;
    let given = [("length", &table.length), ("smoothness", &table.smoothness)];
    let stray = given.iter().find_map(|(key, value)| value.as_ref().filter(|_| *key != parameter).map(|v| (key, v)));
    if let Some((key, value)) = stray {
        let mend = "`length` goes with covariance = \"se\", `smoothness` with \"sobolev\"";
        return Err(text.error(value.span(), format!("this covariance has no `{key}`"), mend));
    }
    let number = |value: &Option<Spanned<f64>>, default| {
        value.as_ref().map_or(Ok(default), |value| {
            text.number(parameter, value, &ANY)?;
            Ok(*value.as_ref())
        })
    };
    let covariance = match parameter {
        "length" => Covariance::SquaredExponential { length: number(&table.length, DEFAULT_LENGTH)? },
        "smoothness" => Covariance::Sobolev { smoothness: number(&table.smoothness, DEFAULT_SMOOTHNESS)? },
        _ => return Ok(GatherCovariance::Fitted),
    };
    covariance.check().map(GatherCovariance::Given).map_err(|message| {
        let place = table.length.as_ref().or(table.smoothness.as_ref()).map_or(0..0, Spanned::span);
        let (message, mend) = message.split_once("; ").unwrap_or((&message, "mend it"));
        text.error(place, message, mend)
    })
}
