//! Colours, dashes and markers.

/// One class a style, each with a colour for light and one for dark ground. After Okabe & Ito (2008), each darkened or
/// lightened until it stands at least 3 : 1 from white or from #16181d.
pub const STYLE: &str = ".s0{color:#0072b2}.s1{color:#c85200}.s2{color:#00805f}.s3{color:#b2558a}.s4{color:#9a7000}\
.s5{color:#2a86b8}.s6{color:#6b4fa0}.s7{color:#555}\
@media(prefers-color-scheme:dark){.s0{color:#4aa8e8}.s1{color:#ff8a4c}.s2{color:#2fc89a}.s3{color:#e39ac4}\
.s4{color:#e9b949}.s5{color:#8fd0f5}.s6{color:#b39ddb}.s7{color:#bbb}}";

/// What a page gives an SVG that stands in it, for one that stands alone.
pub const FILE_STYLE: &str = "svg{color:#1c1e21}.ground{fill:#fff}\
@media(prefers-color-scheme:dark){svg{color:#e4e6ea}.ground{fill:#16181d}}";

const COLOURS: [&str; 8] = ["#0072b2", "#c85200", "#00805f", "#b2558a", "#9a7000", "#2a86b8", "#6b4fa0", "#555555"];
const DASHES: [&str; 4] = ["none", "7 3", "2 2.5", "9 3 2 3"];

/// Attributes of the group that holds a curve: everything in it draws with `currentColor`.
pub fn group(style: usize) -> String {
    let n = style % COLOURS.len();
    // The attribute serves readers of SVG that know no style sheets.
    format!("class=\"s{n}\" color=\"{}\"", COLOURS[n])
}

/// Dash pattern: another one for each neighbour, so that lines differ without colour.
pub fn dash(style: usize) -> &'static str {
    DASHES[style % DASHES.len()]
}

/// A marker centred at (x, y): circle, square, triangle, diamond, and from the fifth style on the same ones hollow.
pub fn marker(style: usize, x: f64, y: f64) -> String {
    let paint = match style / 4 % 2 {
        0 => "fill=\"currentColor\"",
        _ => "fill=\"none\" stroke=\"currentColor\" stroke-width=\"1.3\"",
    };
    match style % 4 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" {paint}/>"),
        1 => format!("<rect x=\"{:.1}\" y=\"{:.1}\" width=\"5.4\" height=\"5.4\" {paint}/>", x - 2.7, y - 2.7),
        2 => format!("<path d=\"M{x:.1} {:.1}l3.5 6h-7z\" {paint}/>", y - 3.8),
        _ => format!("<path d=\"M{x:.1} {:.1}l3.8 3.8l-3.8 3.8l-3.8 -3.8z\" {paint}/>", y - 3.8),
    }
}
