//! Micro-benchmarks of what the kernel is made of, at widths 1, 8 and 16; throughput in elements (lanes, rays, samples).
//!
//! `cargo bench` runs all; `cargo bench -- triangle` those whose name holds the word. Pin it: `taskset -c 1 cargo bench`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use octolux::accel::{Accel, Brute, BuildOptions, Mode, Packet, Preset, Single};
use octolux::bsdf::{Conductor, ConductorFresnel, Dielectric, Diffuse, Model};
use octolux::geometry::{Ray, RaySetup};
use octolux::kernel::{Prepare, Width, World};
use octolux::lane::{Mask, Real, Vec3, f32x8, f32x16};
use octolux::plan::{Force, Plan};
use octolux::render::{self, Budget, Options, Progress};
use octolux::sampling::Xoshiro;
use octolux::scene;
use std::hint::black_box;

/// Packets of inputs a benchmark goes through, so that it does not time one predicted case.
const PACKETS: usize = 256;

/// Runs `f` on each packet, which holds `R::WIDTH` elements.
fn packets<R: Real, T>(c: &mut Criterion, name: &str, inputs: &[T], mut f: impl FnMut(&T) -> R) {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements((inputs.len() * R::WIDTH) as u64));
    group.bench_function(format!("{} lanes", R::WIDTH), |b| {
        b.iter(|| inputs.iter().fold(R::zero(), |sum, input| sum + f(black_box(input))))
    });
    group.finish();
}

fn random<R: Real>(seed: u64) -> Xoshiro<R> {
    Xoshiro::from_keys(|lane| seed * 1000 + lane as u64)
}

/// Rays from inside the unit cube in all directions.
fn incoherent_rays<R: Real>(seed: u64) -> Vec<Ray<R>> {
    let mut rng = random::<R>(seed);
    let mut signed = move || rng.next_unit() * R::splat(2.0) - R::one();
    let mut vector = move || Vec3::new(signed(), signed(), signed());
    (0..PACKETS).map(|_| Ray::new(vector() * R::splat(0.9), vector().normalize(), R::splat(f32::INFINITY))).collect()
}

/// Rays from one eye through neighbouring pixels.
fn coherent_rays<R: Real>() -> Vec<Ray<R>> {
    let eye = Vec3::splat([0.0, 1.5, 1.5]);
    let ray = |i: usize| {
        let x = R::from_fn(|lane| ((i % 16) * 4 + lane % 4) as f32 / 64.0 - 0.5);
        let z = R::from_fn(|lane| ((i / 16) * 4 + lane / 4) as f32 / 64.0 - 0.5);
        Ray::new(eye, (Vec3::new(x, R::splat(0.0), z) - eye).normalize(), R::splat(f32::INFINITY))
    };
    (0..PACKETS).map(ray).collect()
}

/// A rolling height field of 2·n² triangles over [-1, 1]².
fn terrain(n: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let height = |x: f32, z: f32| 0.1 * (7.0 * x).sin() * (5.0 * z).cos() + 0.02 * (41.0 * x + 3.0 * z).sin();
    let at = |i: usize| i as f32 / n as f32 * 2.0 - 1.0;
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| [at(i), height(at(i), at(j)), at(j)])).collect();
    let corner = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    let cell = |i: usize, j: usize| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, c, b], [a, d, c]]
    };
    (vertices, (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect())
}

fn primitives<R: Real>(c: &mut Criterion) {
    let rays: Vec<RaySetup<R>> = incoherent_rays::<R>(1).iter().map(RaySetup::new).collect();
    packets::<R, _>(c, "slab", &rays, |setup| {
        let (near, far) = setup.slab([R::splat(-0.5); 3], [R::splat(0.5); 3]);
        near + far
    });
    packets::<R, _>(c, "random number", &[(); PACKETS], {
        let mut rng = random::<R>(2);
        move |_| rng.next_unit()
    });
    let (vertices, triangles) = terrain(4);
    let few = Accel::build(&vertices, &triangles, &[], BuildOptions::lists());
    let all = R::Mask::splat(true);
    // 32 triangles a ray: divide the time by 32 for one test.
    packets::<R, _>(c, "triangle x32 (brute force)", &incoherent_rays::<R>(3), |ray| few.trace::<R, Brute>(ray, all).t);
}

fn scattering<R: Real>(c: &mut Criterion) {
    let mut rng = random::<R>(4);
    let inputs: Vec<_> = (0..PACKETS)
        .map(|_| {
            let wo = octolux::sampling::warp::cosine_hemisphere([rng.next_unit(), rng.next_unit()]);
            let wi = octolux::sampling::warp::cosine_hemisphere([rng.next_unit(), rng.next_unit()]);
            (wo, wi, rng.next_unit(), [rng.next_unit(), rng.next_unit()])
        })
        .collect();
    let separable = R::Mask::splat(false);
    let fresnel = ConductorFresnel::exact(Vec3::splat([0.2, 0.9, 1.1]), Vec3::splat([3.9, 2.4, 2.1]));
    let conductor = Conductor { alpha: R::splat(0.2), separable, fresnel };
    let dielectric = Dielectric { alpha: R::splat(0.2), separable, ior: R::splat(1.5) };
    let diffuse = Diffuse { reflectance: Vec3::splat([0.5; 3]) };
    macro_rules! model {
        ($name:literal, $bsdf:expr) => {
            packets::<R, _>(c, concat!($name, " eval"), &inputs, |(wo, wi, _, _)| {
                let eval = $bsdf.eval(*wo, *wi);
                eval.value.x + eval.pdf
            });
            packets::<R, _>(c, concat!($name, " sample"), &inputs, |(wo, _, lobe, u)| {
                let sample = $bsdf.sample(*wo, *lobe, *u);
                sample.weight.x + sample.wi.x + sample.pdf
            });
        };
    }
    model!("diffuse", diffuse);
    model!("conductor", conductor);
    model!("dielectric", dielectric);
}

fn traversal<R: Real>(c: &mut Criterion) {
    let (vertices, triangles) = terrain(256);
    let accel = Accel::build(&vertices, &triangles, &[], BuildOptions::trees(Preset::default()));
    fn both<R: Real, M: Mode>(c: &mut Criterion, accel: &Accel, name: &str, rays: &[Ray<R>]) {
        let all = R::Mask::splat(true);
        packets::<R, _>(c, &format!("closest hit, {name}"), rays, |ray| accel.trace::<R, M>(ray, all).t);
        packets::<R, _>(c, &format!("any hit, {name}"), rays, |ray| R::one().masked(accel.occluded::<R, M>(ray, all)));
    }
    both::<R, Packet>(c, &accel, "coherent rays, packets", &coherent_rays::<R>());
    both::<R, Single>(c, &accel, "coherent rays, single", &coherent_rays::<R>());
    both::<R, Packet>(c, &accel, "incoherent rays, packets", &incoherent_rays::<R>(5));
    both::<R, Single>(c, &accel, "incoherent rays, single", &incoherent_rays::<R>(5));
}

fn whole_paths(c: &mut Criterion) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell/scene.toml");
    let scene = scene::load(&path).expect("the repository's own Cornell box");
    let world =
        World::new(&scene, Plan::new(&scene, Force::default(), false), Prepare::default()).expect("it has lights");
    let pool = render::pinned_thread_pool(2).expect("two threads");
    let mut group = c.benchmark_group("whole paths, Cornell box, 2 threads");
    let samples = 4;
    group.throughput(Throughput::Elements(world.film.width as u64 * world.film.height as u64 * samples));
    group.sample_size(10);
    for width in Width::ALL {
        let budget = Budget { samples: Some(samples), ..Budget::default() };
        let options = Options { budget, width, tile: 16, aovs: false, output_seconds: 0.0, adaptive: false };
        group.bench_function(format!("{} lanes", width.lanes()), |b| {
            b.iter(|| render::render(&world, &options, &pool, &mut Progress::quiet()).counters)
        });
    }
    group.finish();
}

fn all_widths(c: &mut Criterion) {
    fn at<R: Real>(c: &mut Criterion) {
        primitives::<R>(c);
        scattering::<R>(c);
        traversal::<R>(c);
    }
    at::<f32>(c);
    at::<f32x8>(c);
    at::<f32x16>(c);
    whole_paths(c);
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1));
    targets = all_widths
}
criterion_main!(benches);
