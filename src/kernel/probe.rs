//! Probes: watching, and for `check` disturbing, the values a kernel computes.
//!
//! The kernel passes the values worth comparing through [`Probe::tap`]. [`NoProbe`] is the identity and leaves no
//! code; [`Recorder`] keeps every value with its sample, bounce, stage and lane, and can flip one bit of a stage to
//! prove that `check` would notice.

use crate::geometry::MISS;
use crate::lane::{Bits, Mask, Real, Vec3};

/// What a tapped value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Numbers of a bounce.
    Random,
    /// Distance of a hit, in lengths of its ray's direction.
    HitT,
    /// Index of the primitive that was hit.
    HitPrimitive,
    /// First barycentric coordinate.
    HitU,
    /// Second barycentric coordinate.
    HitV,
    /// What an emitter or the environment adds.
    Emission,
    /// Density of a light sample, as techniques are weighed by it: that of an even choice where the sample follows a slope of its lamp.
    LightPdf,
    /// What a light sample adds if nothing hides it.
    LightContribution,
    /// Is it hidden, or the share that cut-outs let through.
    Shadow,
    /// Density of a scattered direction.
    BsdfPdf,
    /// f·cosθ/pdf of a scattered direction.
    BsdfWeight,
    /// Probability to survive.
    Roulette,
    /// What paths of other pixels, and its own beyond its second vertex, find for it.
    Shared,
    /// What a path found in all.
    Radiance,
}

impl Stage {
    /// In the order of a path.
    pub const ALL: [Stage; 14] = [
        Stage::Random,
        Stage::HitT,
        Stage::HitPrimitive,
        Stage::HitU,
        Stage::HitV,
        Stage::Emission,
        Stage::LightPdf,
        Stage::LightContribution,
        Stage::Shadow,
        Stage::BsdfPdf,
        Stage::BsdfWeight,
        Stage::Roulette,
        Stage::Shared,
        Stage::Radiance,
    ];

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Random => "random",
            Stage::HitT => "hit-t",
            Stage::HitPrimitive => "hit-primitive",
            Stage::HitU => "hit-u",
            Stage::HitV => "hit-v",
            Stage::Emission => "emission",
            Stage::LightPdf => "light-pdf",
            Stage::LightContribution => "light-contribution",
            Stage::Shadow => "shadow",
            Stage::BsdfPdf => "bsdf-pdf",
            Stage::BsdfWeight => "bsdf-weight",
            Stage::Roulette => "roulette",
            Stage::Shared => "shared",
            Stage::Radiance => "radiance",
        }
    }
}

/// Which sample of the tile each lane works on, and at which bounce.
#[derive(Clone, Copy)]
pub struct Lanes<R: Real> {
    /// Of the job.
    pub slot: R::Bits,
    /// 0 at the first hit.
    pub bounce: R,
    /// Lanes that hold a sample.
    pub active: R::Mask,
}

/// Sees values on their way through the kernel.
pub trait Probe {
    /// Does it look at anything?
    const ACTIVE: bool = true;

    /// Returns the value to go on with.
    fn tap<R: Real>(&mut self, stage: Stage, lanes: Lanes<R>, value: R) -> R;

    /// Three taps.
    #[inline(always)]
    fn tap_rgb<R: Real>(&mut self, stage: Stage, lanes: Lanes<R>, v: Vec3<R>) -> Vec3<R> {
        Vec3::new(self.tap(stage, lanes, v.x), self.tap(stage, lanes, v.y), self.tap(stage, lanes, v.z))
    }
    /// A tap of 1 or 0.
    #[inline(always)]
    fn tap_mask<R: Real>(&mut self, stage: Stage, lanes: Lanes<R>, mask: R::Mask) -> R::Mask {
        self.tap(stage, lanes, R::one().masked(mask)).gt(R::zero())
    }
}

/// Sees nothing and costs nothing.
pub struct NoProbe;

impl Probe for NoProbe {
    const ACTIVE: bool = false;

    #[inline(always)]
    fn tap<R: Real>(&mut self, _: Stage, _: Lanes<R>, value: R) -> R {
        value
    }
    #[inline(always)]
    fn tap_mask<R: Real>(&mut self, _: Stage, _: Lanes<R>, mask: R::Mask) -> R::Mask {
        mask
    }
}

/// One value of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// 0 at the first hit.
    pub bounce: u32,
    /// What it is.
    pub stage: Stage,
    /// That computed it.
    pub lane: u32,
    /// Of the f32.
    pub bits: u32,
    /// Is it of what the path finds for all pixels that share paths with its own?
    pub for_all: bool,
}

/// Keeps what passes, per sample slot and in the order of the path.
#[derive(Default)]
pub struct Recorder {
    /// Indexed by slot.
    pub records: Vec<Vec<Record>>,
    /// Disturbs the first value of this stage of every sample whose slot is divisible by 7.
    pub fault: Option<Stage>,
    /// Values that were.
    pub faults: u64,
}

impl Recorder {
    /// A recorder for slots `0..slots`.
    pub fn new(slots: usize, fault: Option<Stage>) -> Self {
        Self { records: vec![Vec::new(); slots], fault, faults: 0 }
    }
}

/// Another value that the kernel can go on with: a truth value negated, another primitive of the scene, else the last
/// bit flipped.
fn disturbed(stage: Stage, bits: u32) -> u32 {
    match stage {
        Stage::Shadow => bits ^ 1f32.to_bits(),
        Stage::HitPrimitive if bits == MISS => MISS,
        Stage::HitPrimitive => bits.wrapping_sub(1),
        _ => bits ^ 1,
    }
}

impl Probe for Recorder {
    fn tap<R: Real>(&mut self, stage: Stage, lanes: Lanes<R>, mut value: R) -> R {
        let active = lanes.active.bits();
        for lane in (0..R::WIDTH).filter(|lane| active >> lane & 1 != 0) {
            let slot = lanes.slot.lane(lane);
            let bounce = lanes.bounce.lane(lane) as u32;
            let mut bits = value.lane(lane).to_bits();
            // What is shared has slots of its own behind those of the samples.
            let (count, slot) = (self.records.len(), slot as usize);
            let (for_all, slot) = (slot >= count, slot % count);
            let first = || self.records[slot].iter().all(|record| record.stage != stage);
            if self.fault == Some(stage) && slot.is_multiple_of(7) && first() {
                bits = disturbed(stage, bits);
                value.set_lane(lane, f32::from_bits(bits));
                self.faults += 1;
            }
            self.records[slot].push(Record { bounce, stage, lane: lane as u32, bits, for_all });
        }
        value
    }
}
