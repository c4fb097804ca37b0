//! `map_Kd -s 2 2 wood.png`: the texture statements of MTL.

use super::draft::{MapUse, Slot};
use super::load::beside;
use super::texture::Channel;
use std::path::Path;

/// Is this the key of a texture statement?
pub(super) fn is_map(key: &str) -> bool {
    key.starts_with("map_") || matches!(key, "bump" | "norm" | "disp" | "decal" | "refl")
}

/// A texture statement, and those of its options that are not honoured.
pub(super) struct Statement {
    pub map: MapUse,
    pub passed_over: Vec<String>,
}

/// Reads the value of a texture statement for `slot`. The error is what is wrong.
pub(super) fn parse(key: &str, value: &str, slot: Slot, mtl: &Path, line: usize) -> Result<Statement, String> {
    let mut map = MapUse {
        slot,
        image: Default::default(),
        file: mtl.to_path_buf(),
        line,
        key: key.to_owned(),
        channel: None,
        scale: [1.0; 2],
        offset: [0.0; 2],
        strength: 1.0,
    };
    let mut passed_over = Vec::new();
    let mut rest = value.trim();
    while rest.starts_with('-') {
        let Some((option, after)) = rest.split_once(char::is_whitespace) else { break };
        rest = after.trim_start();
        match option {
            "-s" => map.scale = pair(&mut rest, 1.0).ok_or("`-s` takes one to three numbers")?,
            "-o" => map.offset = pair(&mut rest, 0.0).ok_or("`-o` takes one to three numbers")?,
            "-bm" => map.strength = number(&mut rest).ok_or("`-bm` takes a number")?,
            "-imfchan" => {
                map.channel = Some(match word(&mut rest) {
                    "r" => Channel::Red,
                    "g" => Channel::Green,
                    "b" => Channel::Blue,
                    "m" => Channel::Alpha,
                    "l" => Channel::Mean,
                    other => return Err(format!("`-imfchan {other}` is none of r, g, b, m, l")),
                })
            }
            // Filtering and resolution do not apply here; "no clamping" is what happens.
            "-blendu" | "-blendv" | "-texres" | "-boost" => drop(word(&mut rest)),
            "-clamp" | "-cc" | "-type" => {
                if word(&mut rest) != "off" {
                    passed_over.push(option.to_owned());
                }
            }
            "-mm" => {
                if [number(&mut rest), number(&mut rest)] != [Some(0.0), Some(1.0)] {
                    passed_over.push(option.to_owned());
                }
            }
            "-t" => {
                pair(&mut rest, 0.0).ok_or("`-t` takes one to three numbers")?;
                passed_over.push(option.to_owned());
            }
            other => return Err(format!("unknown option `{other}`")),
        }
    }
    if rest.is_empty() {
        return Err("names no file".to_owned());
    }
    let path = beside(mtl, rest);
    // Exporters on Windows write its separators.
    map.image = if path.exists() { path } else { beside(mtl, &rest.replace('\\', "/")) };
    Ok(Statement { map, passed_over })
}

/// Takes a word off the front.
fn word<'a>(rest: &mut &'a str) -> &'a str {
    let (first, after) = rest.split_once(char::is_whitespace).unwrap_or((*rest, ""));
    *rest = after.trim_start();
    first
}

fn number(rest: &mut &str) -> Option<f32> {
    let first = rest.split_whitespace().next()?.parse().ok().filter(|x: &f32| x.is_finite())?;
    word(rest);
    Some(first)
}

/// One to three numbers, of which the third is for solid textures.
fn pair(rest: &mut &str, default: f32) -> Option<[f32; 2]> {
    let u = number(rest)?;
    let v = number(rest).unwrap_or(default);
    number(rest);
    Some([u, v])
}
