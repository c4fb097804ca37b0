//! The path estimator with a BSDF and a light of a program's own.

use super::{Arrival, Bsdf, Light};
use crate::bsdf::{Eval, Sample};
use crate::geometry::Hit;
use crate::kernel::{AllModels, Shade, Surface, World};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::light::{DELTA_LIGHT, LightSample, NO_PRIMITIVE};
use crate::sampling::rescale;

/// How often an own light is sampled where the scene has lights, too: as the environment, for the same reason
/// ([`ENVIRONMENT_PROBABILITY`](crate::light::ENVIRONMENT_PROBABILITY)).
const SHARE: f32 = 0.5;

/// Neither a BSDF nor a light.
pub struct Nothing;

/// What a program adds to the path estimator.
pub struct Own<B = Nothing, L = Nothing> {
    /// The material that `bsdf` is worn in place of; none where it is out of range.
    material: u32,
    bsdf: B,
    light: L,
}

impl Own {
    /// Adds nothing.
    pub fn new() -> Self {
        Own { material: u32::MAX, bsdf: Nothing, light: Nothing }
    }
}

impl Default for Own {
    fn default() -> Self {
        Own::new()
    }
}

impl<B, L> Own<B, L> {
    /// Surfaces of `material` (an index into [`Scene::materials`](crate::scene::Scene::materials)) scatter so; they emit
    /// as before.
    pub fn bsdf<N: Bsdf>(self, material: u32, bsdf: N) -> Own<N, L> {
        Own { material, bsdf, light: self.light }
    }

    /// Shines beside the scene's lights.
    pub fn light<N: Light>(self, light: N) -> Own<B, N> {
        Own { material: self.material, bsdf: self.bsdf, light }
    }
}

/// Black, and of no material.
impl Bsdf for Nothing {
    fn eval<R: Real>(&self, _wo: Vec3<R>, _wi: Vec3<R>) -> Eval<R> {
        Eval { value: Vec3::zero(), pdf: R::zero() }
    }

    fn sample<R: Real>(&self, wo: Vec3<R>, _u_lobe: R, _u: [R; 2]) -> Sample<R> {
        let none = R::Mask::splat(false);
        Sample { wi: wo, weight: Vec3::zero(), pdf: R::zero(), eta: R::one(), delta: none, valid: none }
    }
}

/// Dark.
impl Light for Nothing {
    const SHINES: bool = false;

    fn sample<R: Real>(&self, _p: Vec3<R>, _u: [R; 2]) -> Arrival<R> {
        let none = R::Mask::splat(false);
        Arrival { wi: Vec3::zero(), distance: R::zero(), radiance: Vec3::zero(), pdf: R::zero(), delta: none }
    }
}

impl<B: Bsdf, L: Light> Own<B, L> {
    /// Lanes that hit the material.
    #[inline(always)]
    fn worn<R: Real>(&self, world: &World, hit: &Hit<R>, active: R::Mask) -> R::Mask {
        let [material, _] = world.tags.fetch::<R>(hit.primitive, active);
        material.to_int().eq(R::Bits::splat(self.material)) & active
    }

    #[inline(never)]
    fn eval_own<R: Real>(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        self.bsdf.eval(wo, wi)
    }

    #[inline(never)]
    fn sample_own<R: Real>(&self, wo: Vec3<R>, u: [R; 3]) -> Sample<R> {
        self.bsdf.sample(wo, u[0], [u[1], u[2]])
    }

    /// Probability with which the own light is sampled.
    #[inline(always)]
    fn share(world: &World) -> f32 {
        if world.lights.is_some() { SHARE } else { 1.0 }
    }

    #[inline(never)]
    fn sample_own_light<R: Real>(&self, world: &World, p: Vec3<R>, u: [R; 2], active: R::Mask) -> LightSample<R> {
        let Arrival { wi, distance, radiance, pdf, delta } = self.light.sample(p * R::splat(world.unit), u);
        let outside = distance.eq(R::splat(f32::INFINITY));
        let near = R::select(outside, R::zero(), distance) * R::splat(world.unit.recip());
        // Nothing but its own samples finds a light that is near.
        let alone = delta | !outside;
        let sample = LightSample {
            wi,
            target: wi.mul_add(near, p),
            distance: R::select(outside, distance, near),
            radiance,
            pdf: pdf * R::splat(Self::share(world)),
            is_environment: outside,
            primitive: R::Bits::select(alone, R::Bits::splat(DELTA_LIGHT), R::Bits::splat(NO_PRIMITIVE)),
            ..LightSample::none()
        };
        sample.only(active)
    }
}

impl<B: Bsdf, L: Light> Shade for Own<B, L> {
    type Models = AllModels;
    const OWN_LIGHT: bool = L::SHINES;

    #[inline(always)]
    fn eval<R: Real>(
        &self,
        world: &World,
        hit: &Hit<R>,
        surface: &Surface<R>,
        [wo, wi]: [Vec3<R>; 2],
        active: R::Mask,
    ) -> Eval<R> {
        let scenes = surface.material.eval::<AllModels>(&world.plan, wo, wi, active);
        let worn = self.worn(world, hit, active);
        if worn.none() {
            return scenes;
        }
        let own = self.eval_own(wo, wi);
        Eval { value: Vec3::select(worn, own.value, scenes.value), pdf: R::select(worn, own.pdf, scenes.pdf) }
    }

    #[inline(always)]
    fn sample<R: Real>(
        &self,
        world: &World,
        hit: &Hit<R>,
        surface: &Surface<R>,
        wo: Vec3<R>,
        u: [R; 3],
        active: R::Mask,
    ) -> Sample<R> {
        let scenes = surface.material.sample::<AllModels>(&world.plan, wo, u[0], [u[1], u[2]], active);
        let worn = self.worn(world, hit, active);
        if worn.none() { scenes } else { Sample::select(worn, self.sample_own(wo, u), scenes) }
    }

    /// An own BSDF has a density, as far as anyone knows: light samples where it has none come to nothing by its `eval`.
    #[inline(always)]
    fn is_delta<R: Real>(&self, world: &World, hit: &Hit<R>, surface: &Surface<R>) -> R::Mask {
        let delta = surface.material.is_delta::<AllModels>();
        if delta.none() { delta } else { delta & !self.worn(world, hit, delta) }
    }

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
        if !L::SHINES {
            return Shade::sample_light(&AllModels, world, [p, facing], table, u_choice, u, active);
        }
        let share = R::splat(Self::share(world));
        let to_own = u_choice.lt(share) & active;
        let own = self.sample_own_light(world, p, u, to_own);
        let rest = rescale(u_choice, share, R::one());
        let mut scenes = Shade::sample_light(&AllModels, world, [p, facing], table, rest, u, active & !to_own);
        scenes.pdf = scenes.pdf * (R::one() - share);
        LightSample::select(to_own, own, scenes)
    }

    #[inline(always)]
    fn scene_light_pdf<R: Real>(&self, world: &World, pdf: R) -> R {
        if L::SHINES { pdf * R::splat(1.0 - Self::share(world)) } else { pdf }
    }

    #[inline(always)]
    fn escaped<R: Real>(&self, world: &World, direction: Vec3<R>) -> (Vec3<R>, R) {
        let (radiance, pdf) = Shade::escaped(&AllModels, world, direction);
        (radiance, self.scene_light_pdf(world, pdf))
    }

    #[inline(always)]
    fn escaped_to_own<R: Real>(&self, world: &World, direction: Vec3<R>) -> (Vec3<R>, R) {
        let (radiance, pdf) = self.light.outside(direction);
        (radiance, pdf * R::splat(Self::share(world)))
    }
}
