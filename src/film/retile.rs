//! The same sums in tiles of another size.

use super::Film;
use super::blocks::{BlockTree, Node};
use super::discarded::Discarded;
use super::tile::TileFilm;

impl Film {
    /// The film in tiles of side `tile`; `None` where its tiles stand at different samples, as an interrupted pass leaves
    /// them. What was dropped goes to the first tile: it belongs to the film as a whole.
    pub fn retiled(&self, tile: u32) -> Option<Film> {
        let first = self.tiles().first()?;
        let shape = |t: &TileFilm| {
            let nodes: Vec<(u32, u64)> = t.whole.nodes.iter().map(|node| (node.level, node.index)).collect();
            (nodes, t.next_sample, t.partial.is_empty())
        };
        let expected = shape(first);
        if self.tiles().iter().any(|t| shape(t) != expected) {
            return None;
        }
        let mut film = Film::new(self.width(), self.height(), tile, self.channels(), 0);
        for (i, to) in film.tiles_mut().iter_mut().enumerate() {
            to.next_sample = first.next_sample;
            let nodes = first.whole.nodes.iter().enumerate();
            let node = |(k, &Node { level, index, .. }): (usize, &Node)| Node {
                level,
                index,
                sums: self.sums_of(to, |from| &from.whole.nodes[k].sums),
            };
            to.whole = BlockTree { nodes: nodes.map(node).collect() };
            to.partial = if first.partial.is_empty() { Vec::new() } else { self.sums_of(to, |from| &from.partial) };
            to.largest = if first.largest.is_empty() { Vec::new() } else { self.largest_of(to) };
            to.discarded = if i == 0 { self.discarded() } else { Discarded::default() };
        }
        Some(film)
    }

    fn largest_of(&self, to: &TileFilm) -> Vec<[f32; 3]> {
        let rect = to.rect();
        let rows = rect.y..rect.y + rect.height;
        rows.flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| self.largest(x, y))).collect()
    }

    /// Sums of the pixels of a tile, from the tiles here that hold them.
    fn sums_of<'a>(&'a self, to: &TileFilm, of: impl Fn(&'a TileFilm) -> &'a [f64]) -> Vec<f64> {
        let (rect, stride) = (to.rect(), self.channels().stride());
        let mut sums = Vec::with_capacity(rect.pixels() * stride);
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                let from = self.tile_at(x, y);
                let at = from.rect().index_of(x, y) * stride;
                sums.extend_from_slice(&of(from)[at..at + stride]);
            }
        }
        sums
    }
}
