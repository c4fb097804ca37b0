//! The estimators over lanes, and the table of their instantiations.
//!
//! An estimator is generic over the lane width, the traversal and the shading models; a scene's plan picks one
//! instantiation out of [`select`]. Every instantiation is an entry there and nowhere else.

mod camera;
mod cutout;
mod illumination;
mod maps;
mod material;
mod path;
mod pattern;
mod probe;
mod surface;
mod texture;
mod tile;
mod view;
mod world;

pub use camera::Camera;
pub use illumination::{PixelPoint, Technique};
pub use path::Traversal;
pub use probe::{Lanes, NoProbe, Probe, Record, Recorder, Stage};
pub use texture::TextureTable;
pub use tile::{Counters, Job, SampleBuffer};
pub use world::{Prepare, Setup, World};

use crate::accel::{Brute, Packet, Shadow, Stream};
use crate::lane::{f32x8, f32x16};
use crate::plan::{GeometryMode, Shading};
use material::{AllModels, LambertOnly};

/// Every primitive, no tree.
pub struct BruteForce;
impl Traversal for BruteForce {
    type Camera = Brute;
    type Bounce = Brute;
    type Shadow = Brute;
    const PRETRACED: bool = false;
}

/// Packets for camera rays; after a bounce each ray on its own way, the lanes of a packet in flight together.
pub struct TreeTraversal;
impl Traversal for TreeTraversal {
    type Camera = Packet;
    type Bounce = Stream;
    type Shadow = Shadow;
    const PRETRACED: bool = true;
}

/// Number of lanes a kernel is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    One,
    Eight,
    Sixteen,
}

impl Width {
    pub const ALL: [Width; 3] = [Width::One, Width::Eight, Width::Sixteen];

    /// The width measured to be fastest on this build: 16 where it has AVX-512, else 8.
    pub fn native() -> Width {
        if cfg!(target_feature = "avx512f") { Width::Sixteen } else { Width::Eight }
    }
    /// Of a number of lanes; `None` if there is no such kernel.
    pub fn from_lanes(lanes: usize) -> Option<Width> {
        Width::ALL.into_iter().find(|w| w.lanes() == lanes)
    }
    pub fn lanes(self) -> usize {
        match self {
            Width::One => 1,
            Width::Eight => 8,
            Width::Sixteen => 16,
        }
    }
}

/// Renders a job into a buffer that was [reset](SampleBuffer::reset) for it.
pub type Kernel = fn(&World, &Job, &mut SampleBuffer, &mut Counters);
/// A [`Kernel`] that records what it computes.
pub type RecordingKernel = fn(&World, &Job, &mut SampleBuffer, &mut Counters, &mut Recorder);

/// Instantiates an estimator for the three widths.
macro_rules! widths {
    ($width:expr, $render:ident, [$($arguments:ty),*]) => {
        match $width {
            Width::One => run::$render::<f32, $($arguments),*>,
            Width::Eight => run::$render::<f32x8, $($arguments),*>,
            Width::Sixteen => run::$render::<f32x16, $($arguments),*>,
        }
    };
}

/// The kernel that the plan of this world asks for.
pub fn select(world: &World, width: Width) -> Kernel {
    let paths = world.integrator.kind.transports_light();
    match (paths, world.plan.geometry, world.plan.shading) {
        (true, GeometryMode::Brute, Shading::Lambert) => widths!(width, path, [BruteForce, LambertOnly]),
        (true, GeometryMode::Brute, Shading::General) => widths!(width, path, [BruteForce, AllModels]),
        (true, GeometryMode::Tree, Shading::Lambert) => widths!(width, path, [TreeTraversal, LambertOnly]),
        (true, GeometryMode::Tree, Shading::General) => widths!(width, path, [TreeTraversal, AllModels]),
        (false, GeometryMode::Brute, _) => widths!(width, view, [BruteForce]),
        (false, GeometryMode::Tree, _) => widths!(width, view, [TreeTraversal]),
    }
}

/// The recording twin of [`select`]: same source, general shading.
pub fn select_recording(world: &World, width: Width) -> RecordingKernel {
    let paths = world.integrator.kind.transports_light();
    match (paths, world.plan.geometry) {
        (true, GeometryMode::Brute) => widths!(width, record_path, [BruteForce]),
        (true, GeometryMode::Tree) => widths!(width, record_path, [TreeTraversal]),
        (false, GeometryMode::Brute) => widths!(width, record_view, [BruteForce]),
        (false, GeometryMode::Tree) => widths!(width, record_view, [TreeTraversal]),
    }
}

/// Entry points: the symbols that `tools/scalar-check.sh` looks at.
mod run {
    use super::material::ShadingKind;
    use super::*;
    use crate::lane::Real;

    #[inline(never)]
    pub fn path<R: Real, T: Traversal, S: ShadingKind>(
        world: &World,
        job: &Job,
        out: &mut SampleBuffer,
        counters: &mut Counters,
    ) {
        super::path::render::<R, T, S, NoProbe>(world, job, out, counters, &mut NoProbe)
    }

    #[inline(never)]
    pub fn view<R: Real, T: Traversal>(world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters) {
        super::view::render::<R, T, NoProbe>(world, job, out, counters, &mut NoProbe)
    }

    #[inline(never)]
    pub fn record_path<R: Real, T: Traversal>(
        world: &World,
        job: &Job,
        out: &mut SampleBuffer,
        counters: &mut Counters,
        recorder: &mut Recorder,
    ) {
        super::path::render::<R, T, AllModels, Recorder>(world, job, out, counters, recorder)
    }

    #[inline(never)]
    pub fn record_view<R: Real, T: Traversal>(
        world: &World,
        job: &Job,
        out: &mut SampleBuffer,
        counters: &mut Counters,
        recorder: &mut Recorder,
    ) {
        super::view::render::<R, T, Recorder>(world, job, out, counters, recorder)
    }
}
