//! Prepared data: what the kernel reads.

use super::camera::Camera;
use super::gather::GatherTables;
use super::light_paths::LightPaths;
use super::material_table::MaterialTable;
use super::prepare::Setup;
use super::roulette::Roulette;
use super::texture::TextureTable;
use crate::accel::Accel;
use crate::geometry::{Rows, SphereAt, SphereRows, TriangleRows};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::light::{LightSample, Lights, Reach};
use crate::own::Numbers;
use crate::plan::Plan;
use crate::sampling::SamplerKind;
use crate::scene::{FilmSize, Integrator, IntegratorKind};
use std::sync::Arc;

/// Everything a kernel needs to render a scene.
pub struct World {
    /// What is kept.
    pub plan: Plan,
    /// In the kernel's unit.
    pub camera: Camera,
    /// In pixels.
    pub film: FilmSize,
    /// How light is followed.
    pub integrator: Integrator,
    /// Scattering events allowed on a path (the integrator's, with `direct` limited to 1).
    pub max_bounces: f32,
    /// When paths may end.
    pub roulette: Roulette,
    /// Of every random number.
    pub seed: u64,
    /// How the samples of a pixel relate.
    pub sampler: SamplerKind,
    /// In place of the sampler's, where a program brings its own.
    pub numbers: Option<Arc<dyn Numbers>>,
    /// The tree, or the lists where there is none.
    pub accel: Accel,
    /// Vertex 0, edges, geometric normal of each triangle.
    pub triangles: TriangleRows,
    /// Material index, and what light sampling keeps of it, of each primitive.
    pub tags: Rows<2>,
    /// Three unit normals a triangle; the geometric one where it has none. Empty unless the plan keeps them.
    pub normals: Rows<9>,
    /// Texture coordinates of the three vertices of a triangle. Empty unless the plan keeps them.
    pub texcoords: Rows<8>,
    /// Images that materials use.
    pub textures: TextureTable,
    /// Centre and radius of each sphere.
    pub spheres: SphereRows,
    /// Triangles come first in primitive numbering; this many.
    pub triangle_count: u32,
    /// One row a material.
    pub materials: MaterialTable,
    /// `None` where nothing emits or nothing transports light.
    pub lights: Option<Lights>,
    /// Where the last vertex of a path is lit by light samples alone; `None` for nowhere.
    pub reach: Option<Reach>,
    /// `None` unless the plan keeps them.
    pub light_paths: Option<LightPaths>,
    /// `None` unless the integrator gathers.
    pub gather: Option<GatherTables>,
    /// One length unit of the kernel is this many of the scene's: a power of two.
    pub unit: f32,
    /// What preparing took.
    pub setup: Setup,
}

impl World {
    /// The same with random numbers of a program's own. A gather, whose points belong to the scene's method, keeps its own.
    pub fn with_numbers(mut self, numbers: Arc<dyn Numbers>) -> World {
        self.plan.path_reuse = false;
        self.numbers = (self.integrator.kind != IntegratorKind::Gather).then_some(numbers);
        self.without_light_paths()
    }

    /// The same by camera paths alone: a program's own numbers and materials know nothing of light paths.
    pub fn without_light_paths(mut self) -> World {
        self.light_paths = None;
        self
    }

    /// Why all pixels must have the same number of samples, and what to do; `None` if they need not.
    pub fn needs_equal_samples(&self) -> Option<&'static str> {
        if self.integrator.kind == IntegratorKind::Gather {
            Some("directions that `gather` shares are no samples of a pixel alone; leave --adaptive out")
        } else if self.pixels_share_numbers() {
            Some("pixels of a block share a scrambling; ask for the sampler sobol-pixels")
        } else {
            None
        }
    }

    /// Do pixels of what may be different tiles share a scrambling? Tiles of shared paths are whole blocks.
    fn pixels_share_numbers(&self) -> bool {
        self.sampler == SamplerKind::Sobol && !self.plan.path_reuse
    }

    /// The same with numbers of its own for every tile: for samples divided by what other tiles found.
    pub fn with_tiles_apart(mut self) -> World {
        if self.pixels_share_numbers() {
            self.sampler = SamplerKind::SobolPixels;
        }
        self
    }

    /// A sample of some light as seen from `p`: area lights by power, or from a [table](Lights::table_at) where there is a grid.
    #[inline(always)]
    pub fn sample_light<R: Real>(
        &self,
        p: Vec3<R>,
        table: Option<R::Bits>,
        u_choice: R,
        u: [R; 2],
        active: R::Mask,
    ) -> Option<LightSample<R>> {
        Some(sample_one_of(self.lights.as_ref()?, p, None, table, u_choice, u, active))
    }

    /// Lanes whose primitive is a sphere. Primitives are fewer than 2³¹: the difference is negative for triangles.
    #[inline(always)]
    pub fn on_sphere<R: Real>(&self, primitive: R::Bits) -> R::Mask {
        (primitive - R::Bits::splat(self.triangle_count)).shr::<31>().eq(R::Bits::splat(0))
    }

    /// Radiance of the environment along unit directions that leave the scene.
    #[inline(never)]
    pub fn background<R: Real>(&self, direction: Vec3<R>, missed: R::Mask) -> Vec3<R> {
        let lights = self.lights.as_ref().filter(|_| self.plan.environment && missed.any());
        lights.map_or(Vec3::zero(), |lights| lights.environment_radiance(direction).masked(missed))
    }

    /// The spheres that lanes hit.
    #[inline(always)]
    pub fn sphere_at<R: Real>(&self, primitive: R::Bits, on_sphere: R::Mask) -> SphereAt<R> {
        self.spheres.fetch::<R>(primitive - R::Bits::splat(self.triangle_count), on_sphere)
    }
}

/// One copy a width, called: kernels stay small. Not an option of a sample, which would be copied whole to be looked into.
#[inline(never)]
pub(super) fn sample_one_of<R: Real>(
    lights: &Lights,
    p: Vec3<R>,
    facing: Option<&Vec3<R>>,
    table: Option<R::Bits>,
    u_choice: R,
    u: [R; 2],
    active: R::Mask,
) -> LightSample<R> {
    lights.sample_from(p, facing.copied(), table, u_choice, u, active)
}
