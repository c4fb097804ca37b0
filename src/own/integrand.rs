//! What camera samples find, computed by a program's own function.

use crate::accel::{Brute, Built, Mode, Packet, Shadow, Stream};
use crate::bsdf::{Eval, Sample};
use crate::geometry::{Hit, Ray};
use crate::kernel::{AllModels, CameraQueue, Counters, Job, SampleBuffer, Surface, World, cutout};
use crate::lane::{Real, Vec3};
use crate::light::LightSample;
use crate::sampling::dimensions::{BOUNCE, BSDF_DIRECTION, BSDF_LOBE, LIGHT_CHOICE, LIGHT_POSITION};
use crate::sampling::{Frame, Sampler};

/// A function of a camera sample, averaged over the samples of a pixel.
///
/// ```
/// use octolux::{Renderer, lane::{Real, Vec3}, own::{CameraSample, Integrand}, sampling::Frame, sampling::warp, scene};
///
/// /// How much of the hemisphere over a point is open, by directions of density cosθ/π.
/// struct Openness;
///
/// impl Integrand for Openness {
///     fn radiance<R: Real>(&self, sample: &mut CameraSample<R>) -> Vec3<R> {
///         let (ray, active) = (sample.ray, sample.active);
///         let hit = sample.closest(&ray, active);
///         let found = active & hit.valid();
///         let at = sample.surface(&ray, &hit, found);
///         let u = sample.numbers();
///         let n = Vec3::select(at.ng.dot(ray.direction).gt(R::zero()), -at.ng, at.ng);
///         let out = at.ray_towards(Frame::from_normal(n).to_world(warp::cosine_hemisphere([u[1], u[2]])));
///         let hidden = sample.occluded(&out, found);
///         Vec3::all(R::select(hidden, R::zero(), R::one())).masked(found)
///     }
/// }
/// let mut scene = scene::SceneBuilder::new(scene::Camera::towards([0.0, 0.0, 4.0], [0.0; 3], 40.0), 8, 8);
/// let grey = scene.material(scene::Bsdf::Diffuse { reflectance: [0.5; 3] });
/// scene.sphere([0.0; 3], 1.0, grey);
/// let film = Renderer::new(4).integrate(&scene.build()?, &Openness)?;
/// assert_eq!(film.mean(4, 4), [1.0; 3]); // a ball hides nothing of itself
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Integrand: Sync {
    /// Of every lane in `sample.active`; others are not looked at. A value that is not finite is dropped and counted.
    fn radiance<R: Real>(&self, sample: &mut CameraSample<R>) -> Vec3<R>;
}

/// Camera samples in lanes, and what can be asked of the scene. Positions and distances are in the kernel's unit, of which
/// [`CameraSample::unit`] says the length; hits, surfaces and rays that go with lanes outside their mask are
/// unspecified.
pub struct CameraSample<'a, R: Real> {
    world: &'a World,
    /// From the camera; directions are unit.
    pub ray: Ray<R>,
    /// Lanes that hold a sample.
    pub active: R::Mask,
    rng: Sampler<R>,
    bounce: f32,
    counters: Counters,
}

impl<R: Real> CameraSample<'_, R> {
    /// Length of the kernel's unit in the scene's: a power of two.
    pub fn unit(&self) -> f32 {
        self.world.unit
    }

    /// What the kernel reads of the scene.
    pub fn world(&self) -> &World {
        self.world
    }

    /// The next twelve numbers of every sample, in [0, 1): at the n-th call those of bounce n − 1, which
    /// [`dimensions`](crate::sampling::dimensions) has names for.
    pub fn numbers(&mut self) -> [R; BOUNCE] {
        let bounce = R::splat(self.bounce);
        self.bounce += 1.0;
        self.world.bounce_numbers(&mut self.rng, bounce)
    }

    /// The closest hits. Cut-outs let rays pass by the numbers that [`CameraSample::numbers`] would give next.
    pub fn closest(&mut self, ray: &Ray<R>, active: R::Mask) -> Hit<R> {
        self.counters.traced(self.bounce == 0.0, active);
        match self.bounce == 0.0 {
            true => self.closest_by::<Built<Packet>>(ray, active),
            false => self.closest_by::<Built<Stream>>(ray, active),
        }
    }

    fn closest_by<M: Mode>(&self, ray: &Ray<R>, active: R::Mask) -> Hit<R> {
        cutout::closest::<R, M>(self.world, ray, &self.rng, R::splat(self.bounce), active)
    }

    /// Is anything in the way, up to the ray's `t_max`? Cut-outs count as whole.
    pub fn occluded(&mut self, ray: &Ray<R>, active: R::Mask) -> R::Mask {
        self.counters.shadow(active);
        self.world.occluded::<R, Built<Shadow>>(ray, active)
    }

    /// Point, normals and material at hits, of the lanes in `found`, all of which have one.
    pub fn surface(&self, ray: &Ray<R>, hit: &Hit<R>, found: R::Mask) -> Surface<R> {
        let mut surface = Surface::at(self.world, ray, hit, found);
        if self.world.plan.shading_normals {
            surface.face(-ray.direction);
        }
        surface
    }

    /// The scene's BSDF there, for unit directions of the world: f·|cosθi| and pdf.
    pub fn eval(&self, surface: &Surface<R>, wo: Vec3<R>, wi: Vec3<R>, active: R::Mask) -> Eval<R> {
        let frame = Frame::from_normal(surface.ns);
        surface.material.eval::<AllModels>(&self.world.plan, frame.to_local(wo), frame.to_local(wi), active)
    }

    /// A direction of the world by the scene's BSDF there, with weight f·|cosθi|/pdf, from the numbers of a bounce.
    pub fn scatter(&self, surface: &Surface<R>, wo: Vec3<R>, u: &[R; BOUNCE], active: R::Mask) -> Sample<R> {
        let frame = Frame::from_normal(surface.ns);
        let u_direction = [u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]];
        let material = &surface.material;
        let mut sample =
            material.sample::<AllModels>(&self.world.plan, frame.to_local(wo), u[BSDF_LOBE], u_direction, active);
        sample.wi = frame.to_world(sample.wi);
        sample
    }

    /// A sample of the scene's lights as seen from a surface, from the numbers of a bounce, with the ray that tells whether
    /// it is seen; `None` where the scene has no light.
    pub fn light(&self, surface: &Surface<R>, u: &[R; BOUNCE], active: R::Mask) -> Option<(LightSample<R>, Ray<R>)> {
        let position = [u[LIGHT_POSITION], u[LIGHT_POSITION + 1]];
        let mut light = self.world.sample_light(surface.at.p, None, u[LIGHT_CHOICE], position, active)?;
        if self.world.plan.patterned_lights {
            crate::kernel::look_up_pattern(self.world, &mut light, active);
        }
        let light = light.only(!crate::kernel::behind(self.world, surface, &light));
        let ray = crate::kernel::light_ray(surface, &light);
        Some((light, ray))
    }

    /// Radiance of the environment along unit directions.
    pub fn environment(&self, direction: Vec3<R>, active: R::Mask) -> Vec3<R> {
        self.world.background(direction, active)
    }
}

/// Renders all samples of a job into `out`.
pub(crate) fn integrate<R: Real, I: Integrand>(
    integrand: &I,
    world: &World,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
) {
    let mut queue = CameraQueue::<R>::new(world, job);
    // The integrand traces its camera rays itself.
    while let Some(packet) = queue.next_packet::<Brute>(false) {
        let (ray, active, rng) = (packet.ray, packet.active, packet.rng);
        let mut sample = CameraSample { world, ray, active, rng, bounce: 0.0, counters: Counters::default() };
        sample.counters.shaded(active);
        let value = integrand.radiance(&mut sample);
        out.add(packet.slot, value, active);
        counters.add(&sample.counters);
    }
}
