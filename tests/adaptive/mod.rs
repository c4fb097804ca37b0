//! Adaptive sampling: samples go where they help, add no bias, and leave no trace of threads or lanes.
//!
//! Most tests render by a kernel of their own, whose samples have a known mean.

use crate::equivalence::{assert_same, scenes};
use crate::renders::{self, Set, adaptive, adaptive_on};
use crate::stats;
use octolux::kernel::{Counters, Job, SampleBuffer, Width, World};
use octolux::process::seconds_since_process_start;
use octolux::render::{Budget, thread_pool};
use octolux::sampling::{SamplerKind, sample_key};
use octolux::scene::{Bsdf, Camera, FilmSize, LightPaths, PathReuse, Scene, SceneBuilder};
use std::time::Duration;

const SIDE: u32 = 32;
/// Of the tiles that samples are divided among, where paths bounce.
const TILE: u32 = 4;

/// What is rendered does not matter to the kernels below: only its size does.
fn frame() -> Scene {
    let mut scene = SceneBuilder::new(Camera::towards([0.0, 1.0, 5.0], [0.0, 1.0, 0.0], 40.0), SIDE, SIDE);
    let clay = scene.material(Bsdf::Diffuse { reflectance: [0.5; 3] });
    scene.sphere([0.0, 1.0, 0.0], 1.0, clay);
    scene.environment([1.0; 3]);
    let mut scene = scene.build().expect("a ball under a sky");
    scene.integrator.path_reuse = PathReuse::Off;
    scene
}

/// A kernel whose sample is a function of the column and a number in [0, 1) of its own.
fn kernel(value: impl Fn(u32, f64) -> f32 + Sync) -> impl Fn(&World, &Job, &mut SampleBuffer, &mut Counters) + Sync {
    move |world, job, out, counters| {
        let mut slots = out.rgb.iter_mut();
        for y in job.y..job.y + job.height {
            for x in job.x..job.x + job.width {
                for (sample, rgb) in (job.first_sample..job.first_sample + job.samples).zip(&mut slots) {
                    let u = (sample_key(world.seed, y * SIDE + x, sample) >> 11) as f64 * f64::exp2(-53.0);
                    *rgb = [value(x, u); 3];
                    counters.camera_rays += 1;
                }
            }
        }
    }
}

/// Mean 1: one in 20 samples holds it all, in the right half alone.
fn rare_on_the_right(x: u32, u: f64) -> f32 {
    if x < SIDE / 2 {
        1.0
    } else if u < 0.05 {
        20.0
    } else {
        0.0
    }
}

#[test]
fn noisy_tiles_have_more_samples_and_the_average_is_what_was_asked_for() {
    let world = renders::world(&frame(), 3);
    let outcome = adaptive(&world, 256, Width::native(), Some(&kernel(rare_on_the_right)));
    let report = outcome.adaptive.expect("256 samples are enough for a pilot");
    let at = |x: u32, y: u32| outcome.film.pixel(x, y).samples;
    // Tiles of the left that are next to the right are told that it is noisy there.
    let quiet = SIDE / 2 - TILE;
    assert!((0..SIDE).all(|y| (0..quiet).all(|x| 2 * at(x, y) <= at(SIDE - 1 - x, y))), "quiet tiles have fewer");
    assert!((0..SIDE).all(|y| (0..SIDE).all(|x| at(x, y).is_power_of_two() && at(x, y) >= 64)), "powers of two");
    let all = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let sum: u64 = all().map(|(x, y)| at(x, y)).sum();
    let mean = sum as f64 / f64::from(SIDE * SIDE);
    assert_eq!(mean, report.mean);
    assert!((0.9 * 256.0..=256.0).contains(&mean), "{mean} samples on average where 256 were asked for");
    let most = all().map(|(x, y)| at(x, y)).max().expect("pixels");
    assert_eq!((report.pilot_samples, report.least, report.most), (64, at(0, 0), most));
    assert_eq!(outcome.counters.camera_rays, sum, "the pilot's samples are the image's first");
}

/// What a tile's pixels find and what it costs leaves no trace in its number of samples, nor in those of any tile of its colour:
/// given the numbers, its samples are as among equal numbers.
#[test]
fn no_tile_decides_on_itself() {
    let world = renders::world(&frame(), 3);
    // More noise to the right, more below, and in one tile far more, at far fewer rays.
    let numbers = |loud: Option<(u32, u32)>| {
        let noise = kernel(|x, u| if u < 0.5 { 0.0 } else { f32::exp2(0.2 * x as f32) });
        let outcome = adaptive(
            &world,
            64,
            Width::native(),
            Some(&|world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters| {
                noise(world, job, out, counters);
                let tile = (job.x / TILE, job.y / TILE);
                assert!(job.width <= TILE && job.height <= TILE, "a job of several tiles counts rays of both colours");
                for rgb in &mut out.rgb {
                    *rgb = rgb.map(|value| 1.0 + 0.1 * tile.1 as f32 * value);
                }
                if Some(tile) == loud {
                    // A flash in each half of the pilot's groups.
                    for (k, rgb) in out.rgb.iter_mut().enumerate() {
                        *rgb = [if k % 8 == 3 { 1e4 } else { 0.0 }; 3];
                    }
                } else {
                    counters.bounce_rays += 9 * job.slots() as u64;
                }
            }),
        );
        (0..SIDE / TILE)
            .flat_map(|j| (0..SIDE / TILE).map(move |i| (i, j)))
            .map(|(i, j)| ((i, j), outcome.film.pixel(i * TILE, j * TILE).samples))
            .collect::<Vec<_>>()
    };
    let usual = numbers(None);
    let kinds = usual.iter().map(|(_, n)| n).collect::<std::collections::BTreeSet<_>>();
    assert!(kinds.len() > 2, "nothing is divided: {kinds:?}");
    for loud in [(0, 0), (3, 2), (7, 7), (4, 7)] {
        let found = numbers(Some(loud));
        let (mut same, mut others) = (0, 0);
        for ((tile, was), (_, is)) in usual.iter().zip(&found) {
            if (tile.0 + tile.1) % 2 == (loud.0 + loud.1) % 2 {
                assert_eq!(was, is, "tile {tile:?} by what {loud:?} finds");
                same += 1;
            } else {
                others += u32::from(was != is);
            }
        }
        assert!(same == 32 && others > 0, "the tiles beside {loud:?} are told nothing of it");
    }
}

/// A row of four tiles, of which the first is told of nothing but black, and the halves of the pilot agree: it has the least, and the
/// third not.
#[test]
fn a_tile_beside_black_takes_nothing_from_others() {
    let mut scene = frame();
    scene.film = FilmSize { width: 4 * TILE, height: TILE };
    let world = renders::world(&scene, 1);
    let noisy = kernel(|x, u| if x / TILE == 1 { 0.0 } else { u as f32 });
    let film = adaptive(&world, 64, Width::native(), Some(&noisy)).film;
    let samples = [0, 2].map(|tile| film.pixel(tile * TILE, 0).samples);
    assert_eq!(samples, [16, 64]);
}

/// Mean of the right half of so many samples a pixel, and its standard error over seeds, for 1.
fn right_half(
    seeds: u64,
    samples: u64,
    kernel: &(impl Fn(&World, &Job, &mut SampleBuffer, &mut Counters) + Sync),
) -> [f64; 2] {
    let mut world = renders::world(&frame(), 0);
    let (mut sum, mut squares) = (0.0, 0.0);
    for seed in 1..=seeds {
        world.seed = seed;
        let film = adaptive(&world, samples, Width::native(), Some(kernel)).film;
        let right = (0..SIDE).flat_map(|y| (SIDE / 2..SIDE).map(move |x| (x, y)));
        let mean = right.map(|(x, y)| film.mean(x, y)[0]).sum::<f64>() / f64::from(SIDE * SIDE / 2);
        sum += mean;
        squares += mean * mean;
    }
    let n = seeds as f64;
    let variance = (squares - sum * sum / n) / (n - 1.0);
    println!("mean {:.5} ± {:.5} for 1", sum / n, (variance / n).sqrt());
    [sum / n, (variance / n).sqrt()]
}

#[test]
fn dividing_samples_adds_no_bias() {
    let bound = stats::z_bound(3);
    for (seeds, samples) in [(400, 32), (1600, 8)] {
        let [mean, error] = right_half(seeds, samples, &kernel(rare_on_the_right));
        assert!((mean - 1.0).abs() <= bound * error, "{samples} samples: mean {mean} ± {error} for 1");
    }
    // Were the tiles next to each other one, so that a tile in which the pilot found nothing had few samples and kept that mean,
    // it would be seen.
    let together = |world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters| {
        let mut slots = out.rgb.iter_mut();
        for (y, x) in (job.y..job.y + job.height).flat_map(|y| (job.x..job.x + job.width).map(move |x| (y, x))) {
            for (sample, rgb) in (job.first_sample..job.first_sample + job.samples).zip(&mut slots) {
                let tiles = y / (2 * TILE) * SIDE + x / (2 * TILE);
                let u = (sample_key(world.seed, tiles, sample) >> 11) as f64 * f64::exp2(-53.0);
                *rgb = [rare_on_the_right(x, u); 3];
                counters.camera_rays += 1;
            }
        }
    };
    let [mean, error] = right_half(1600, 32, &together);
    assert!(mean < 1.0 - bound * error, "a bias of a tile that decides on itself is not seen: {mean} ± {error}");
}

#[test]
fn a_pilot_that_tells_nothing_is_not_believed() {
    // The same everywhere, and rare: what a pilot finds more of in one tile is chance.
    let rare = kernel(|_, u| if u < 0.01 { 100.0 } else { 0.0 });
    let report = adaptive(&renders::world(&frame(), 5), 64, Width::native(), Some(&rare)).adaptive.expect("a pilot");
    assert!(report.least >= 32 && report.most <= 128, "{report:?}");
    // Nothing to find at all.
    let quiet = kernel(|_, _| 0.5);
    let report = adaptive(&renders::world(&frame(), 5), 64, Width::native(), Some(&quiet)).adaptive.expect("a pilot");
    assert_eq!((report.least, report.most, report.bias), (64, 64, 0.0));
}

#[test]
fn the_bias_that_is_reported_is_one() {
    let world = renders::world(&frame(), 7);
    let report = |kernel| adaptive(&world, 256, Width::native(), Some(kernel)).adaptive.expect("a pilot");
    let honest = kernel(rare_on_the_right);
    let fair = report(&honest);
    assert!(fair.bias.abs() <= 1.5 * fair.bias_half_width, "{fair:?}");
    // Samples beyond the pilot's that are half as bright again.
    let skewed = |world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters| {
        honest(world, job, out, counters);
        for (slot, rgb) in out.rgb.iter_mut().enumerate() {
            if u64::from(job.first_sample) + slot as u64 % u64::from(job.samples) >= 64 {
                *rgb = rgb.map(|value| 1.5 * value);
            }
        }
    };
    let outcome = adaptive(&world, 256, Width::native(), Some(&skewed));
    let found = outcome.adaptive.expect("a pilot");
    let beyond = |x, y| 1.0 - 64.0 / outcome.film.pixel(x, y).samples as f64;
    let sum: f64 = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))).map(|(x, y)| beyond(x, y)).sum();
    let expected = 0.5 * sum / f64::from(SIDE * SIDE);
    assert!(
        (found.bias - expected).abs() <= 1.5 * found.bias_half_width && found.bias > 2.0 * found.bias_half_width,
        "{found:?}, {expected} expected"
    );
}

/// In an image of one tile the pilot's four groups have three degrees of freedom: with the normal factor 1.96 the interval would
/// hold 0 in 89 %. (It is one for the pilot's mean alone. That a quarter of the image is the pilot takes a quarter of the variance
/// away: 96.6 %.)
#[test]
fn the_interval_of_the_bias_holds_as_often_as_it_says() {
    let mut scene = frame();
    scene.film = FilmSize { width: TILE, height: TILE };
    const SEEDS: u64 = 500;
    let held = (0..SEEDS).filter(|&seed| {
        let world = renders::world(&scene, seed);
        let outcome = adaptive(&world, 64, Width::native(), Some(&kernel(|_, u| u as f32)));
        let report = outcome.adaptive.expect("64 samples are enough for a pilot");
        report.bias.abs() <= report.bias_half_width
    });
    let share = held.count() as f64 / SEEDS as f64;
    let error = (0.95f64 * 0.05 / SEEDS as f64).sqrt();
    assert!((share - 0.95).abs() < 4.0 * error, "{share} for .95 ± {error}");
}

/// Tiles of pixels whose errors are one: the interval of the bias knows.
#[test]
fn the_interval_of_the_bias_holds_where_pixels_share_their_errors() {
    const SEEDS: u64 = 60;
    let blocks = |world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters| {
        let mut slots = out.rgb.iter_mut();
        for (y, x) in (job.y..job.y + job.height).flat_map(|y| (job.x..job.x + job.width).map(move |x| (y, x))) {
            for (sample, rgb) in (job.first_sample..job.first_sample + job.samples).zip(&mut slots) {
                let key = sample_key(world.seed, y / TILE * SIDE + x / TILE, sample);
                *rgb = [2.0 * (key >> 40) as f32 / (1u32 << 24) as f32; 3];
                counters.camera_rays += 1;
            }
        }
    };
    let mut world = renders::world(&frame(), 0);
    let holds = (1..=SEEDS).filter(|&seed| {
        world.seed = seed;
        let report = adaptive(&world, 64, Width::native(), Some(&blocks)).adaptive.expect("a pilot");
        report.bias.abs() <= report.bias_half_width
    });
    let share = holds.count() as f64 / SEEDS as f64;
    println!("{share:.2} of the intervals of 95 % hold");
    assert!(share > 0.8, "{share:.2} of the intervals hold");
}

#[test]
fn too_few_samples_are_not_divided() {
    let outcome = adaptive(&renders::world(&frame(), 1), 4, Width::native(), Some(&kernel(rare_on_the_right)));
    assert!(outcome.adaptive.is_none() && !outcome.film.is_uneven() && outcome.film.samples() == 4);
}

/// A quarter of the samples is the pilot, by powers of two; of few samples four, a sample a group.
#[test]
fn the_pilot_takes_its_share() {
    for (samples, pilot) in [(5, 4), (8, 4), (16, 4), (32, 8), (63, 8), (64, 16), (128, 32), (2048, 256)] {
        let outcome =
            adaptive(&renders::world(&frame(), 1), samples, Width::native(), Some(&kernel(rare_on_the_right)));
        assert_eq!(outcome.adaptive.expect("a pilot").pilot_samples, pilot, "{samples} samples");
    }
}

/// However little time there is for the pilot and after it, no tile is left black.
#[test]
fn no_tile_is_left_without_a_sample() {
    let world = renders::world(&frame(), 2);
    let fast = kernel(rare_on_the_right);
    let slow = |world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters| {
        std::thread::sleep(Duration::from_micros(20) * job.slots() as u32);
        fast(world, job, out, counters);
    };
    for k in 1..=20 {
        let seconds = seconds_since_process_start() + 0.02 * f64::from(k);
        let budget = Budget { seconds: Some(seconds), ..Budget::default() };
        let film = renders::adaptive_by(&world, budget, &slow).film;
        assert!(film.samples() > 0, "{k}: on average {}, but somewhere none", film.mean_samples());
    }
}

/// A white floor below a lamp as bright as single precision can have it: sometimes too many light paths come to one pixel. What they
/// bring that is no number is counted as beside equal samples.
#[test]
fn what_light_paths_bring_that_is_no_number_is_counted() {
    let mut set = Set::new([0.0, 0.4, 1.5], [0.0, 0.0, 0.0], 30.0, 8).bounces(2);
    let (white, lamp) = (set.grey(1.0, 0.0), set.grey(0.0, 3.4e38));
    set.quad(white, [[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]]);
    set.quad(lamp, [[-2.0, 0.5, -2.0], [2.0, 0.5, -2.0], [2.0, 0.5, 2.0], [-2.0, 0.5, 2.0]]);
    let mut scene = set.finish();
    scene.integrator.light_paths = LightPaths::On;
    let world = renders::world(&scene, 3);
    let one = kernel(|_, _| 1.0);
    let budget = Budget { samples: Some(256), ..Budget::default() };
    let divided = renders::adaptive_by(&world, budget, &one);
    let even = renders::even_by(&world, budget, &one);
    let (found, expected) = (divided.film.discarded(), even.film.discarded());
    println!("{} samples discarded", expected.count);
    assert!(divided.adaptive.is_some() && expected.count > 0);
    assert_eq!(found, expected);
}

#[test]
fn lanes_and_threads_leave_no_trace() {
    for sampler in [SamplerKind::SobolPixels, SamplerKind::Independent] {
        // Without shared paths, whose tiles would be few.
        let mut scene = scenes::everything();
        scene.integrator.path_reuse = PathReuse::Off;
        let world = renders::sampled(&scene, 4, Default::default(), sampler);
        let alone = thread_pool(1).expect("a thread");
        let expected = adaptive_on(&alone, &world, 64, Width::One, None);
        assert!(expected.film.is_uneven(), "the scene has tiles that want more");
        for (threads, width) in [(2, Width::One), (1, Width::Eight), (3, Width::Sixteen)] {
            let pool = thread_pool(threads).expect("threads");
            let found = adaptive_on(&pool, &world, 64, width, None);
            assert_same(&format!("{threads} threads, {} lanes", width.lanes()), &found.film, &expected.film);
        }
    }
}

/// Pixels of radiance 1: on the left all over, on the right as the mean of a spot that a sample in 47 finds.
fn spots() -> Scene {
    let mut set = Set::new([0.0; 3], [0.0, 0.0, -1.0], 90.0, 16).bounces(0);
    let (even, spot) = (set.grey(0.0, 1.0), set.grey(0.0, 64.0 / (1.1 * 1.25)));
    // Eighths of a pixel, from its lower left corner.
    let mut quad = |material, [x, y]: [u32; 2], [left, low, right, high]: [f64; 4]| {
        let at = |pixel: u32, eighths: f64| (f64::from(pixel) + eighths / 8.0) / 8.0 - 1.0;
        let (l, b, r, t) = (at(x, left), at(y, low), at(x, right), at(y, high));
        set.quad(material, [[l, b, -1.0], [r, b, -1.0], [r, t, -1.0], [l, t, -1.0]]);
    };
    for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
        if x < 8 {
            quad(even, [x, y], [0.0, 0.0, 8.0, 8.0]);
        } else {
            quad(spot, [x, y], [2.3, 3.1, 3.4, 4.35]);
        }
    }
    set.finish()
}

/// Tiles of one block decide on each other, so they must have numbers of their own: by one scrambling, where a neighbour's hit says
/// that there is none here, the right half is .4 % too bright (11 standard errors over 3000 seeds; not told apart by 16 samples).
#[test]
fn tiles_of_a_block_add_no_bias_to_each_other() {
    let world = renders::sampled(&spots(), 0, Default::default(), SamplerKind::Sobol);
    assert!(world.needs_equal_samples().is_some_and(|why| why.contains("sobol-pixels")));
    let mut world = world.with_tiles_apart();
    assert_eq!((world.needs_equal_samples(), world.sampler), (None, SamplerKind::SobolPixels));
    let means: stats::Moments = (0..1000)
        .map(|seed| {
            world.seed = seed;
            let film = adaptive(&world, 64, Width::native(), None).film;
            assert!(film.is_uneven(), "the samples are divided");
            let right = (0..16).flat_map(|y| (8..16).map(move |x| (x, y)));
            right.map(|(x, y)| film.mean(x, y)[0]).sum::<f64>() / 128.0
        })
        .collect();
    stats::assert_mean("spots", &means, 1.0, 1e-5, 1);
}

#[test]
#[should_panic(expected = "sobol-pixels")]
fn tiles_of_one_scrambling_are_not_divided() {
    let world = renders::sampled(&spots(), 0, Default::default(), SamplerKind::Sobol);
    adaptive(&world, 64, Width::native(), None);
}
