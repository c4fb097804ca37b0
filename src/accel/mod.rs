//! Finding hits: trees over the primitives, and the ways to walk them.
//!
//! [`Accel`] answers two questions over lanes, [`Accel::trace`] (the closest hit) and [`Accel::occluded`] (any hit), in
//! one of several [modes](Mode) named by a type. All give the same bits (see [`geometry`](crate::geometry)); they
//! differ in what they are fast at.

mod best;
mod block;
mod brute;
mod build;
mod built;
mod collapse;
mod corners;
mod emit;
mod facets;
mod flight;
mod group;
mod interval;
mod lanes;
mod leaf;
mod leaves;
mod lists;
mod node;
mod packet;
mod pairs;
mod preorder;
mod shadow;
mod single;
mod sphere_block;
mod stream;
mod tree;
mod visits;

use crate::geometry::{Bounds, Hit, MOST_PRIMITIVES, Ray, RaySetup};
use crate::lane::{Real, array};
use block::TriangleBlock;
use brute::SphereList;
pub use build::{BuildOptions, BuildReport, Preset};
pub use built::Built;
use facets::TriangleList;
pub use flight::RAYS as FLIGHT;
use rayon::prelude::*;
use sphere_block::SphereBlock;
use std::time::Instant;
use tree::Tree;

/// How rays find their hits.
pub trait Mode: Copy + Send + Sync + 'static {
    /// Does it walk trees (else the lists)?
    const TREE: bool;
    #[doc(hidden)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>);
    #[doc(hidden)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask;
    /// [`Mode::closest`] of several packets.
    #[doc(hidden)]
    #[inline(always)]
    fn closest_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
        for ((ray, active), hit) in rays.iter().zip(active).zip(hits) {
            *hit = accel.trace::<R, Self>(ray, *active);
        }
    }
    /// [`Mode::any`] of several packets.
    #[doc(hidden)]
    #[inline(always)]
    fn any_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
        for ((ray, active), found) in rays.iter().zip(active).zip(found) {
            *found = accel.occluded::<R, Self>(ray, *active);
        }
    }
}

/// Every ray against every primitive: for some tens of primitives.
#[derive(Clone, Copy, Debug)]
pub struct Brute;
/// Each lane's ray in turn, against eight boxes or triangles at a time: for rays that have parted.
#[derive(Clone, Copy, Debug)]
pub struct Single;
/// The lanes' rays in flight together, each on its own way: what [`Single`] is for, faster from 8 lanes on.
#[derive(Clone, Copy, Debug)]
pub struct Stream;
/// Any-hit rays as a [`Packet`] as far as lanes go together, from there as a [`Stream`].
#[derive(Clone, Copy, Debug)]
pub struct Shadow;
/// All lanes together through the tree: for rays that go the same way.
#[derive(Clone, Copy, Debug)]
pub struct Packet;

/// The primitives of a scene, arranged for tracing. Holds copies: nothing borrowed.
#[derive(Clone, Debug, Default)]
pub struct Accel {
    triangles: TriangleList,
    spheres: SphereList,
    triangle_tree: Tree<TriangleBlock>,
    sphere_tree: Tree<SphereBlock>,
    has_trees: bool,
    report: BuildReport,
}

impl Accel {
    /// Arranges what `options` ask for. `triangles` index `positions`; `spheres` are (centre, radius).
    ///
    /// Everything is finite, largest |coordinate| below 2 (or the margins of [`geometry`](crate::geometry) do not
    /// hold). Panics if an index is past the end of `positions`, or beyond [`MOST_PRIMITIVES`].
    pub fn build(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        spheres: &[([f32; 3], f32)],
        options: BuildOptions,
    ) -> Self {
        let start = Instant::now();
        assert!(triangles.len() + spheres.len() <= MOST_PRIMITIVES, "more primitives than child words can name");
        let vertices = |i: usize| array::map(triangles[i], |k| positions[k as usize]);
        let first_sphere = triangles.len() as u32;
        let mut accel = Self { has_trees: options.trees, ..Self::default() };
        if options.lists {
            accel.triangles = TriangleList::new((0..triangles.len()).map(vertices));
            accel.spheres = SphereList::new(spheres, first_sphere);
        }
        if options.trees {
            let boxes: Vec<_> =
                (0..triangles.len()).into_par_iter().map(|i| Bounds::of_triangle(vertices(i))).collect();
            accel.triangle_tree = Tree::build(&boxes, options.preset, |ids| TriangleBlock::new(ids, vertices));
            let boxes: Vec<_> = spheres.iter().map(|(c, r)| Bounds::of_sphere(*c, *r)).collect();
            accel.sphere_tree =
                Tree::build(&boxes, options.preset, |ids| SphereBlock::new(ids, first_sphere, |i| spheres[i]));
        }
        accel.report = BuildReport {
            seconds: start.elapsed().as_secs_f64(),
            node_bytes: accel.triangle_tree.node_bytes() + accel.sphere_tree.node_bytes(),
            block_bytes: accel.triangle_tree.block_bytes() + accel.sphere_tree.block_bytes(),
            list_bytes: accel.triangles.bytes() + accel.spheres.bytes(),
            nodes: accel.triangle_tree.nodes.len() + accel.sphere_tree.nodes.len(),
            blocks: accel.triangle_tree.blocks.len() + accel.sphere_tree.blocks.len(),
            children: accel.triangle_tree.children() + accel.sphere_tree.children(),
            depth: accel.triangle_tree.depth.max(accel.sphere_tree.depth),
        };
        accel
    }

    /// The same, walked as trees that are too large for caches near a core, or for all, are walked: for tests of that.
    #[doc(hidden)]
    pub fn walked_as_far(mut self, in_memory: bool) -> Self {
        (self.triangle_tree.far, self.triangle_tree.in_memory) = (true, in_memory);
        (self.sphere_tree.far, self.sphere_tree.in_memory) = (true, in_memory);
        self
    }

    /// What was built, how large and how long it took.
    pub fn report(&self) -> &BuildReport {
        &self.report
    }

    /// The closest hit with 0 < t < `t_max`, per lane; equal t goes to the lower primitive. Lanes that are not
    /// `active`, and unusable rays (see [`Ray`]), report a miss at their `t_max`, cost nothing and touch no other lane.
    #[inline]
    pub fn trace<R: Real, M: Mode>(&self, ray: &Ray<R>, active: R::Mask) -> Hit<R> {
        let mut hit = Hit::miss(ray.t_max);
        M::closest(self, &RaySetup::new(ray), active & ray.usable(), &mut hit);
        hit
    }

    /// Is there any hit with 0 < t < `t_max`? False for lanes that are not `active` and for unusable rays.
    #[inline]
    pub fn occluded<R: Real, M: Mode>(&self, ray: &Ray<R>, active: R::Mask) -> R::Mask {
        M::any(self, &RaySetup::new(ray), ray.t_max, active & ray.usable())
    }

    /// [`Accel::trace`] of several packets, which a [`Stream`] walks together.
    #[inline]
    pub fn trace_many<R: Real, M: Mode>(&self, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
        M::closest_many(self, rays, active, hits);
    }

    /// [`Accel::occluded`] of several packets.
    #[inline]
    pub fn occluded_many<R: Real, M: Mode>(&self, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
        M::any_many(self, rays, active, found);
    }
}
