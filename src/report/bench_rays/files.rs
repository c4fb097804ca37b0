//! The `.tri` and `.rays` files.

use super::BenchRaysError;
use crate::film::beside::is_stream;
use crate::geometry::MOST_PRIMITIVES;
use std::path::Path;

pub struct Triangles {
    /// Three a triangle.
    pub positions: Vec<[f32; 3]>,
}

/// Rays as seven arrays: origin, direction, t_max.
pub struct RaySet {
    pub columns: [Vec<f32>; 7],
    pub any: bool,
    pub coherent: bool,
}

/// A file's bytes after its magic, with the header words read off.
struct Body {
    bytes: Vec<u8>,
    at: usize,
}

fn open(path: &Path, magic: &[u8; 4]) -> Result<Body, BenchRaysError> {
    if is_stream(path) {
        return Err(format(path, "is not a regular file".into()));
    }
    let bytes = std::fs::read(path).map_err(|source| BenchRaysError::Io { path: path.into(), source })?;
    if !bytes.starts_with(magic) {
        return Err(format(path, format!("does not start with {:?}", String::from_utf8_lossy(magic))));
    }
    Ok(Body { bytes, at: 4 })
}

fn format(path: &Path, what: String) -> BenchRaysError {
    BenchRaysError::Format { path: path.into(), what }
}

impl Body {
    fn word(&mut self, path: &Path) -> Result<u32, BenchRaysError> {
        let word = self.bytes.get(self.at..self.at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        self.at += 4;
        word.ok_or_else(|| format(path, "ends inside its header".into()))
    }
    /// What follows the header, which claims `count` records of `values` numbers.
    fn floats(&self, path: &Path, count: u32, values: u64) -> Result<Vec<f32>, BenchRaysError> {
        let body = &self.bytes[self.at..];
        let claimed = u64::from(count) * values * 4;
        if body.len() as u64 != claimed {
            let what = format!("its header claims {count} records ({claimed} bytes), but {} bytes follow", body.len());
            return Err(format(path, what));
        }
        Ok(body.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}

impl Triangles {
    pub fn read(path: &Path) -> Result<Self, BenchRaysError> {
        let mut body = open(path, b"TRI0")?;
        let count = body.word(path)?;
        if count as usize > MOST_PRIMITIVES {
            return Err(format(path, format!("{count} triangles; at most {MOST_PRIMITIVES} are supported")));
        }
        let values = body.floats(path, count, 9)?;
        if let Some(i) = values.iter().position(|x| !x.is_finite() || x.abs() > 1e30) {
            return Err(format(path, format!("triangle {}: {} is not a usable coordinate", i / 9, values[i])));
        }
        Ok(Self { positions: values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect() })
    }
    pub fn count(&self) -> usize {
        self.positions.len() / 3
    }
    pub fn indices(&self) -> Vec<[u32; 3]> {
        (0..self.count() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()
    }
    pub fn largest(&self) -> f32 {
        self.positions.iter().flatten().fold(0.0, |most, x| x.abs().max(most))
    }
    pub fn rescale(&mut self, scale: f32) {
        self.positions.iter_mut().flatten().for_each(|x| *x *= scale);
    }
}

impl RaySet {
    pub fn read(path: &Path) -> Result<Self, BenchRaysError> {
        let mut body = open(path, b"RAY0")?;
        let (count, kind, coherent) = (body.word(path)?, body.word(path)?, body.word(path)?);
        if count == 0 || count % 16 != 0 {
            return Err(format(path, format!("{count} rays; a positive multiple of 16 is expected")));
        }
        if kind > 1 || coherent > 1 {
            return Err(format(path, format!("kind {kind}, coherent {coherent}: each must be 0 or 1")));
        }
        let values = body.floats(path, count, 7)?;
        let n = count as usize;
        let columns: [Vec<f32>; 7] = core::array::from_fn(|c| values[c * n..(c + 1) * n].to_vec());
        if let Some(i) = columns[..6].iter().flatten().position(|x| !x.is_finite() || x.abs() > 1e30) {
            return Err(format(path, format!("ray {}: not a usable origin or direction", i % n)));
        }
        if let Some(i) = (0..n)
            .find(|&i| columns[3..6].iter().all(|d| d[i] == 0.0) || columns[6][i].is_nan() || columns[6][i] <= 0.0)
        {
            return Err(format(path, format!("ray {i}: no direction, or a t_max that is not above 0")));
        }
        Ok(Self { columns, any: kind == 1, coherent: coherent == 1 })
    }
    pub fn count(&self) -> usize {
        self.columns[0].len()
    }
    pub fn largest(&self) -> f32 {
        self.columns[..3].iter().flatten().fold(0.0, |most, x| x.abs().max(most))
    }
    /// Directions stay, so t scales with the coordinates.
    pub fn rescale(&mut self, scale: f32) {
        for column in [0, 1, 2, 6] {
            self.columns[column].iter_mut().for_each(|x| *x *= scale);
        }
    }
}
