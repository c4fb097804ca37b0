//! What the path estimator asks of materials and lights: the scene's alone, or a program's own beside them.

use super::material::ShadingKind;
use super::surface::Surface;
use super::world::{World, sample_one_of};
use crate::bsdf::{Eval, Sample};
use crate::geometry::Hit;
use crate::lane::{Real, Vec3};
use crate::light::LightSample;

/// Scattering, light samples and the light of rays that leave the scene. Every [`ShadingKind`] is one: the scene's.
pub trait Shade: Sync {
    /// The models compiled in for the scene's materials.
    type Models: ShadingKind;
    /// Is there a light that the scene does not know?
    const OWN_LIGHT: bool = false;

    /// f·|cosθi| and pdf, directions in the shading frame.
    #[inline(always)]
    fn eval<R: Real>(
        &self,
        world: &World,
        _hit: &Hit<R>,
        surface: &Surface<R>,
        [wo, wi]: [Vec3<R>; 2],
        active: R::Mask,
    ) -> Eval<R> {
        surface.material.eval::<Self::Models>(&world.plan, wo, wi, active)
    }

    /// A direction with weight f·|cosθi|/pdf, directions in the shading frame; `u` are the numbers of lobe and direction.
    #[inline(always)]
    fn sample<R: Real>(
        &self,
        world: &World,
        _hit: &Hit<R>,
        surface: &Surface<R>,
        wo: Vec3<R>,
        u: [R; 3],
        active: R::Mask,
    ) -> Sample<R> {
        surface.material.sample::<Self::Models>(&world.plan, wo, u[0], [u[1], u[2]], active)
    }

    /// Lanes that scatter by a delta alone.
    #[inline(always)]
    fn is_delta<R: Real>(&self, _world: &World, _hit: &Hit<R>, surface: &Surface<R>) -> R::Mask {
        surface.material.is_delta::<Self::Models>()
    }

    /// A sample of some light as seen from `p`, lit from the side of `facing` (see
    /// [`Lights::sample_from`](crate::light::Lights::sample_from)), by the `table` of its place where the lights have a grid;
    /// without density where nothing shines.
    #[inline(always)]
    fn sample_light<R: Real>(
        &self,
        world: &World,
        [p, facing]: [Vec3<R>; 2],
        table: R::Bits,
        u_choice: R,
        u: [R; 2],
        active: R::Mask,
    ) -> LightSample<R> {
        match &world.lights {
            Some(lights) => sample_one_of(lights, p, Some(&facing), Some(table), u_choice, u, active),
            None => LightSample::none(),
        }
    }

    /// The density of light samples on the scene's own emitters, from what it is where there are no other lights.
    #[inline(always)]
    fn scene_light_pdf<R: Real>(&self, _world: &World, pdf: R) -> R {
        pdf
    }

    /// Radiance of the scene's environment along a direction that leaves the scene, and the density with which light sampling finds
    /// it there.
    #[inline(always)]
    fn escaped<R: Real>(&self, world: &World, direction: Vec3<R>) -> (Vec3<R>, R) {
        let lights = world.lights.as_ref().filter(|_| world.plan.environment);
        lights.map_or((Vec3::zero(), R::zero()), |lights| lights.environment(direction))
    }

    /// The same of the light that the scene does not know.
    #[inline(always)]
    fn escaped_to_own<R: Real>(&self, _world: &World, _direction: Vec3<R>) -> (Vec3<R>, R) {
        (Vec3::zero(), R::zero())
    }
}

impl<K: ShadingKind> Shade for K {
    type Models = K;
}
