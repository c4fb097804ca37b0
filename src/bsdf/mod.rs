//! How surfaces scatter: one model a file, over lanes.
//!
//! Directions are unit vectors that point away from the surface, in a local frame whose z axis is the normal: `wo`
//! towards the viewer, `wi` towards where the light comes from. All but dielectrics are two-sided (the frame is mirrored
//! where `wo` is below); a dielectric reads from the sign of `wo.z` whether `wo` is outside (> 0).
//!
//! Where a model divides by a cosine on paper, the quotient is written in cancelled form here: everything stays
//! finite at grazing angles and for every `alpha` down to [`ALPHA_MIN`].

mod coated;
mod conductor;
mod dielectric;
mod diffuse;
pub mod fresnel;
pub mod ggx;
mod phong;

pub use coated::Coated;
pub use conductor::{Conductor, ConductorFresnel};
pub use dielectric::{Dielectric, LOBE_MIN};
pub use diffuse::Diffuse;
pub use phong::{EXPONENT_MAX, Phong};

use crate::lane::{Bits, Mask, Real, Vec3};

/// Lanes with `alpha` below this scatter as a perfect mirror or smooth interface (a delta lobe).
///
/// A microfacet normal rebuilt from two f32 directions is off by about 2⁻²⁴ in slope, and the density D by about
/// 2·2⁻²⁴/alpha of itself: .1 % here. A narrower lobe could be sampled but not evaluated.
pub const ALPHA_MIN: f32 = 1e-4;

/// A sampled direction. In lanes that are not `valid` nothing but `weight` = 0, `pdf` = 0 and a finite `wi` is promised.
#[derive(Clone, Copy, Debug)]
pub struct Sample<R: Real> {
    /// Unit.
    pub wi: Vec3<R>,
    /// f·|cosθi|/pdf in cancelled form; includes the probability of the lobe that was chosen.
    pub weight: Vec3<R>,
    /// Per solid angle, over all lobes: what [`Model::eval`] gives for `wi`. 0 in delta lanes, which have no such
    /// density: their MIS weight is 1.
    pub pdf: R,
    /// The relative index that the path crossed, η(side of `wi`)/η(side of `wo`); 1 where it stayed on its side.
    /// Transmitted radiance is scaled by 1/eta²: roulette on the throughput multiplies its eta² back.
    pub eta: R,
    /// `wi` is the only direction of its lobe.
    pub delta: R::Mask,
    /// `wi` carries something. Below-horizon samples are not valid; they are not redrawn, so that pdfs hold.
    pub valid: R::Mask,
}

impl<R: Real> Sample<R> {
    /// Lanes of `a` where the mask holds, else of `b`.
    #[inline(always)]
    pub(crate) fn select(mask: R::Mask, a: Self, b: Self) -> Self {
        Sample {
            wi: Vec3::select(mask, a.wi, b.wi),
            weight: Vec3::select(mask, a.weight, b.weight),
            pdf: R::select(mask, a.pdf, b.pdf),
            eta: R::select(mask, a.eta, b.eta),
            delta: R::Mask::select(mask, a.delta, b.delta),
            valid: R::Mask::select(mask, a.valid, b.valid),
        }
    }
}

/// A BSDF towards a given direction; both 0 for delta lobes.
#[derive(Clone, Copy, Debug)]
pub struct Eval<R: Real> {
    /// f·|cosθi|.
    pub value: Vec3<R>,
    /// Of [`Model::sample`] drawing `wi`, per solid angle.
    pub pdf: R,
}

/// What the kernel asks of a BSDF. `weight·pdf = value` of the sampled direction, up to rounding.
pub trait Model<R: Real> {
    /// f·|cosθi| and pdf towards unit directions.
    fn eval(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R>;
    /// `u_lobe` chooses among lobes, `u` the direction; each in [0, 1).
    fn sample(&self, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R>;
}

/// `value` with its sign flipped where `sign` is negative (−0 included): into the frame that has `sign` above, and back.
#[inline(always)]
fn mirrored<R: Real>(value: R, sign: R) -> R {
    R::from_bits(value.to_bits() ^ (sign.to_bits() & R::Bits::splat(0x8000_0000)))
}

/// `v` in the frame that has `sign` above, and back.
#[inline(always)]
fn mirrored_z<R: Real>(v: Vec3<R>, sign: R) -> Vec3<R> {
    Vec3::new(v.x, v.y, mirrored(v.z, sign))
}
