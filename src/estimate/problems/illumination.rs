//! L_r at a pixel of a scene: the integral that a renderer estimates, by densities one at a time.

use super::{Problem, unknown_method};
use crate::estimate::biased::{clamped, pilot_reuse};
use crate::estimate::method::{Integrand, Method, Shared, mean_over, with_values};
use crate::estimate::points::{Points, lane_unit};
use crate::estimate::study::Quantity;
use crate::kernel::{PixelPoint, Technique, Width, World};
use crate::lane::{Bits, Real, f32x8, f32x16};
use crate::report::fit::Estimate;
use crate::sampling::sample_key;
use rayon::prelude::*;
use std::sync::Arc;

/// Samples of a technique at the point: f·cosθ·L/p.
struct Pixel {
    world: Arc<World>,
    point: PixelPoint,
    technique: Technique,
}

impl Pixel {
    fn lanes<R: Real>(&self, bits: &[Vec<u32>], values: &mut [f64]) {
        for (block, out) in values.chunks_mut(R::WIDTH).enumerate() {
            let mut u = [R::splat(0.5); 6];
            for (u, row) in u.iter_mut().zip(&bits[..self.technique.dimensions()]) {
                *u = lane_unit::<R>(R::Bits::load(&row[block * R::WIDTH..]));
            }
            let value = self.point.sample(&self.world, self.technique, u);
            out.iter_mut().enumerate().for_each(|(lane, out)| *out = f64::from(value.lane(lane)));
        }
    }
}

impl Integrand for Pixel {
    fn dimensions(&self) -> usize {
        self.technique.dimensions()
    }

    fn at(&self, x: &[f64]) -> f64 {
        let mut u = [0.5; 6];
        u.iter_mut().zip(x).for_each(|(u, x)| *u = (*x as f32).min(crate::sampling::ONE_BELOW));
        f64::from(self.point.sample::<f32>(&self.world, self.technique, u))
    }

    fn fill(&self, width: Width, bits: &[Vec<u32>], values: &mut [f64]) {
        match width {
            Width::One => self.lanes::<f32>(bits, values),
            Width::Eight => self.lanes::<f32x8>(bits, values),
            Width::Sixteen => self.lanes::<f32x16>(bits, values),
        }
    }
}

pub struct Illumination {
    quantity: Quantity,
    world: Arc<World>,
    point: PixelPoint,
    width: Width,
}

/// The reference: scrambled replicates, and points in each.
const REPLICATES: u32 = 16;
const REFERENCE_POINTS: usize = 1 << 16;

const TECHNIQUES: [(&str, Technique); 5] = [
    ("uniform", Technique::Uniform),
    ("cosine", Technique::Cosine),
    ("bsdf", Technique::Bsdf),
    ("light", Technique::Light),
    ("mis", Technique::Mis),
];

/// Light reflected to the viewer at the centre of a pixel: what lights and sky send there directly.
///
/// # Errors
/// The pixel is outside the picture, or shows nothing that reflects light so.
pub fn illumination(world: World, name: &str, [x, y]: [u32; 2], width: Width) -> Result<Illumination, String> {
    let film = world.film;
    if x >= film.width || y >= film.height {
        return Err(format!(
            "pixel {x},{y} is outside the image of {}x{}; columns and rows count from 0",
            film.width, film.height
        ));
    }
    if !world.plan.light_transport || world.lights.is_none() {
        return Err(format!(
            "{name} has no light, or its integrator carries none; choose a lit scene with integrator path"
        ));
    }
    if world.plan.cutouts {
        return Err(format!("{name} has cut-outs, which let light through by chance; choose a scene without"));
    }
    let point =
        PixelPoint::find(&world, x, y).map_err(|why| format!("pixel {x},{y} {why}; choose another with --pixel"))?;
    let world = Arc::new(world);
    let reference = reference(&world, point, width);
    let quantity = Quantity {
        name: format!("illumination, {name}, pixel {x},{y}"),
        formula: "∫ L f cosθ dω, luminance, light with extent arriving directly".into(),
        exact: reference.value,
        exact_error: reference.hi - reference.value,
        source: format!("{REPLICATES} scrambled replicates of {REFERENCE_POINTS} points, bsdf and light by MIS"),
    };
    Ok(Illumination { quantity, world, point, width })
}

fn reference(world: &Arc<World>, point: PixelPoint, width: Width) -> Estimate {
    let pixel = Pixel { world: world.clone(), point, technique: Technique::Mis };
    // 6 dimensions: always there.
    let Some(plan) = Points::Owen.plan(REFERENCE_POINTS, pixel.dimensions()) else { return Estimate::mean(&[]) };
    let replicate = |r: u32| {
        // A key that no study's repeat has.
        let key = sample_key(u64::MAX, u32::MAX, r);
        with_values(&plan, &pixel, width, key, |v| v.iter().sum::<f64>() / v.len() as f64)
    };
    let means: Vec<f64> = (0..REPLICATES).into_par_iter().map(replicate).collect();
    Estimate::mean(&means)
}

impl Illumination {
    fn samples(&self, technique: Technique) -> Shared {
        Arc::new(Pixel { world: self.world.clone(), point: self.point, technique })
    }
}

impl Problem for Illumination {
    fn quantity(&self) -> Quantity {
        self.quantity.clone()
    }

    fn method_names(&self) -> (Vec<String>, usize) {
        let mut names: Vec<String> = TECHNIQUES.iter().map(|(name, _)| format!("mc:{name}")).collect();
        names.extend(
            ["owen:mis", "sobol:mis", "halton:mis", "owen:light", "owen:bsdf", "clamped", "pilot-reuse"]
                .map(String::from),
        );
        (names, TECHNIQUES.len() + 1)
    }

    fn method(&self, name: &str) -> Result<Method, String> {
        match name {
            "clamped" => return Ok(clamped(self.samples(Technique::Bsdf), 1.5 * self.quantity.exact, self.width)),
            "pilot-reuse" => return Ok(pilot_reuse(self.samples(Technique::Bsdf), self.width)),
            _ => {}
        }
        let (points, technique) = name.split_once(':').unwrap_or((name, "mis"));
        let points = Points::ALL.into_iter().find(|p| p.name() == points);
        let technique = TECHNIQUES.iter().find(|t| t.0 == technique);
        match (points, technique) {
            (Some(points), Some((_, technique))) => Ok(mean_over(name, points, self.samples(*technique), self.width)),
            _ => Err(unknown_method(self, name)),
        }
    }
}
