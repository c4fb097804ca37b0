//! Things to see that are no single number: rules of variance, Gaussian processes, O'Hagan's objections.

mod gp_line;
mod ohagan;
mod variance_rules;

pub use gp_line::gp_line;
pub use ohagan::ohagan;
pub use variance_rules::variance_rules;

use crate::report::page::{Block, Page, Section, Table};
use crate::report::plot::Plot;
use std::fmt;

/// Tables and plots with a sentence on each.
#[derive(Clone, Debug, Default)]
pub struct Demonstration {
    pub title: String,
    pub lead: String,
    pub sections: Vec<Part>,
}

#[derive(Clone, Debug, Default)]
pub struct Part {
    pub title: String,
    pub prose: String,
    pub table: Table,
    /// With the name of a file for each.
    pub plots: Vec<(String, Plot)>,
}

impl Demonstration {
    pub fn page(&self, command: &str) -> Page {
        let mut page = Page::new(self.title.clone()).lead(self.lead.clone());
        for part in &self.sections {
            let mut section = Section::new(part.title.clone()).with(Block::prose(part.prose.clone()));
            if !part.plots.is_empty() {
                section = section.with(Block::Plots(part.plots.iter().map(|p| p.1.clone()).collect()));
            }
            if !part.table.rows.is_empty() {
                section = section.with(Block::Table(part.table.clone()));
            }
            page = page.section(section);
        }
        page.section(Section::new("Command").with(Block::Code(command.to_owned())))
    }

    /// All tables, a line a row, with the part's title in front.
    pub fn csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let mut lines = Vec::new();
        for part in &self.sections {
            let line = |cells: Vec<&str>| {
                std::iter::once(part.title.as_str()).chain(cells).map(quoted).collect::<Vec<_>>().join(",")
            };
            lines.push(line(part.table.header.iter().map(String::as_str).collect()));
            lines.extend(part.table.rows.iter().map(|row| line(row.iter().map(|c| c.text.as_str()).collect())));
        }
        lines.join("\n") + "\n"
    }

    pub fn json(&self) -> serde_json::Value {
        let table = |t: &Table| {
            let row = |row: &Vec<_>| -> serde_json::Value {
                let cell = |(name, c): (&String, &crate::report::page::Cell)| (name.clone(), c.text.clone().into());
                t.header.iter().zip(row).map(cell).collect::<serde_json::Map<_, _>>().into()
            };
            t.rows.iter().map(row).collect::<Vec<_>>()
        };
        let part = |p: &Part| serde_json::json!({ "title": p.title, "rows": table(&p.table) });
        let parts: Vec<_> = self.sections.iter().map(part).collect();
        serde_json::json!({ "title": self.title, "lead": self.lead, "parts": parts })
    }
}

impl fmt::Display for Demonstration {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}: {}", self.title, self.lead)?;
        for part in &self.sections {
            writeln!(f, "\n{}. {}", part.title, part.prose)?;
            if !part.table.rows.is_empty() {
                write_table(f, &part.table)?;
            }
        }
        Ok(())
    }
}

fn write_table(f: &mut fmt::Formatter, table: &Table) -> fmt::Result {
    let texts = |row: &Vec<crate::report::page::Cell>| row.iter().map(|c| c.text.clone()).collect::<Vec<_>>();
    let rows: Vec<Vec<String>> = std::iter::once(table.header.clone()).chain(table.rows.iter().map(texts)).collect();
    let columns = table.header.len();
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for row in &rows {
        let cells = row.iter().zip(&widths).enumerate();
        let line = cells.map(|(c, (text, &w))| if c == 0 { format!("{text:<w$}") } else { format!("{text:>w$}") });
        writeln!(f, "  {}", line.collect::<Vec<_>>().join("  ").trim_end())?;
    }
    Ok(())
}
