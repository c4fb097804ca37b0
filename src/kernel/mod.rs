//! The estimators over lanes, and the table of their instantiations.
//!
//! An estimator is generic over the lane width, the traversal and the shading models; a scene's plan picks one
//! instantiation out of [`select`]. Every instantiation is an entry there and nowhere else.

mod camera;
pub(crate) mod cutout;
mod direct;
mod gather;
mod illumination;
pub mod light_paths;
mod maps;
mod material;
mod material_table;
mod numbers;
mod path;
mod pattern;
mod phong;
mod prepare;
mod probe;
mod queue;
mod rays;
mod reuse;
mod roulette;
mod rows;
mod shade;
mod surface;
mod texture;
mod tile;
mod view;
mod wave;
mod world;

pub use camera::Camera;
pub(crate) use direct::{behind, light_ray};
pub use gather::GatherReport;
pub use illumination::{PixelPoint, Technique};
pub use light_paths::{LightJob, LightPaths, Splat};
pub(crate) use material::AllModels;
pub use path::{Traversal, mis_weight};
pub(crate) use pattern::look_up as look_up_pattern;
pub use prepare::{Prepare, Setup};
pub use probe::{Lanes, NoProbe, Probe, Record, Recorder, Stage};
pub use reuse::REUSE_SIDE;
pub(crate) use shade::Shade;
pub use surface::Surface;
pub use texture::TextureTable;
pub(crate) use tile::CameraQueue;
pub use tile::{Counters, Job, SampleBuffer};
pub use world::World;

use crate::accel::{Brute, Built, Packet, Shadow, Stream};
use crate::lane::{f32x8, f32x16};
use crate::plan::{GeometryMode, Shading};
use crate::scene::IntegratorKind;
use material::LambertOnly;

/// Every primitive, no tree.
pub struct BruteForce;
impl Traversal for BruteForce {
    type Camera = Brute;
    type Bounce = Brute;
    type Shadow = Brute;
}

/// Packets for camera rays; after a bounce each ray on its own way, the lanes of a packet in flight together; or all in one way
/// where the plan [says so](GeometryMode::is_uniform).
pub struct TreeTraversal;
impl Traversal for TreeTraversal {
    type Camera = Packet;
    type Bounce = Stream;
    type Shadow = Shadow;
}

/// As the world is built, looked at once a call: for paths that are recorded and those that a gather goes on with, since one
/// kernel for all trees counts for more there than that look.
pub struct AsBuilt;
impl Traversal for AsBuilt {
    type Camera = Built<Packet>;
    type Bounce = Built<Stream>;
    type Shadow = Built<Shadow>;
}

/// Number of lanes a kernel is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    /// Plain `f32`.
    One,
    /// One AVX register.
    Eight,
    /// One AVX-512 register, or two of AVX.
    Sixteen,
}

impl Width {
    /// All there are.
    pub const ALL: [Width; 3] = [Width::One, Width::Eight, Width::Sixteen];

    /// The width measured to be fastest on this build: 16 where it has AVX-512, else 8.
    pub fn native() -> Width {
        if cfg!(target_feature = "avx512f") { Width::Sixteen } else { Width::Eight }
    }
    /// Of a number of lanes; `None` if there is no such kernel.
    pub fn from_lanes(lanes: usize) -> Option<Width> {
        Width::ALL.into_iter().find(|w| w.lanes() == lanes)
    }
    /// Number of lanes.
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

/// Renders a job by the path estimator with a program's own materials and lights: see [`select`], whose kernels know only
/// the scene's.
pub(crate) fn render_own<S: Shade>(
    world: &World,
    shade: &S,
    width: Width,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
) {
    match world.plan.geometry {
        GeometryMode::Brute => own_width::<BruteForce, S>(world, shade, width, job, out, counters),
        _ => own_width::<TreeTraversal, S>(world, shade, width, job, out, counters),
    }
}

fn own_width<T: Traversal, S: Shade>(
    world: &World,
    shade: &S,
    width: Width,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
) {
    match width {
        Width::One => wave::render::<f32, T, S, NoProbe>(world, shade, job, out, counters, &mut NoProbe),
        Width::Eight => wave::render::<f32x8, T, S, NoProbe>(world, shade, job, out, counters, &mut NoProbe),
        Width::Sixteen => wave::render::<f32x16, T, S, NoProbe>(world, shade, job, out, counters, &mut NoProbe),
    }
}

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
    match (Estimator::of(world), world.plan.geometry, world.plan.shading) {
        (Estimator::Path, GeometryMode::Brute, Shading::Lambert) => widths!(width, path, [BruteForce, LambertOnly]),
        (Estimator::Path, GeometryMode::Brute, Shading::General) => widths!(width, path, [BruteForce, AllModels]),
        (Estimator::Path, _, Shading::Lambert) => widths!(width, path, [TreeTraversal, LambertOnly]),
        (Estimator::Path, _, Shading::General) => widths!(width, path, [TreeTraversal, AllModels]),
        (Estimator::Gather, ..) => widths!(width, gather, []),
        (Estimator::View, ..) => widths!(width, view, []),
    }
}

/// Traces a job's light paths and appends what they splat.
pub type LightKernel = fn(&World, &LightJob, &mut Vec<Splat>, &mut Counters);

/// The kernel of light paths, of all models; `None` where the plan leaves them out.
pub fn select_light(world: &World, width: Width) -> Option<LightKernel> {
    world.light_paths?;
    Some(widths!(width, light, []))
}

/// What is instantiated for an integrator.
enum Estimator {
    Path,
    Gather,
    /// The views, and `phong`.
    View,
}

impl Estimator {
    fn of(world: &World) -> Self {
        match world.integrator.kind {
            IntegratorKind::Path | IntegratorKind::Direct => Estimator::Path,
            IntegratorKind::Gather => Estimator::Gather,
            IntegratorKind::Phong | IntegratorKind::Normals | IntegratorKind::Depth | IntegratorKind::Hit => {
                Estimator::View
            }
        }
    }
}

/// The recording twin of [`select`]: same source, general shading. Of a gather it records what each sample found, from
/// the one kernel there is, as built.
pub fn select_recording(world: &World, width: Width) -> RecordingKernel {
    match Estimator::of(world) {
        Estimator::Path => widths!(width, record_path, []),
        Estimator::Gather => widths!(width, record_gather, []),
        Estimator::View => widths!(width, record_view, []),
    }
}

/// Entry points: the symbols that `tools/scalar-check.sh` looks at.
mod run {
    use super::material::ShadingKind;
    use super::*;
    use crate::lane::{Bits, Real, Vec3};

    #[inline(never)]
    pub fn path<R: Real, T: Traversal, S: ShadingKind + Default>(
        world: &World,
        job: &Job,
        out: &mut SampleBuffer,
        counters: &mut Counters,
    ) {
        super::wave::render::<R, T, S, NoProbe>(world, &S::default(), job, out, counters, &mut NoProbe)
    }

    #[inline(never)]
    pub fn light<R: Real>(world: &World, job: &LightJob, splats: &mut Vec<Splat>, counters: &mut Counters) {
        super::light_paths::trace::<R>(world, job, splats, counters)
    }

    #[inline(never)]
    pub fn view<R: Real>(world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters) {
        super::view::render::<R, NoProbe>(world, job, out, counters, &mut NoProbe)
    }

    #[inline(never)]
    pub fn gather<R: Real>(world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters) {
        super::gather::render::<R>(world, job, out, counters)
    }

    pub fn record_gather<R: Real>(
        world: &World,
        job: &Job,
        out: &mut SampleBuffer,
        counters: &mut Counters,
        recorder: &mut Recorder,
    ) {
        gather::<R>(world, job, out, counters);
        for (slot, rgb) in out.rgb.iter_mut().enumerate() {
            let lanes = Lanes::<f32> { slot: Bits::splat(slot as u32), bounce: 0.0, active: true };
            *rgb = recorder.tap_rgb(Stage::Radiance, lanes, Vec3::splat(*rgb)).lane(0);
        }
    }

    #[inline(never)]
    pub fn record_path<R: Real>(
        world: &World,
        job: &Job,
        out: &mut SampleBuffer,
        counters: &mut Counters,
        recorder: &mut Recorder,
    ) {
        super::wave::render::<R, AsBuilt, AllModels, Recorder>(world, &AllModels, job, out, counters, recorder)
    }

    #[inline(never)]
    pub fn record_view<R: Real>(
        world: &World,
        job: &Job,
        out: &mut SampleBuffer,
        counters: &mut Counters,
        recorder: &mut Recorder,
    ) {
        super::view::render::<R, Recorder>(world, job, out, counters, recorder)
    }
}
