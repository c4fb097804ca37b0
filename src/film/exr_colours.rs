//! Which part and which channels of an OpenEXR file are its colours.

use exr::meta::attribute::Text;
use exr::meta::header::Header;

/// The first flat part with colour, and which of its channels are red, green and blue.
pub(super) fn find_colour(headers: &[Header]) -> Result<(usize, [usize; 3]), String> {
    for (part, header) in headers.iter().enumerate().filter(|(_, header)| !header.deep) {
        if let Some(colour) = colour_channels(header)? {
            return Ok((part, colour));
        }
    }
    let names: Vec<_> = headers.iter().flat_map(|h| &h.channels.list).map(|c| string(&c.name)).take(8).collect();
    Err(format!("no flat part has channels R, G, B or Y (it has: {})", names.join(", ")))
}

/// R, G and B; else those of the only layer that has them, or of the only one called `Combined` (Blender's for the image
/// itself, among its passes); else Y.
fn colour_channels(header: &Header) -> Result<Option<[usize; 3]>, String> {
    let names: Vec<String> = header.channels.list.iter().map(|c| string(&c.name)).collect();
    let place = |name: &str| names.iter().position(|known| known == name);
    let triple = |prefix: &str| {
        Some([place(&format!("{prefix}R"))?, place(&format!("{prefix}G"))?, place(&format!("{prefix}B"))?])
    };
    if let Some(plain) = triple("") {
        return Ok(Some(plain));
    }
    let own_layers = ["variance.", "albedo.", "bmc.variance."];
    let prefixes = names.iter().filter_map(|name| name.strip_suffix('R')).filter(|p| p.ends_with('.'));
    let layers = prefixes.filter(|p| !own_layers.contains(p)).filter_map(|p| Some((p, triple(p)?)));
    let layers: Vec<_> = layers.collect();
    let mut combined = layers.iter().filter(|(name, _)| *name == "Combined." || name.ends_with(".Combined."));
    match (&layers[..], combined.next(), combined.next()) {
        ([], ..) => Ok(place("Y").map(|y| [y; 3])),
        ([(_, only)], ..) | (_, Some((_, only)), None) => Ok(Some(*only)),
        _ => {
            let names: Vec<_> = layers.iter().map(|(name, _)| name.trim_end_matches('.')).take(8).collect();
            Err(format!(
                "several layers have R, G and B ({}): write the one that is meant without a name",
                names.join(", ")
            ))
        }
    }
}

/// A name or value as Rust has it; what is not UTF-8 in it is marked.
pub(super) fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}
