//! The vertices of a group of triangles as a packet of rays sees them, each moved once.

use crate::geometry::Shear;
use crate::lane::{Real, axes};
use core::mem::MaybeUninit;

/// The most vertices a group has: with 16 lanes 8 KB on the stack.
pub const MOST: usize = 64;

/// Vertices that are not the same, and the packet of their places across each ray.
#[derive(Clone, Debug, Default)]
pub struct Vertices {
    /// x, y, z and a filler, so that a lane picks its axes by permuting one register.
    list: Vec<[f32; 4]>,
}

/// A vertex of a [`Vertices`], by its place there.
#[derive(Clone, Copy, Debug)]
pub struct Corner(u8);

impl Vertices {
    /// The places of some vertices, added where they are missing (zeros by sign); `None`, and nothing is added, where there is
    /// no room.
    pub fn place<const N: usize>(&mut self, vertices: [[f32; 3]; N]) -> Option<[Corner; N]> {
        let before = self.list.len();
        let places = vertices.map(|[x, y, z]| {
            let same = |v: &[f32; 4]| v.map(f32::to_bits) == [x, y, z, 0.0].map(f32::to_bits);
            self.list.iter().position(same).unwrap_or_else(|| {
                self.list.push([x, y, z, 0.0]);
                self.list.len() - 1
            })
        });
        if self.list.len() > MOST {
            self.list.truncate(before);
            return None;
        }
        Some(places.map(|place| Corner(place as u8)))
    }

    pub fn bytes(&self) -> usize {
        core::mem::size_of_val(self.list.as_slice())
    }
}

/// Of each vertex x and y across the ray. Room for [`MOST`], of which the first `len` are written: clearing all would cost as
/// much as moving them.
pub struct Moved<R> {
    across: [MaybeUninit<[R; 2]>; MOST],
    len: usize,
}

impl<R: Real> Moved<R> {
    #[inline(always)]
    pub fn new() -> Self {
        Moved { across: [const { MaybeUninit::uninit() }; MOST], len: 0 }
    }

    /// Moves vertices into the space of each ray, in place of those before.
    #[inline(always)]
    pub fn fill(&mut self, vertices: &Vertices, shear: &Shear<R>, order: &[R::Bits; 3]) {
        self.len = vertices.list.len().min(MOST);
        for (place, vertex) in vertices.list[..self.len].iter().enumerate() {
            self.across[place].write(shear.across(axes(|k| R::lookup4(vertex, order[k]))));
        }
    }

    /// Panics past the last vertex.
    #[inline(always)]
    pub fn at(&self, corner: Corner) -> [R; 2] {
        let place = usize::from(corner.0);
        assert!(place < self.len);
        // SAFETY: `Moved::fill` wrote the first `len` places, and left `len` at 0 or there. (Groups that are full, and those
        // after them, which find the places of others: tests/traversal/equivalence.rs, lists of up to 1500 triangles.)
        unsafe { self.across[place].assume_init() }
    }
}
