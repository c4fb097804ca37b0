//! Variants of a render: `NAME: FLAGS; NAME: FLAGS`, each read by the parser of `octolux render` itself.
//!
//! A flag of the variant replaces the same one of the common flags. A first word that is no flag is another scene.
//! What says how much to render or where to write is not a variant's to say.

use super::render::RenderArgs;
use super::{CliError, usage};
use clap::{CommandFactory, FromArgMatches, Parser, parser::ValueSource};
use std::path::Path;

/// Flags of `render` that a study sets itself.
const NOT_A_VARIANTS: [&str; 11] =
    ["output", "png", "json", "spp", "time", "error", "seed", "state", "resume", "samples", "ladder"];

/// A variant's name, its flags as given, and what `render` makes of them.
pub struct VariantArgs {
    pub name: String,
    pub arguments: String,
    pub render: RenderArgs,
}

#[derive(Parser)]
#[command(no_binary_name = true, args_override_self = true, disable_help_flag = true)]
struct Flags {
    #[command(flatten)]
    render: RenderArgs,
}

/// Parses all `lists`; without any there is one variant of the common flags alone.
///
/// # Errors
/// One line: flags that `render` does not have, or one of [`NOT_A_VARIANTS`]; two variants alike.
pub fn parse(lists: &[String], scene: &Path, common: &[String]) -> Result<Vec<VariantArgs>, CliError> {
    let texts = lists.iter().flat_map(|list| list.split(';')).map(str::trim).filter(|text| !text.is_empty());
    let mut named: Vec<(String, String)> = texts.map(split).collect();
    if named.is_empty() {
        let name = scene.file_stem().filter(|stem| *stem != "scene").or(scene.parent().and_then(Path::file_name));
        named.push((name.map_or("octolux".into(), |n| n.to_string_lossy().into_owned()), String::new()));
    }
    let mut variants: Vec<VariantArgs> = Vec::new();
    for (name, flags) in named {
        let variant = variant(name, &flags, scene, common)?;
        if let Some(twin) = variants.iter().find(|v| v.name == variant.name || v.arguments == variant.arguments) {
            return Err(CliError::Usage(format!(
                "variants `{}` and `{}` have the same name or the same flags; make them differ",
                twin.name, variant.name
            )));
        }
        variants.push(variant);
    }
    Ok(variants)
}

/// Name and flags; a text that has no name is its own.
fn split(text: &str) -> (String, String) {
    match text.split_once(':') {
        Some((name, flags)) if !name.trim().is_empty() && !name.trim_start().starts_with('-') => {
            (name.trim().to_owned(), flags.trim().to_owned())
        }
        _ => (text.to_owned(), text.to_owned()),
    }
}

fn variant(name: String, flags: &str, scene: &Path, common: &[String]) -> Result<VariantArgs, CliError> {
    let fail =
        |why: String| CliError::Usage(format!("variant `{name}`: {why}; `octolux render --help` lists the flags"));
    let mut own: Vec<&str> = flags.split_whitespace().collect();
    let other_scene = own.first().copied().filter(|word| !word.starts_with('-'));
    let scene = other_scene.map_or(scene.to_string_lossy().into_owned(), |_| own.remove(0).to_owned());
    let words: Vec<&str> = common.iter().map(String::as_str).chain(own).collect();
    // The scene comes first: after flags it could pass for the value of one.
    let all = std::iter::once(scene.as_str()).chain(words.iter().copied());
    let first_line =
        |error: clap::Error| fail(usage::complaint(&error).map_or_else(|| error.to_string(), |said| said.what));
    let matches = usage::with_negative_numbers(Flags::command()).try_get_matches_from(all).map_err(first_line)?;
    let given = |id: &&&str| {
        // A name that `render` no longer had would be a fault of this list: tests see it.
        matches.try_contains_id(id).is_ok() && matches.value_source(id) == Some(ValueSource::CommandLine)
    };
    if let Some(flag) = NOT_A_VARIANTS.iter().find(given) {
        return Err(fail(format!("--{flag} is not a variant's to say")));
    }
    let render = Flags::from_arg_matches(&matches).map_err(first_line)?.render;
    let arguments = std::iter::once(scene.as_str()).chain(words).collect::<Vec<_>>().join(" ");
    Ok(VariantArgs { name, arguments, render })
}
