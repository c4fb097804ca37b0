//! Lights without extent: point, spot, directional. No ray finds one by chance, so that its samples carry all of its
//! light (MIS weight 1).

use super::LightError;
use super::alias::{MAX_ENTRIES, Table};
use super::sample::{DELTA_LIGHT, LightSample};
use crate::lane::{Bits, Real, Vec3};
use crate::scene::DeltaLight;
use std::f64::consts::{PI, TAU};

/// What a lane needs to sample one light: one cache line.
///
/// Position, unit axis along which light travels, the largest |wi + axis|² that is lit, whether directional, –,
/// intensity or irradiance, choice probability.
type Row = [f32; 16];

const POSITION: usize = 0;
const AXIS: usize = 3;
const LIMIT: usize = 6;
const IS_DIRECTIONAL: usize = 7;
const STRENGTH: usize = 12;
const PDF_ROW: usize = 15;

/// The part of the draws that is spread evenly; the rest goes by power, which says little of what arrives where: a
/// directional light is given all that falls on the scene, a spot may light one thing in it from near by. So no light is
/// drawn less than half as often as by an even choice, nor than by power.
const EVEN_SHARE: f64 = 0.5;

/// Size of the scene, for the units of the kernel.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// The kernel's lengths over the scene's own.
    pub scale: f32,
    /// Half the diagonal of the bounding box, in the kernel's lengths: the disk that a directional light is taken to fill.
    pub radius: f64,
}

pub(super) struct DeltaLights {
    rows: Vec<Row>,
    table: Table,
    power: f64,
}

impl DeltaLights {
    /// `None` where none shines.
    pub(super) fn build(lights: &[DeltaLight], extent: Extent) -> Result<Option<Self>, LightError> {
        let lights: Vec<DeltaLight> = lights.iter().copied().filter(|l| mean(l.strength()) > 0.0).collect();
        if lights.is_empty() {
            return Ok(None);
        }
        if lights.len() > MAX_ENTRIES {
            return Err(LightError::TooMany { count: lights.len(), most: MAX_ENTRIES });
        }
        let powers: Vec<f64> = lights.iter().map(|light| power(light, extent)).collect();
        let total: f64 = powers.iter().sum();
        // A directional light has no power where there is nothing to fall on.
        let even = if total > 0.0 { EVEN_SHARE * total / lights.len() as f64 } else { 1.0 };
        let weights: Vec<f64> = powers.iter().map(|p| (1.0 - EVEN_SHARE) * p + even).collect();
        let (table, probability) = Table::build(&weights);
        let rows: Vec<Row> = lights.iter().zip(&probability).map(|(light, &p)| row(light, extent, p)).collect();
        if rows.iter().any(|row| row.iter().enumerate().any(|(k, x)| k != LIMIT && !x.is_finite())) {
            return Err(LightError::Overflow);
        }
        Ok(Some(Self { rows, table, power: total }))
    }

    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// In the units of [`Emitter::power`](super::Emitter::power).
    pub(super) fn power(&self) -> f64 {
        self.power
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.rows) + self.table.memory()
    }

    /// A light chosen by `u_choice`, as seen from `origin`. Its radiance is what arrives per unit of area across `wi`, its
    /// pdf the probability of the choice times `share`.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, origin: Vec3<R>, u_choice: R, u: [R; 2], share: f32) -> LightSample<R> {
        let index = self.table.choose(u_choice, u);
        let (mut sample, probability) = self.seen(index, origin);
        sample.pdf = sample.pdf * (probability * R::splat(share));
        sample
    }

    /// Light `index`, with pdf 1 where it is lit. Panics past the last.
    pub(super) fn one<R: Real>(&self, index: usize, origin: Vec3<R>) -> LightSample<R> {
        self.seen(R::Bits::splat(index as u32), origin).0
    }

    /// With pdf 1 where `origin` is lit, and the light's choice probability.
    #[inline(always)]
    fn seen<R: Real>(&self, index: R::Bits, origin: Vec3<R>) -> (LightSample<R>, R) {
        let row = R::fetch_rows(&self.rows, index);
        let vector = |k: usize| Vec3::new(row[k], row[k + 1], row[k + 2]);
        let (axis, position) = (vector(AXIS), vector(POSITION));
        let directional = row[IS_DIRECTIONAL].gt(R::zero());
        let way = Vec3::select(directional, -axis, position - origin);
        let squared = way.length_squared();
        let length = squared.sqrt();
        let wi = way * length.recip();
        let falloff = R::select(directional, R::one(), squared.recip());
        // |wi + axis|² = 2 (1 − cos), which tells narrow cones apart where cosines do not.
        let lit = (wi + axis).length_squared().le(row[LIMIT]) & falloff.is_finite();
        let sample = LightSample {
            wi,
            target: position,
            distance: R::select(directional, R::splat(f32::INFINITY), length),
            radiance: vector(STRENGTH) * falloff,
            pdf: R::one().masked(lit),
            is_environment: directional,
            primitive: R::Bits::splat(DELTA_LIGHT),
            ..LightSample::none()
        };
        (sample, row[PDF_ROW])
    }
}

fn row(light: &DeltaLight, extent: Extent, probability: f64) -> Row {
    let scale = f64::from(extent.scale);
    let mut row = [0.0; 16];
    let mut put = |at: usize, v: [f32; 3], factor: f64| {
        (0..3).for_each(|k| row[at + k] = (f64::from(v[k]) * factor) as f32);
    };
    put(STRENGTH, light.strength(), if light.is_directional() { 1.0 } else { scale * scale });
    // Every direction is lit.
    let mut limit = f32::INFINITY;
    match *light {
        DeltaLight::Point { position, .. } => put(POSITION, position, scale),
        DeltaLight::Directional { direction, .. } => put(AXIS, direction, 1.0),
        DeltaLight::Spot { position, direction, angle, .. } => {
            put(POSITION, position, scale);
            put(AXIS, direction, 1.0);
            let half_sin = (f64::from(angle).to_radians() / 2.0).sin();
            limit = (4.0 * half_sin * half_sin) as f32;
        }
    }
    row[LIMIT] = limit;
    row[IS_DIRECTIONAL] = if light.is_directional() { 1.0 } else { 0.0 };
    row[PDF_ROW] = probability as f32;
    row
}

/// The power that leaves the light, for a directional one that through the scene's bounding sphere; the mean over the
/// channels.
fn power(light: &DeltaLight, extent: Extent) -> f64 {
    let scale = f64::from(extent.scale);
    let strength = mean(light.strength());
    match *light {
        DeltaLight::Point { .. } => 2.0 * TAU * scale * scale * strength,
        DeltaLight::Spot { angle, .. } => {
            let half_sin = (f64::from(angle).to_radians() / 2.0).sin();
            TAU * 2.0 * half_sin * half_sin * scale * scale * strength
        }
        DeltaLight::Directional { .. } => PI * extent.radius * extent.radius * strength,
    }
}

fn mean(v: [f32; 3]) -> f64 {
    v.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0
}
