//! Pictures of one size side by side on one PNG, each with a label under it.

use super::font::{ADVANCE, draw};
use crate::film::FilmError;
use crate::film::png::write_with;
use std::path::Path;

/// A picture and the lines of its label.
pub struct Tile {
    /// Row-major sRGB, the sheet's tile size.
    pub pixels: Vec<[u8; 3]>,
    pub label: Vec<String>,
}

/// Between tiles, and around all.
const GAP: usize = 8;
const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [16; 3];
/// A label's letters are enlarged by whole numbers until a line of this many would fill a tile.
const LETTERS_ACROSS: usize = 30;

/// The sheet, laid out.
pub struct Sheet<'a> {
    tiles: &'a [Tile],
    size: (usize, usize),
    columns: usize,
    zoom: usize,
    label_height: usize,
}

impl<'a> Sheet<'a> {
    /// Tiles of `size` pixels in rows, about as many columns as rows.
    pub fn new(tiles: &'a [Tile], size: (u32, u32)) -> Self {
        let size = (size.0 as usize, size.1 as usize);
        let zoom = (size.0 / (LETTERS_ACROSS * ADVANCE.0)).max(1);
        let lines = tiles.iter().map(|tile| tile.label.len()).max().unwrap_or(0);
        let columns = (tiles.len() as f64).sqrt().ceil().max(1.0) as usize;
        Sheet { tiles, size, columns, zoom, label_height: (lines * ADVANCE.1 + 3) * zoom }
    }

    /// Distance from one tile to the next.
    fn pitch(&self) -> (usize, usize) {
        // A label may be wider than its picture.
        let longest = self.tiles.iter().flat_map(|tile| &tile.label).map(|line| line.chars().count()).max();
        let width = self.size.0.max(longest.unwrap_or(0) * ADVANCE.0 * self.zoom);
        (width + GAP, self.size.1 + self.label_height + GAP)
    }

    /// Draws and writes it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FilmError> {
        let pitch = self.pitch();
        let width = self.columns * pitch.0 + GAP;
        let height = self.tiles.len().div_ceil(self.columns) * pitch.1 + GAP;
        let mut sheet = vec![PAPER; width * height];
        for (i, tile) in self.tiles.iter().enumerate() {
            let (left, top) = (GAP + i % self.columns * pitch.0, GAP + i / self.columns * pitch.1);
            for (y, row) in tile.pixels.chunks(self.size.0.max(1)).enumerate() {
                let start = (top + y) * width + left;
                sheet[start..start + row.len()].copy_from_slice(row);
            }
            for (line, text) in tile.label.iter().enumerate() {
                let base = top + self.size.1 + (3 + line * ADVANCE.1) * self.zoom;
                draw(text, |x, y| {
                    for dot in 0..self.zoom * self.zoom {
                        let (dx, dy) = (dot % self.zoom, dot / self.zoom);
                        sheet[(base + y * self.zoom + dy) * width + left + x * self.zoom + dx] = INK;
                    }
                });
            }
        }
        write_with(path, (width as u32, height as u32), |x, y| sheet[y as usize * width + x as usize])
    }
}
