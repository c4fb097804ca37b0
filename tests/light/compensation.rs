//! Samples of a sky that stand beside a material's own: their density in f64 by itself, and that images stay what they were.

use super::TESTS;
use super::environment::{assert_follow_their_density, images};
use super::image::reference_lookup;
use super::scenes::*;
use crate::renders::{self, Set, assert_image_mean};
use crate::stats::Rng;
use crate::stats::quadrature::gauss_legendre;
use octolux::Renderer;
use octolux::bsdf::{Eval, Sample};
use octolux::kernel::{Prepare, World};
use octolux::lane::{Mask, Real, Vec3};
use octolux::light::{EnvironmentMap, Extent, Lights, SkySamples};
use octolux::own::{Bsdf, Own};
use octolux::plan::{Force, Plan};
use octolux::sampling::{SamplerKind, warp};
use octolux::scene::{Environment, EnvironmentImage, IntegratorKind, Scene};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

fn compensated(image: &EnvironmentImage) -> Lights {
    let sky = Environment::Image(image.clone());
    let extent = Extent { scale: 1.0, radius: 1.0 };
    Lights::with_delta(Vec::new(), EnvironmentMap::sampled(&sky, SkySamples::Compensated), &[], extent).unwrap()
}

/// The weights of texel centres: the mean over the channels less that over the sphere, times sin θ; and whether they count.
struct Oracle<'a> {
    image: &'a EnvironmentImage,
    mean: f64,
}

impl Oracle<'_> {
    fn of(image: &EnvironmentImage) -> Oracle<'_> {
        let (mut light, mut area) = (0.0, 0.0);
        for (i, texel) in image.texels.iter().enumerate() {
            let sin = (PI * ((i / image.width) as f64 + 0.5) / image.height as f64).sin();
            light += sin * f64s(*texel).iter().sum::<f64>() / 3.0;
            area += sin;
        }
        Oracle { image, mean: light / area }
    }

    /// `row` −1 and `height` are the poles.
    fn weight(&self, row: isize, column: usize) -> f64 {
        if row < 0 || row >= self.image.height as isize {
            return 0.0;
        }
        let texel = self.image.texels[row as usize * self.image.width + column % self.image.width];
        let excess = f64s(texel).iter().sum::<f64>() / 3.0 - self.mean;
        excess.max(0.0) * (PI * (row as f64 + 0.5) / self.image.height as f64).sin()
    }

    /// From the north: the row above cell `j`, and the share of a row's height that it has.
    fn cell_height(&self, j: usize) -> f64 {
        if j == 0 || j == self.image.height { 0.5 } else { 1.0 }
    }

    fn cell(&self, j: usize, c: usize) -> [[f64; 2]; 2] {
        [j as isize - 1, j as isize].map(|row| [self.weight(row, c), self.weight(row, c + 1)])
    }

    fn mass(&self, j: usize, c: usize) -> f64 {
        self.cell(j, c).iter().flatten().sum::<f64>() / 4.0 * self.cell_height(j)
    }

    /// The density per solid angle, and what rounding may make of it: places to (width + height)·2⁻²³ of a cell, and
    /// probabilities of a row and of a column in it to a step of 2⁻²⁴ at either end.
    fn density(&self, d: V, masses: &[f64]) -> (f64, f64) {
        let (width, height) = (self.image.width, self.image.height);
        let d = unit(d);
        let x = (d[0].atan2(-d[2]) / TAU).rem_euclid(1.0) * width as f64 - 0.5;
        let v = d[1].clamp(-1.0, 1.0).acos() / PI * height as f64;
        let column = x.rem_euclid(width as f64).floor() as usize % width;
        let (fx, row) = (x - x.floor(), v + 0.5);
        let j = (row.floor() as usize).min(height);
        let fy = match j {
            0 => 2.0 * v,
            j if j == height => 2.0 * (v - height as f64) + 1.0,
            _ => row - row.floor(),
        };
        let corners = self.cell(j, column);
        let along = corners.map(|[left, right]| left * (1.0 - fx) + right * fx);
        let sin = (1.0 - d[1] * d[1]).max(0.0).sqrt();
        let total: f64 = masses.iter().sum();
        let scale = (width * height) as f64 / (total * 2.0 * PI * PI * sin);
        let density = scale * (along[0] * (1.0 - fy) + along[1] * fy);
        let largest = scale * corners.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
        let in_row: f64 = masses[j * width..][..width].iter().sum();
        let step = 2f64.powi(-24) * (total / in_row + in_row / masses[j * width + column]);
        let place = 2f64.powi(-23) * (4 * (width + height) + 32) as f64;
        (density, largest * place + if density > 0.0 { density * step } else { 0.0 })
    }

    fn masses(&self) -> Vec<f64> {
        let (width, cells) = (self.image.width, (self.image.height + 1) * self.image.width);
        (0..cells).map(|i| self.mass(i / width, i % width)).collect()
    }
}

#[test]
fn samples_follow_their_density() {
    assert_follow_their_density(compensated);
}

#[test]
fn density_is_what_exceeds_the_mean() {
    let mut tried = 0;
    for (name, image) in images() {
        let oracle = Oracle::of(&image);
        let masses = oracle.masses();
        if masses.iter().sum::<f64>() == 0.0 {
            continue;
        }
        tried += 1;
        let lights = compensated(&image);
        let (mut rng, mut dark) = (Rng::new(21), 0);
        for _ in 0..20_000 {
            let d = f32s(rng.sphere());
            let (expected, bound) = oracle.density(f64s(d), &masses);
            let found = f64::from(lights.environment(vec1(d)).1);
            assert!((found - expected).abs() <= bound, "{name} at {d:?}: {found}, not {expected} ± {bound}");
            dark += usize::from(found == 0.0);
        }
        if ["sun", "half dark", "bright pole", "bright south"].contains(&name) {
            assert!(dark > 1000, "{name}: what lies below the mean is left out");
        }
        // And the sample says the same.
        for _ in 0..20_000 {
            let s = draw(&lights, [0.0; 3], &mut rng);
            let (expected, bound) = oracle.density(f64s(s.wi.lane(0)), &masses);
            let found = f64::from(s.pdf);
            assert!((found - expected).abs() <= bound, "{name} sampled {s:?}: not {expected} ± {bound}");
        }
    }
    assert!(tried >= 8, "{tried} images vary");
}

/// Where nothing, or next to nothing, exceeds the mean, radiance decides as it does alone.
#[test]
fn even_skies_are_sampled_by_radiance() {
    let nearly = noise(16, 8, 0.9999, 1.0001, 22);
    for image in [image(10, 5, |_, _| [1.0, 0.2, 3.0]), image(4, 2, |_, _| [1e37; 3]), nearly] {
        let (alone, beside) = (image_lights(&image), compensated(&image));
        let mut rng = Rng::new(23);
        for _ in 0..1000 {
            let d = vec1(f32s(rng.sphere()));
            assert!(beside.environment(d).1 > 0.0);
            assert_eq!(beside.environment(d).1.to_bits(), alone.environment(d).1.to_bits());
        }
    }
}

/// A white floor that covers the film, normal +y, under `image`.
fn floor(image: &EnvironmentImage, kind: IntegratorKind) -> Scene {
    let mut set = Set::new([-2.0, 1.0, 0.1], [0.0; 3], 1e-3, 8).bounces(1).integrator(kind);
    let white = set.grey(1.0, 0.0);
    set.triangle(white, [[-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, -1.0]]);
    set.environment(Environment::Image(image.clone())).finish()
}

/// ∫ L cosθ dω/π about +y by Gauss quadrature of an f64 look-up, cell by cell; `height` is odd, so that the horizon is a
/// border of cells.
fn reflected(image: &EnvironmentImage) -> V {
    let rule = gauss_legendre(16);
    let mut sum = [0.0; 3];
    for j in 0..=image.height / 2 {
        let edge = |j: f64| j.clamp(0.0, image.height as f64) / image.height as f64;
        let (v0, v1) = (edge(j as f64 - 0.5), edge(j as f64 + 0.5));
        for c in 0..image.width {
            for &(y, wy) in &rule {
                let v = v0 + (v1 - v0) * 0.5 * (1.0 + y);
                for &(x, wx) in &rule {
                    let u = (c as f64 + 1.0 + 0.5 * x) / image.width as f64;
                    let (s, cos) = (PI * v).sin_cos();
                    let d = [s * (TAU * u).sin(), cos, -s * (TAU * u).cos()];
                    let weight = 0.25 * wx * wy * (v1 - v0) / image.width as f64 * 2.0 * PI * PI * s;
                    let radiance = reference_lookup(image, d);
                    (0..3).for_each(|k| sum[k] += weight * radiance[k] * cos * FRAC_1_PI);
                }
            }
        }
    }
    sum
}

fn skies() -> Vec<EnvironmentImage> {
    let sun = image(32, 17, |r, c| match (r, c) {
        (4, 20) => [3e3, 2.5e3, 2e3],
        (9.., _) => [0.1, 0.08, 0.05],
        _ => [0.2, 0.3, 0.6],
    });
    let below = image(8, 5, |r, _| if r > 2 { [5.0; 3] } else { [0.3; 3] });
    vec![sun, noise(8, 5, 0.0, 1.0, 24), below, image(4, 3, |_, _| [0.7; 3])]
}

#[test]
fn a_floor_reflects_the_integral() {
    for image in skies() {
        let expected = reflected(&image);
        for kind in [IntegratorKind::Path, IntegratorKind::Direct] {
            let world = renders::world(&floor(&image, kind), 25);
            assert!(world.plan.compensated_sky);
            let film = renders::film(&world, 16_384);
            assert_image_mean("floor", &film, expected, 2e-5 * expected[2], TESTS);
        }
    }
}

/// Half of Lambert's directions: light samples alone bring the others.
struct Halved;

impl Bsdf for Halved {
    fn eval<R: Real>(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let pdf = warp::cosine_hemisphere_pdf(wi.z).masked(wo.z.gt(R::zero()));
        Eval { value: Vec3::splat([1.0; 3]) * pdf, pdf: (pdf + pdf).masked(wi.x.gt(R::zero())) }
    }

    fn sample<R: Real>(&self, wo: Vec3<R>, _u_lobe: R, u: [R; 2]) -> Sample<R> {
        let mut wi = warp::cosine_hemisphere(u);
        wi.x = wi.x.abs();
        let valid = wo.z.gt(R::zero()) & wi.x.gt(R::zero());
        let half = R::splat(0.5).masked(valid);
        let pdf = (warp::cosine_hemisphere_pdf(wi.z) * R::splat(2.0)).masked(valid);
        Sample { wi, weight: Vec3::new(half, half, half), pdf, eta: R::one(), delta: R::Mask::splat(false), valid }
    }
}

#[test]
fn materials_of_a_programs_own_may_leave_directions_to_the_light() {
    for image in skies() {
        let expected = reflected(&image);
        let renderer = Renderer::new(4096).seed(26).sampler(SamplerKind::Independent);
        let film = renderer.render_with(&floor(&image, IntegratorKind::Path), &Own::new().bsdf(0, Halved)).unwrap();
        assert_image_mean("halved", &film, expected, 2e-5 * expected[2], TESTS);
    }
}

/// The plan keeps it where samples stand beside a material's own, in the general kernel as well, and nowhere else.
#[test]
fn where_the_plan_keeps_it() {
    let sky = noise(8, 5, 0.0, 1.0, 27);
    let kept = |kind, general| Plan::new(&floor(&sky, kind), Force { general, geometry: None }, false).compensated_sky;
    for general in [false, true] {
        assert!(kept(IntegratorKind::Path, general) && kept(IntegratorKind::Direct, general));
        assert!(!kept(IntegratorKind::Gather, general) && !kept(IntegratorKind::Phong, general));
    }
    let scene = floor(&sky, IntegratorKind::Path);
    let pdf_below = |plan: Plan| {
        let world = World::new(&scene, plan, Prepare::default()).unwrap();
        let lights = world.lights.as_ref().unwrap();
        let mut rng = Rng::new(28);
        (0..1000).filter(|_| lights.environment(vec1(f32s(rng.sphere()))).1 == 0.0).count()
    };
    let plan = || Plan::new(&scene, Force::default(), false);
    assert!(pdf_below(plan()) > 0 && pdf_below(plan().with_light_samples_alone()) == 0);
}
