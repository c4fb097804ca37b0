//! A report as one HTML file: everything in it, nothing fetched, readable from phone width up.
//!
//! ```
//! use octolux::report::page::{Block, Page, Section, Table};
//! let table = Table::new(["method", "RMSE"]).row(["Monte Carlo", "0.012"]);
//! let section = Section::new("Errors").with(Block::prose("Against samples.")).with(Block::Table(table));
//! let html = Page::new("A study").section(section).html();
//! assert!(html.starts_with("<!doctype html>"));
//! ```
//!
//! A content security policy forbids the browser to load anything, so that a slip could not go unseen.

mod base64;
mod image;
mod table;

pub use base64::base64;
pub use image::{Image, Picker};
pub use table::{Cell, Table};

use super::plot::{Plot, STYLE, escape};

const PAGE_STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// A page: a heading, a line under it, and sections.
#[derive(Clone, Debug)]
pub struct Page {
    pub title: String,
    pub lead: String,
    pub sections: Vec<Section>,
}

#[derive(Clone, Debug)]
pub struct Section {
    pub title: String,
    pub blocks: Vec<Block>,
}

/// What a section is made of. All text is plain: it is escaped.
#[derive(Clone, Debug)]
pub enum Block {
    Prose(String),
    /// Prose that warns.
    Warning(String),
    /// Command lines and listings.
    Code(String),
    /// Plots, two abreast where there is room.
    Plots(Vec<Plot>),
    Table(Table),
    /// Images side by side, as many abreast as fit.
    Images(Vec<Image>),
    /// Two of the page's images under a slider.
    Picker(Picker),
}

impl Page {
    pub fn new(title: impl Into<String>) -> Self {
        Page { title: title.into(), lead: String::new(), sections: Vec::new() }
    }

    pub fn lead(self, lead: impl Into<String>) -> Self {
        Page { lead: lead.into(), ..self }
    }

    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// The whole file.
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let sections: String = self.sections.iter().map(Section::html).collect();
        let lead =
            if self.lead.is_empty() { String::new() } else { format!("<p class=\"lead\">{}</p>", escape(&self.lead)) };
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
             style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
             <title>{title}</title>\n<style>\n{PAGE_STYLE}{STYLE}\n</style></head>\n\
             <body><main><h1>{title}</h1>{lead}\n{sections}</main>\n<script>\n{SCRIPT}</script></body></html>\n"
        )
    }
}

impl Section {
    pub fn new(title: impl Into<String>) -> Self {
        Section { title: title.into(), blocks: Vec::new() }
    }

    pub fn with(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    fn html(&self) -> String {
        let blocks: String = self.blocks.iter().map(Block::html).collect();
        format!("<section><h2>{}</h2>\n{blocks}</section>\n", escape(&self.title))
    }
}

impl Block {
    pub fn prose(text: impl Into<String>) -> Self {
        Block::Prose(text.into())
    }

    fn html(&self) -> String {
        match self {
            Block::Prose(text) => format!("<p>{}</p>\n", escape(text)),
            Block::Warning(text) => format!("<p class=\"warning\">{}</p>\n", escape(text)),
            Block::Code(text) => format!("<pre>{}</pre>\n", escape(text)),
            Block::Plots(plots) => {
                let figures: String = plots.iter().map(|plot| format!("<figure>{}</figure>", plot.svg())).collect();
                format!("<div class=\"plots\">{figures}</div>\n")
            }
            Block::Table(table) => table.html(),
            Block::Images(images) => {
                let figures: String = images.iter().map(Image::html).collect();
                format!("<div class=\"images\">{figures}</div>\n")
            }
            Block::Picker(picker) => picker.html(),
        }
    }
}
