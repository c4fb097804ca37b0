//! Renders of one scene that differ in their seed alone.

use super::reference::Reference;
use crate::renders;
use octolux::film::Film;
use octolux::kernel::World;
use octolux::plan::Force;
use octolux::sampling::SamplerKind;
use octolux::scene::Scene;

/// Which seeds: fixed once and for all.
const FIRST_SEED: u64 = 1;

pub struct Replicates {
    pub width: u32,
    pub height: u32,
    /// Pixels of each render, row by row.
    pub images: Vec<Vec<[f64; 3]>>,
    /// Variance of a pixel's sample, mean over the renders.
    pub sample_variance: Vec<[f64; 3]>,
}

impl Replicates {
    pub fn render(scene: &Scene, sampler: SamplerKind, samples: u64, seeds: u64) -> Self {
        Self::render_by(scene, sampler, seeds, |world| renders::film(world, samples))
    }

    pub fn render_by(scene: &Scene, sampler: SamplerKind, seeds: u64, render: impl Fn(&World) -> Film) -> Self {
        let (width, height) = (scene.film.width, scene.film.height);
        let mut world = renders::sampled(scene, 0, Force::default(), sampler);
        let mut sample_variance = vec![[0.0; 3]; (width * height) as usize];
        let images = (FIRST_SEED..FIRST_SEED + seeds).map(|seed| {
            world.seed = seed;
            let film = render(&world);
            let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            for ((x, y), sum) in places.clone().zip(&mut sample_variance) {
                let variance = film.variance_of_mean(x, y).expect("two samples or more");
                let samples = film.pixel(x, y).samples as f64;
                *sum = std::array::from_fn(|c| sum[c] + variance[c] * (samples / seeds as f64));
            }
            places.map(|(x, y)| film.mean(x, y)).collect()
        });
        let images = images.collect();
        Replicates { width, height, images, sample_variance }
    }

    /// Mean over the renders of mean((x − r)²/(r² + 0.01)).
    pub fn relmse(&self, reference: &Reference) -> f64 {
        let of_pixel =
            |x: &[f64; 3], r: &[f64; 3]| -> f64 { (0..3).map(|c| (x[c] - r[c]).powi(2) / (r[c] * r[c] + 0.01)).sum() };
        let of_image = |image: &Vec<[f64; 3]>| -> f64 {
            image.iter().zip(&reference.pixels).map(|(x, r)| of_pixel(x, r)).sum::<f64>() / (3 * image.len()) as f64
        };
        self.images.iter().map(of_image).sum::<f64>() / self.images.len() as f64
    }
}
