//! Tables, which scroll in themselves where the page is narrower than they are.

use crate::report::plot::escape;

#[derive(Clone, Debug, Default)]
pub struct Table {
    pub caption: String,
    pub header: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

/// A table's cell; one that is flagged stands out.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    pub text: String,
    pub flagged: bool,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell { text: text.to_owned(), flagged: false }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell { text, flagged: false }
    }
}

impl Cell {
    pub fn flagged(text: impl Into<String>) -> Self {
        Cell { text: text.into(), flagged: true }
    }
}

impl Table {
    pub fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Table { header: header.into_iter().map(Into::into).collect(), ..Table::default() }
    }

    pub fn captioned(self, caption: impl Into<String>) -> Self {
        Table { caption: caption.into(), ..self }
    }

    pub fn row<C: Into<Cell>>(mut self, cells: impl IntoIterator<Item = C>) -> Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    /// The first column names its row; numbers stand to the right.
    pub(super) fn html(&self) -> String {
        let caption = if self.caption.is_empty() {
            String::new()
        } else {
            format!("<caption>{}</caption>", escape(&self.caption))
        };
        let header: String = self.header.iter().map(|h| format!("<th scope=\"col\">{}</th>", escape(h))).collect();
        let rows: String = self.rows.iter().map(|row| format!("<tr>{}</tr>\n", row_html(row))).collect();
        format!(
            "<div class=\"scroll\" tabindex=\"0\"><table>{caption}<thead><tr>{header}</tr></thead>\n\
             <tbody>{rows}</tbody></table></div>\n"
        )
    }
}

fn row_html(row: &[Cell]) -> String {
    let cell = |(column, cell): (usize, &Cell)| {
        let (tag, scope) = if column == 0 { ("th", " scope=\"row\"") } else { ("td", "") };
        let number = cell.text.starts_with(|c: char| c.is_ascii_digit() || "−+-.~<>≈".contains(c));
        let class = match (number && column > 0, cell.flagged) {
            (false, false) => "",
            (true, false) => " class=\"number\"",
            (false, true) => " class=\"flagged\"",
            (true, true) => " class=\"number flagged\"",
        };
        format!("<{tag}{scope}{class}>{}</{tag}>", escape(&cell.text))
    };
    row.iter().enumerate().map(cell).collect()
}
