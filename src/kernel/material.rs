//! Materials in lanes: the models evaluated where they occur.

use super::material_table::{
    FRESNEL_EXACT, FRESNEL_SCHLICK, KIND_COATED, KIND_CONDUCTOR, KIND_DIELECTRIC, KIND_DIFFUSE, KIND_PHONG,
};
use crate::bsdf::{ALPHA_MIN, Coated, Conductor, ConductorFresnel, Dielectric, Diffuse, Eval, Model, Phong, Sample};
use crate::lane::{Mask, Real, Vec3};
use crate::plan::{Plan, Shading};

/// The materials at a packet's hits.
#[derive(Clone, Copy)]
pub struct MaterialAt<R: Real> {
    kind: R,
    /// Reflectance, kd, η or f0.
    a: Vec3<R>,
    /// k or ks.
    b: Vec3<R>,
    alpha: R,
    separable: R::Mask,
    /// [`FRESNEL_EXACT`] … of conductors, index of refraction of dielectrics and coats, exponent of Phong.
    c: R,
    /// Radiance from the front.
    pub emission: Vec3<R>,
}

impl<R: Real> MaterialAt<R> {
    /// Reflects and emits nothing.
    #[inline(always)]
    pub fn black() -> Self {
        MaterialAt {
            kind: R::splat(KIND_DIFFUSE),
            a: Vec3::zero(),
            b: Vec3::zero(),
            alpha: R::zero(),
            separable: R::Mask::splat(false),
            c: R::zero(),
            emission: Vec3::zero(),
        }
    }

    /// The material of one lane, in every lane.
    #[inline(always)]
    pub fn in_all_lanes(&self, lane: usize) -> Self {
        MaterialAt {
            kind: R::splat(self.kind.lane(lane)),
            a: Vec3::splat(self.a.lane(lane)),
            b: Vec3::splat(self.b.lane(lane)),
            alpha: R::splat(self.alpha.lane(lane)),
            separable: R::Mask::splat(self.separable.lane(lane)),
            c: R::splat(self.c.lane(lane)),
            emission: Vec3::splat(self.emission.lane(lane)),
        }
    }

    #[inline(always)]
    fn is(&self, kind: f32) -> R::Mask {
        self.kind.eq(R::splat(kind))
    }

    /// Lanes that scatter by Lambert's law.
    #[inline(always)]
    pub fn is_lambert(&self) -> R::Mask {
        self.is(KIND_DIFFUSE)
    }

    /// Lanes of glass and the like.
    #[inline(always)]
    pub fn is_dielectric(&self) -> R::Mask {
        self.is(KIND_DIELECTRIC)
    }

    /// All but the emission; see [`MaterialAt::from_row`].
    #[inline(always)]
    pub fn row(&self) -> [R; 10] {
        let (a, b) = (self.a, self.b);
        [self.kind, a.x, a.y, a.z, b.x, b.y, b.z, self.alpha, R::one().masked(self.separable), self.c]
    }

    /// Emits nothing.
    #[inline(always)]
    pub fn from_row(row: [R; 10]) -> Self {
        let [kind, ax, ay, az, bx, by, bz, alpha, separable, c] = row;
        MaterialAt {
            kind,
            a: Vec3::new(ax, ay, az),
            b: Vec3::new(bx, by, bz),
            alpha,
            separable: separable.gt(R::zero()),
            c,
            emission: Vec3::zero(),
        }
    }

    #[inline(always)]
    fn diffuse(&self) -> Diffuse<R> {
        Diffuse { reflectance: self.a }
    }

    #[inline(always)]
    fn conductor(&self) -> Conductor<R> {
        let fresnel = ConductorFresnel {
            a: self.a,
            b: self.b,
            exact: self.c.eq(R::splat(FRESNEL_EXACT)),
            schlick: self.c.eq(R::splat(FRESNEL_SCHLICK)),
        };
        Conductor { alpha: self.alpha, separable: self.separable, fresnel }
    }

    #[inline(always)]
    fn dielectric(&self) -> Dielectric<R> {
        Dielectric { alpha: self.alpha, separable: self.separable, ior: self.c }
    }

    #[inline(always)]
    fn phong(&self) -> Phong<R> {
        Phong { diffuse: self.a, specular: self.b, exponent: self.c }
    }

    #[inline(always)]
    fn coated(&self) -> Coated<R> {
        Coated { reflectance: self.a, alpha: self.alpha, separable: self.separable, ior: self.c }
    }

    /// f·|cosθi| and pdf, directions in the shading frame.
    #[inline(always)]
    pub fn eval<S: ShadingKind>(&self, plan: &Plan, wo: Vec3<R>, wi: Vec3<R>, active: R::Mask) -> Eval<R> {
        let mut eval = self.diffuse().eval(wo, wi);
        if S::SHADING == Shading::General {
            let conductor = self.is(KIND_CONDUCTOR);
            if (conductor & active).any() {
                eval = select_eval(conductor, eval_out_of_line(&self.conductor(), wo, wi), eval);
            }
            let dielectric = self.is(KIND_DIELECTRIC);
            if (dielectric & active).any() {
                eval = select_eval(dielectric, eval_out_of_line(&self.dielectric(), wo, wi), eval);
            }
            if plan.phong || plan.coated {
                eval = self.eval_layered(wo, wi, active, eval);
            }
        }
        eval
    }

    /// A direction with weight f·|cosθi|/pdf, directions in the shading frame.
    #[inline(always)]
    pub fn sample<S: ShadingKind>(&self, plan: &Plan, wo: Vec3<R>, u_lobe: R, u: [R; 2], active: R::Mask) -> Sample<R> {
        let mut sample = self.diffuse().sample(wo, u_lobe, u);
        if S::SHADING == Shading::General {
            let conductor = self.is(KIND_CONDUCTOR);
            if (conductor & active).any() {
                sample = Sample::select(conductor, sample_out_of_line(&self.conductor(), wo, u_lobe, u), sample);
            }
            let dielectric = self.is(KIND_DIELECTRIC);
            if (dielectric & active).any() {
                sample = Sample::select(dielectric, sample_out_of_line(&self.dielectric(), wo, u_lobe, u), sample);
            }
            if plan.phong || plan.coated {
                sample = self.sample_layered(wo, u_lobe, u, active, sample);
            }
        }
        sample
    }

    /// The models of a base and a lobe in the lanes that have them; the others keep `eval`. One copy a width, called, so
    /// that kernels of scenes without them stay small.
    #[inline(never)]
    fn eval_layered(self, wo: Vec3<R>, wi: Vec3<R>, active: R::Mask, mut eval: Eval<R>) -> Eval<R> {
        let phong = self.is(KIND_PHONG);
        if (phong & active).any() {
            eval = select_eval(phong, self.phong().eval(wo, wi), eval);
        }
        let coated = self.is(KIND_COATED);
        if (coated & active).any() {
            eval = select_eval(coated, self.coated().eval(wo, wi), eval);
        }
        eval
    }

    /// See [`MaterialAt::eval_layered`].
    #[inline(never)]
    fn sample_layered(self, wo: Vec3<R>, u_lobe: R, u: [R; 2], active: R::Mask, mut sample: Sample<R>) -> Sample<R> {
        let phong = self.is(KIND_PHONG);
        if (phong & active).any() {
            sample = Sample::select(phong, self.phong().sample(wo, u_lobe, u), sample);
        }
        let coated = self.is(KIND_COATED);
        if (coated & active).any() {
            sample = Sample::select(coated, self.coated().sample(wo, u_lobe, u), sample);
        }
        sample
    }

    /// Lanes whose material scatters by a delta alone, as far as its roughness says: light sampling cannot find its directions.
    #[inline(always)]
    pub fn is_delta<S: ShadingKind>(&self) -> R::Mask {
        match S::SHADING {
            Shading::Lambert => R::Mask::splat(false),
            Shading::General => {
                let one_lobe = self.is(KIND_CONDUCTOR) | self.is(KIND_DIELECTRIC);
                one_lobe & self.alpha.lt(R::splat(ALPHA_MIN))
            }
        }
    }

    /// Lanes some of whose light comes by a delta: no density but the material's own finds it.
    pub fn has_delta(&self) -> R::Mask {
        let of_one_lobe = (self.is(KIND_CONDUCTOR) & self.conductor().delta())
            | (self.is(KIND_DIELECTRIC) & self.dielectric().delta());
        of_one_lobe | (self.is(KIND_COATED) & self.coated().delta())
    }

    /// Multiplies the colours; a second beside the first is held to what the first leaves.
    #[inline(always)]
    pub(super) fn multiply(&mut self, first: Vec3<R>, second: Vec3<R>, active: R::Mask) {
        self.a = self.a.hadamard(first);
        let phong = self.is(KIND_PHONG) & active;
        let held = |b: R, a: R| b.min_or(R::one() - a);
        let b = self.b.hadamard(second);
        let b = Vec3::new(held(b.x, self.a.x), held(b.y, self.a.y), held(b.z, self.a.z));
        self.b = Vec3::select(phong, b, self.b);
    }

    #[inline(always)]
    pub(super) fn set_alpha(&mut self, lanes: R::Mask, alpha: R) {
        self.alpha = R::select(lanes, alpha, self.alpha);
    }

    /// A conductor with the first colour as reflectance at normal incidence.
    #[inline(always)]
    pub(super) fn make_metal(&mut self, lanes: R::Mask, alpha: R) {
        self.kind = R::select(lanes, R::splat(KIND_CONDUCTOR), self.kind);
        self.c = R::select(lanes, R::splat(FRESNEL_SCHLICK), self.c);
        self.set_alpha(lanes, alpha);
    }

    pub(super) fn is_phong(&self) -> R::Mask {
        self.is(KIND_PHONG)
    }

    pub(super) fn is_conductor(&self) -> R::Mask {
        self.is(KIND_CONDUCTOR)
    }

    #[inline(always)]
    pub(super) fn is_coated(&self) -> R::Mask {
        self.is(KIND_COATED)
    }

    /// n of [`MaterialAt::is_phong`] lanes.
    pub(super) fn phong_exponent(&self) -> R {
        self.c
    }

    /// Of microfacets.
    pub(super) fn alpha(&self) -> R {
        self.alpha
    }

    /// A Phong material that is the same in every lane as two: its base, and its lobe.
    pub(super) fn split_phong(&self) -> [Self; 2] {
        let (mut base, mut lobe) = (self.in_all_lanes(0), self.in_all_lanes(0));
        base.b = Vec3::zero();
        lobe.a = Vec3::zero();
        [base, lobe]
    }

    /// The coat of a coated material that is the same in every lane, over a black base.
    pub(super) fn coat_alone(&self) -> Self {
        let mut coat = self.in_all_lanes(0);
        coat.a = Vec3::zero();
        coat
    }

    /// Lanes whose light comes from the hemisphere on the viewer's side alone, and by no delta.
    #[inline(always)]
    pub fn gathers(&self) -> R::Mask {
        let microfacets = self.is(KIND_CONDUCTOR) | self.is(KIND_COATED);
        let smooth = microfacets & self.alpha.lt(R::splat(ALPHA_MIN));
        !smooth & !self.is(KIND_DIELECTRIC)
    }

    /// Reflectance as the feature image shows it: ρ of Lambert and below a coat, kd + ks of Phong, F at normal incidence
    /// of a conductor, 1 of glass.
    #[inline(always)]
    pub fn albedo(&self) -> Vec3<R> {
        let normal_incidence = self.conductor().fresnel.reflectance(R::one());
        let reflectance = self.a + self.b.masked(self.is(KIND_PHONG));
        Vec3::select(self.is(KIND_CONDUCTOR), normal_incidence, reflectance)
    }
}

/// The models beyond Lambert are long and rare beside Lambert: one copy a width, called, instead of one in every kernel.
#[inline(never)]
fn eval_out_of_line<R: Real, B: Model<R>>(bsdf: &B, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
    bsdf.eval(wo, wi)
}

/// See [`eval_out_of_line`].
#[inline(never)]
fn sample_out_of_line<R: Real, B: Model<R>>(bsdf: &B, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R> {
    bsdf.sample(wo, u_lobe, u)
}

#[inline(always)]
fn select_eval<R: Real>(mask: R::Mask, a: Eval<R>, b: Eval<R>) -> Eval<R> {
    Eval { value: Vec3::select(mask, a.value, b.value), pdf: R::select(mask, a.pdf, b.pdf) }
}

/// Which models a kernel is compiled with.
pub trait ShadingKind: Sync + 'static {
    const SHADING: Shading;
}
/// Lambert alone.
#[derive(Default)]
pub struct LambertOnly;
/// All models.
#[derive(Default)]
pub struct AllModels;
impl ShadingKind for LambertOnly {
    const SHADING: Shading = Shading::Lambert;
}
impl ShadingKind for AllModels {
    const SHADING: Shading = Shading::General;
}
