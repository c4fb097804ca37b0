//! Rays, triangles and spheres over lanes; what shading reads at a hit; leaving a surface.
//!
//! Everything here assumes the scene rescaled so that the largest |coordinate| of geometry, camera and lights lies in
//! [1, 2).
//!
//! # Why every mode, order and tree gives the same hits
//!
//! A primitive is hit only if the edge (or root) test passes **and** the slab test of its own box does: the bounds of
//! the primitive, grown by [`BOX_MARGIN`] on each side. The distance is then t = max(t_primitive, t_near(own box)).
//! All of it depends on the ray and the primitive alone.
//!
//! A tree's boxes are exact unions (minima, maxima) of own boxes, and are tested by the same [slab arithmetic](slab).
//! Rounding is monotone, so for a box B ⊇ A: t_near(B) ≤ t_near(A) and t_far(B) ≥ t_far(A), as computed. Hence for a
//! hit at t every box above it passes, and has t_near(box) ≤ t_near(own) ≤ t. A node is dropped only while
//! t_near(node) > t_best, or for boxes no ray of a packet can enter by the same monotone bounds; t_best is never below
//! the final t, so no winner is dropped. Equal t goes to the lower primitive index. So brute force and every tree,
//! order and packet find the same (t, primitive, u, v).

/// Triangles and spheres of a scene are at most so many: a word names one beside four bits that say what else it may be, and
/// signed differences of their numbers compare right.
pub const MOST_PRIMITIVES: usize = (1 << 28) - 1;

mod ray;
mod rows;
pub mod slab;
mod spawn;
mod sphere;
mod triangle;

pub use ray::{Hit, MISS, Ray};
pub use rows::{Rows, SphereAt, SphereRows, TriangleAt, TriangleRows};
pub use slab::{BOX_MARGIN, Bounds};
pub use spawn::{
    SurfacePoint, inner_weights, offset_origin, point_shadow_ray, shadow_ray, sphere_point, triangle_point,
};
pub use sphere::intersect_sphere;
pub use triangle::{Edges, RaySetup, SharedEdge, Shear, Vertices, first_of_pair, second_of_pair};
pub use triangle::{edges, largest, meet_plane, own_box, pass_edges, plane_normal};
