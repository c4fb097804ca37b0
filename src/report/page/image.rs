//! Images inside the page, and two of them under a slider.

use super::base64;
use crate::report::plot::escape;

/// An image as the bytes of a PNG file.
#[derive(Clone, Debug)]
pub struct Image {
    /// Unique on the page; what a [`Picker`] calls it.
    pub name: String,
    pub caption: String,
    pub png: Vec<u8>,
}

impl Image {
    pub(super) fn html(&self) -> String {
        let (name, caption) = (escape(&self.name), escape(&self.caption));
        let data = base64(&self.png);
        format!(
            "<figure><img data-name=\"{name}\" alt=\"{name}\" src=\"data:image/png;base64,{data}\">\
             <figcaption>{name}<br><small>{caption}</small></figcaption></figure>"
        )
    }
}

/// Two images of the page, one over the other, parted by a slider; which two can be chosen.
#[derive(Clone, Debug)]
pub struct Picker {
    /// Names of [`Image`]s on the page that may be chosen; they should have one size.
    pub names: Vec<String>,
    pub left: String,
    pub right: String,
}

impl Picker {
    pub(super) fn html(&self) -> String {
        let choice = |label: &str, chosen: &str| {
            let options: String = self.names.iter().map(|name| option(name, name == chosen)).collect();
            format!("<label>{label} <select>{options}</select></label>")
        };
        format!(
            "<div class=\"picker\"><div class=\"choices\">{}{}</div><div class=\"stack\"><img alt=\"left image\">\
             <img alt=\"right image\"><input type=\"range\" min=\"0\" max=\"100\" value=\"50\" \
             aria-label=\"where the left image ends\"></div></div>\n",
            choice("left", &self.left),
            choice("right", &self.right)
        )
    }
}

fn option(name: &str, selected: bool) -> String {
    format!("<option{}>{}</option>", if selected { " selected" } else { "" }, escape(name))
}
