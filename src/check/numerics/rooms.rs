//! Whole renders: rooms that nothing may enter, paths of thousands of bounces, light from 1e-30 to 1e30, scenes times 2ᵏ.

use super::random::Random;
use super::shapes::{Shape, scene};
use super::{Effort, Row};
use crate::film::Film;
use crate::kernel::{Prepare, Width, World};
use crate::plan::{Force, Plan};
use crate::render::{self, Budget, Options, Progress};
use crate::scene::{Bsdf, Environment, NO_NORMAL, Scene};

const GROUP: &str = "rooms";

pub fn rows(effort: Effort) -> Vec<Row> {
    let samples = effort.pick(8, 64, 4096);
    let mut rows = vec![];
    for (name, normals) in NORMALS {
        rows.push(dark(name, *normals, samples));
    }
    rows.push(white_cavity(effort.pick(4, 16, 256)));
    rows.push(bits_kept("light × 2^±100: the image times that", samples, &[-100, 100], brighter));
    rows.push(bits_kept("lengths × 2^±66: the same image", samples, &[-66, 66], longer));
    rows
}

/// On one thread: the groups run on a pool of their own.
fn film(scene: &Scene, width: Width, samples: u64) -> Film {
    let plan = Plan::new(scene, Force::default(), false);
    let world = World::new(scene, plan, Prepare { seed: 7, ..Prepare::default() });
    let world = world.unwrap_or_else(|error| unreachable!("{error}"));
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    let options = Options { budget, width, tile: 16, aovs: false, output_seconds: 0.0, adaptive: false };
    let pool = render::thread_pool(1).unwrap_or_else(|error| unreachable!("{error}"));
    render::render(&world, &options, &pool, &mut Progress::quiet()).film
}

fn values(film: &Film) -> impl Iterator<Item = f64> {
    (0..film.height()).flat_map(move |y| (0..film.width()).flat_map(move |x| film.mean(x, y)))
}

/// A ball of white walls around the camera, facing inwards.
fn room() -> Scene {
    let placed = Shape::ball(8, 0.0).placed([0.3, -0.2, 0.1], 2.0, 1.0);
    let inwards = placed.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    scene(placed.positions, inwards, Vec::new(), placed.center)
}

type Normals = fn(&mut Random, [f32; 3]) -> [f32; 3];

const NORMALS: &[(&str, Option<Normals>)] = &[
    ("flat shading", None),
    ("random normals", Some(|rng, _| rng.direction())),
    ("inverted normals", Some(|_, outward| outward)),
    ("normals that cancel", Some(|rng, n| if rng.below(2) == 0 { n } else { n.map(|x| -x) })),
    ("zero normals", Some(|_, _| [0.0; 3])),
];

/// Under a sky of 1e30: one path that leaves would show.
fn dark(name: &str, normals: Option<Normals>, samples: u64) -> Row {
    let mut scene = room();
    scene.environment = Some(Environment::Constant([1e30; 3]));
    scene.integrator.max_bounces = 16;
    if let Some(normal) = normals {
        let mut rng = Random::new(0xe3);
        let center = scene.camera.position;
        let outward = |p: &[f32; 3]| {
            let v = [0, 1, 2].map(|k| p[k] - center[k]);
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            v.map(|x| x / length)
        };
        scene.mesh.normals = scene.mesh.positions.iter().map(|p| normal(&mut rng, outward(p))).collect();
        scene.mesh.normal_indices = scene.mesh.triangles.clone();
        scene.mesh.normal_indices[0] = [NO_NORMAL; 3];
    }
    scene.film.width = 64;
    scene.film.height = 64;
    let brightest = |scene: &Scene, samples| {
        let film = film(scene, Width::native(), samples);
        values(&film).fold(0.0, f64::max) + film.discarded().count as f64
    };
    let found = brightest(&scene, samples);
    // That the sky would be seen: every seventh wall away.
    scene.mesh.triangles.iter_mut().step_by(7).for_each(|t| *t = [t[0]; 3]);
    let open = brightest(&scene, 1);
    let case = format!("dark inside under a sky of 1e30, {name}");
    Row::new(GROUP, case, 64 * 64 * samples, found, 0.0, "W/(sr m²)").naive(format!("with holes: {open:.0e}"))
}

/// ρ = .9999, cut at 10⁴ bounces, Le = 1 − ρ: 1 − ρ^10001 everywhere.
fn white_cavity(samples: u64) -> Row {
    const BOUNCES: u32 = 10_000;
    let mut scene = room();
    let rho = 0.9999f32;
    scene.materials[0].bsdf = Bsdf::Diffuse { reflectance: [rho; 3] };
    scene.materials[0].emission = [1.0 - rho; 3];
    scene.integrator.max_bounces = BOUNCES;
    let film = film(&scene, Width::native(), samples);
    let exact = 1.0 - f64::from(rho).powi(BOUNCES as i32 + 1);
    let pixels: Vec<f64> = values(&film).step_by(3).collect();
    let n = pixels.len() as f64;
    let mean = pixels.iter().sum::<f64>() / n;
    let variance = pixels.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
    let z = (mean - exact) / variance.sqrt();
    // Spec: |z| for a hundred tests at 1 % of false alarms together.
    let case = format!("white cavity, ρ .9999, 10⁴ bounces: {mean:.4}, exactly {exact:.4}");
    let paths = n as u64 * samples;
    let naive = capped_roulette(f64::from(rho), paths);
    Row::new(GROUP, case, paths, z.abs(), 3.889, "standard errors").naive(format!("survival ≤ .95: {naive:.4}"))
}

/// The same estimator where survival is capped whatever a path carries.
fn capped_roulette(rho: f64, paths: u64) -> f64 {
    let mut rng = Random::new(0xe5);
    let mut sum = 0.0;
    for _ in 0..paths {
        let mut beta = 1.0;
        for event in 1..=10_001 {
            sum += (1.0 - rho) * beta;
            beta *= rho;
            let survival = if event >= 5 { f64::min(beta, 0.95) } else { 1.0 };
            if f64::from(rng.unit()) >= survival {
                break;
            }
            beta /= survival;
        }
    }
    sum / paths as f64
}

/// A lit room with everything that has a length or a radiance: walls, a lamp, a sphere.
fn lit_room() -> Scene {
    let mut scene = room();
    scene.materials[0].bsdf = Bsdf::Diffuse { reflectance: [0.7, 0.5, 0.3] };
    let mut lamp = scene.materials[0].clone();
    lamp.emission = [3.0, 2.0, 1.0];
    scene.materials.push(lamp);
    scene.mesh.material[5] = 1;
    scene.mesh.material[77] = 1;
    scene.spheres.push(crate::scene::Sphere { center: [0.5, 0.1, -1.0], radius: 0.25, material: 1 });
    scene
}

fn brighter(scene: &mut Scene, k: i32) -> f64 {
    let factor = 2f32.powi(k);
    scene.materials.iter_mut().for_each(|m| m.emission = m.emission.map(|e| e * factor));
    f64::from(factor)
}

fn longer(scene: &mut Scene, k: i32) -> f64 {
    let factor = 2f32.powi(k);
    let camera = &mut scene.camera;
    let points = scene.mesh.positions.iter_mut().chain([&mut camera.position, &mut camera.look_at]);
    points.chain(scene.spheres.iter_mut().map(|s| &mut s.center)).flatten().for_each(|x| *x *= factor);
    scene.spheres.iter_mut().for_each(|s| s.radius *= factor);
    1.0
}

/// Values of the changed scene that are not the original's times what the change returns, at every width.
fn bits_kept(case: &str, samples: u64, powers: &[i32], change: fn(&mut Scene, i32) -> f64) -> Row {
    let (mut tried, mut wrong) = (0, 0);
    let expected: Vec<f64> = values(&film(&lit_room(), Width::One, samples)).collect();
    for &k in powers {
        for width in Width::ALL {
            let mut scene = lit_room();
            let factor = change(&mut scene, k);
            for (found, expected) in values(&film(&scene, width, samples)).zip(&expected) {
                tried += 1;
                wrong += u64::from(found != expected * factor);
            }
        }
    }
    Row::never(GROUP, case, tried, wrong, "values with other bits")
}
