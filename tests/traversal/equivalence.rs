//! The same bits in every mode, at every width, with any tree, whatever the other lanes hold.

use super::support::*;
use octolux::accel::{Accel, Brute, BuildOptions, Packet, Preset, Single, Stream};
use octolux::geometry::MISS;
use octolux::lane::{Real, f32x8, f32x16};

fn presets(shapes: &Shapes) -> [Accel; 3] {
    [Preset::Fast, Preset::Medium, Preset::Best].map(|preset| shapes.everything(preset))
}

/// From random points at random points or along axes, some nearly parallel to their neighbours (packets that stay
/// together), some short.
pub fn random_rays(n: usize, rng: &mut Random) -> Vec<OneRay> {
    let mut rays: Vec<OneRay> = Vec::new();
    for i in 0..n {
        let o = rng.point(1.9);
        let target = rng.point(1.5);
        let mut d = [0, 1, 2].map(|k| target[k] - o[k]);
        let mut o = o;
        if i % 64 >= 32 && i % 16 != 0 {
            let base = rays[i / 16 * 16];
            o = base.o;
            d = base.d.map(|x| x + 0.02 * rng.signed());
        }
        if i % 7 == 3 {
            d[rng.below(3)] = if rng.unit() < 0.5 { 0.0 } else { -0.0 };
        }
        if i % 29 == 3 {
            let keep = rng.below(3);
            d = [0, 1, 2].map(|k| if k == keep { rng.signed() } else { 0.0 });
        }
        let scale = [1.0, 1e-6, 1e6][i % 3];
        let t_max = if i % 5 == 0 { rng.unit() } else { f32::INFINITY };
        rays.push(OneRay { o, d: d.map(|x| x * scale), t_max: t_max / scale });
    }
    rays
}

#[test]
fn modes_widths_and_trees_agree() {
    let mut rng = Random::new(1);
    for (triangles, spheres, size) in
        [(1, 0, 0.5), (7, 3, 0.5), (9, 1, 0.4), (60, 20, 0.2), (700, 0, 0.1), (1500, 40, 0.05), (6000, 0, 0.03)]
    {
        let shapes = Shapes::random(triangles, spheres, size, &mut rng);
        let [fast, medium, best] = presets(&shapes);
        let [far, in_memory] = [false, true].map(|in_memory| medium.clone().walked_as_far(in_memory));
        let accels = [&fast, &medium, &best, &far, &in_memory];
        let rays = random_rays(4096, &mut rng);
        let found = ask_all(&accels, &rays);
        let hits = found.iter().filter(|(hit, _)| hit.1 != MISS).count();
        assert!(hits > 20, "{hits} of {} rays hit {triangles} triangles: the test would see nothing", rays.len());
    }
}

/// Nodes and blocks bit for bit: the binary tree and what is made of it are shared out among threads.
#[test]
fn the_tree_is_the_same_whatever_the_threads() {
    let shapes = Shapes::random(6000, 2500, 0.05, &mut Random::new(31));
    for preset in [Preset::Fast, Preset::Medium, Preset::Best] {
        let built = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let text = format!("{:?}", pool.install(|| shapes.build(BuildOptions::trees(preset))));
            // Before the trees is where the lists are aligned to, after them how many seconds it took.
            let (_, trees) = text.split_once("triangle_tree: ").unwrap();
            trees.split_once("report: ").unwrap().0.to_owned()
        });
        assert!(built[0].len() > 1_000_000, "{preset:?}: {} characters", built[0].len());
        assert!(built.iter().all(|tree| *tree == built[0]), "{preset:?}");
    }
}

/// Bundles through a thicket of slivers, which they pass the boxes of and seldom hit: a lane leaves its packet for more
/// children than it can keep, and the packet takes the rest with it.
#[test]
fn rays_that_pass_many_boxes() {
    let mut rng = Random::new(23);
    let mut shapes = Shapes::default();
    for i in 0..30_000 {
        let (a, d) = (rng.point(1.2), rng.point(0.2));
        let b = [0, 1, 2].map(|k| a[k] + d[k]);
        let width = if i % 5 == 0 { 1e-2 } else { 1e-6 };
        shapes.push([a, b, b.map(|x| x + width * rng.signed())]);
    }
    let accel = shapes.everything(Preset::Medium);
    let mut rays = Vec::new();
    for _ in 0..24 {
        let (o, target) = (rng.point(1.9), rng.point(1.0));
        for _ in 0..16 {
            let d = [0, 1, 2].map(|k| target[k] - o[k] + 0.08 * rng.signed());
            rays.push(OneRay { o, d, t_max: f32::INFINITY });
        }
    }
    let hits = ask_all(&[&accel], &rays).iter().filter(|(hit, _)| hit.1 != MISS).count();
    assert!(hits > 20 && hits < rays.len() - 20, "{hits} of {} hit: the test would see little", rays.len());
}

/// Bundles of short segments that end at what they would hit, one float before it or one after: any-hit packets in a list
/// are tested only against what is about their segments, which these touch from inside.
#[test]
fn segments_that_just_reach() {
    let mut rng = Random::new(41);
    let mut shapes = Shapes::random(40, 0, 0.2, &mut rng);
    for i in 0..24 {
        // Across an axis, so that its box is flat and the segments' box ends in it.
        let (axis, p) = (i % 3, rng.point(1.5));
        shapes.push([(); 3].map(|_| [0, 1, 2].map(|k| if k == axis { p[k] } else { p[k] + 0.3 * rng.signed() })));
    }
    let accel = shapes.everything(Preset::Medium);
    let mut rays = Vec::new();
    for bundle in 0..512 {
        let target = shapes.vertices(rng.below(64));
        let middle = [0, 1, 2].map(|k| (target[0][k] + target[1][k] + target[2][k]) / 3.0);
        let o = [0, 1, 2].map(|k| middle[k] + 0.2 * rng.signed());
        for i in 0..16 {
            let o = o.map(|x| x + 0.02 * rng.signed());
            let mut d = [0, 1, 2].map(|k| middle[k] - o[k] + 0.02 * rng.signed());
            if bundle % 4 == 1 {
                d[i % 3] = [0.0, -0.0][i % 2];
            }
            rays.push(OneRay { o, d, t_max: f32::INFINITY });
        }
    }
    let found = ask::<f32, Brute>(&accel, &rays, |_| true);
    for (i, (ray, (hit, _))) in rays.iter_mut().zip(found).enumerate() {
        let t = f32::from_bits(hit.0);
        ray.t_max = if hit.1 == MISS { 0.3 } else { [t, t.next_up(), t.next_down()][i % 3] };
    }
    let hits = ask_all(&[&accel], &rays).iter().filter(|(hit, _)| hit.1 != MISS).count();
    assert!(hits * 5 > rays.len() && hits * 2 < rays.len(), "{hits} of {} hit: the test would see little", rays.len());
}

/// Packets whose segments are about half of a list's triangles: neither so few that they are tested one after another, nor all.
/// Lists of several groups of vertices, of as many as have bits, and of one more.
#[test]
fn segments_that_are_about_half() {
    let mut rng = Random::new(43);
    for triangles in [5, 21, 22, 63, 64, 65] {
        let shapes = Shapes::random(triangles, 0, 0.4, &mut rng);
        let accel = shapes.everything(Preset::Medium);
        let mut rays = Vec::new();
        for _ in 0..256 {
            let middle = rng.point(0.3);
            for _ in 0..16 {
                let [o, end] = [(); 2].map(|_| middle.map(|x| x + rng.signed()));
                rays.push(OneRay { o, d: [0, 1, 2].map(|k| end[k] - o[k]), t_max: 1.0 });
            }
        }
        let hits = ask_all(&[&accel], &rays).iter().filter(|(hit, _)| hit.1 != MISS).count();
        assert!(hits > 40 && hits + 200 < rays.len(), "{hits} of {} hit: the test would see little", rays.len());
    }
}

/// As a camera sends them: packets that go through the tree together, some of their rays at vertices and along edges, some
/// that end early or are no use, at triangles of which some lie on others.
#[test]
fn packets_that_go_together() {
    let mut rng = Random::new(57);
    let mut shapes = Shapes::random(1200, 20, 0.08, &mut rng);
    for i in 0..300 {
        let [a, b, c] = shapes.vertices(4 * i);
        shapes.push([a, b, c]);
        // More than a block holds, for equals to be met in any order.
        (0..if i % 10 == 0 { 30 } else { 1 }).for_each(|_| shapes.push([b, c, a]));
    }
    let accel = shapes.everything(Preset::Medium);
    let mut rays = Vec::new();
    for bundle in 0..128 {
        // Every other bundle down one octant, the others wherever.
        let o = if bundle % 2 == 0 { [-1.9, -1.8, -1.7] } else { rng.point(1.9) };
        let target = shapes.vertices(4 * rng.below(300));
        for i in 0..64 {
            let (a, b) = (target[i % 3], target[(i + 1) % 3]);
            let s = [0.0, 0.5, 1.0, rng.unit()][i / 3 % 4];
            let off = if i % 2 == 0 { 0.0 } else { 0.05 };
            let d = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) - o[k] + off * rng.signed());
            let t_max = [f32::INFINITY, f32::INFINITY, 1.0, f32::NAN][rng.below(64) % if i % 16 < 14 { 2 } else { 4 }];
            rays.push(OneRay { o, d, t_max });
        }
    }
    let [far, in_memory] = [false, true].map(|in_memory| accel.clone().walked_as_far(in_memory));
    let hits = ask_all(&[&accel, &far, &in_memory], &rays).iter().filter(|(hit, _)| hit.1 != MISS).count();
    assert!(
        hits * 3 > rays.len() && hits < rays.len() - 200,
        "{hits} of {} hit: the test would see little",
        rays.len()
    );
}

/// A ray's answer does not depend on its lane, nor on what the other lanes hold.
#[test]
fn lanes_may_be_permuted() {
    let mut rng = Random::new(7);
    let shapes = Shapes::random(900, 30, 0.1, &mut rng);
    let accel = shapes.everything(Preset::Medium);
    let rays = random_rays(4096, &mut rng);
    let expected = ask_all(&[&accel], &rays);
    for _ in 0..4 {
        // Fisher and Yates.
        let mut order: Vec<usize> = (0..rays.len()).collect();
        (1..rays.len()).rev().for_each(|i| order.swap(i, rng.below(i + 1)));
        let permuted: Vec<OneRay> = order.iter().map(|&i| rays[i]).collect();
        let found = ask_all(&[&accel], &permuted);
        assert!(order.iter().zip(found).all(|(&i, found)| found == expected[i]));
    }
}

#[test]
fn only_spheres() {
    let mut rng = Random::new(2);
    let shapes = Shapes::random(0, 300, 0.0, &mut rng);
    let accels = presets(&shapes);
    let mut rays = random_rays(4096, &mut rng);
    for (i, ray) in rays.iter_mut().enumerate().filter(|(i, _)| i % 4 == 0) {
        ray.o = shapes.spheres[i % 300].0;
    }
    let found = ask_all(&accels.each_ref(), &rays);
    assert!(found.iter().filter(|(hit, _)| hit.1 != MISS).count() > 1000);
}

#[test]
fn dead_lanes_report_a_miss_and_change_nothing() {
    let mut rng = Random::new(3);
    let shapes = Shapes::random(600, 20, 0.1, &mut rng);
    let accel = shapes.everything(Preset::Medium);
    let rays = random_rays(4096, &mut rng);
    let reference = ask::<f32, Brute>(&accel, &rays, |_| true);
    let mut broken = rays.clone();
    let dead: Vec<bool> = rays.iter().map(|_| rng.unit() < 0.6).collect();
    for (i, ray) in broken.iter_mut().enumerate().filter(|(i, _)| dead[*i]) {
        // Whatever a dead lane holds.
        let bad = [f32::NAN, f32::INFINITY, 0.0, 1e38][i % 4];
        (ray.o[i % 3], ray.d) = (bad, [bad; 3]);
    }
    let check = |name: &str, got: Vec<(Found, bool)>| {
        for i in 0..rays.len() {
            let want = if dead[i] { (missed(&broken[i]), false) } else { reference[i] };
            assert_eq!(got[i], want, "{name}: ray {i}");
        }
    };
    check("brute 8", ask::<f32x8, Brute>(&accel, &broken, |i| !dead[i]));
    check("brute 16", ask::<f32x16, Brute>(&accel, &broken, |i| !dead[i]));
    check("single 1", ask::<f32, Single>(&accel, &broken, |i| !dead[i]));
    check("single 16", ask::<f32x16, Single>(&accel, &broken, |i| !dead[i]));
    check("stream 8", ask::<f32x8, Stream>(&accel, &broken, |i| !dead[i]));
    check("stream 16", ask::<f32x16, Stream>(&accel, &broken, |i| !dead[i]));
    check("packet 8", ask::<f32x8, Packet>(&accel, &broken, |i| !dead[i]));
    check("packet 16", ask::<f32x16, Packet>(&accel, &broken, |i| !dead[i]));
}

#[test]
fn unusable_rays_terminate_and_miss() {
    let mut rng = Random::new(4);
    let shapes = Shapes::random(600, 20, 0.1, &mut rng);
    let accel = shapes.everything(Preset::Medium);
    let good = random_rays(512, &mut rng);
    let mut rays = good.clone();
    let mut bad = vec![false; rays.len()];
    for i in (0..rays.len()).step_by(3) {
        let value = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][i / 3 % 3];
        match i / 9 % 4 {
            0 => rays[i].o[i / 3 % 3] = value,
            1 => rays[i].d[i / 3 % 3] = value,
            2 => rays[i].d = [0.0, -0.0, 0.0],
            _ => rays[i].t_max = [f32::NAN, 0.0, -1.0][i / 3 % 3],
        }
        bad[i] = true;
    }
    let found = ask_all(&[&accel], &rays);
    let untouched = ask::<f32, Single>(&accel, &good, |_| true);
    for i in 0..rays.len() {
        let want = if bad[i] { (missed(&rays[i]), false) } else { untouched[i] };
        assert_eq!(found[i], want, "ray {i} {:?}", rays[i]);
    }
}

#[test]
fn nothing_to_hit() {
    let shapes = Shapes::default();
    let accel = shapes.everything(Preset::Medium);
    let rays = random_rays(64, &mut Random::new(5));
    let found = ask_all(&[&accel], &rays);
    assert!(found.iter().zip(&rays).all(|(found, ray)| *found == (missed(ray), false)));
}

/// Far and huge numbers: every mode must still agree, whatever it finds.
#[test]
fn extreme_rays_agree() {
    let mut rng = Random::new(6);
    let shapes = Shapes::random(500, 20, 0.2, &mut rng);
    let accel = shapes.everything(Preset::Medium);
    let extreme = [0.0, -0.0, 1e-45, -1e-45, 1e-38, 1e-20, -1e20, 3e38, -3e38, 1.0, 0.5];
    let rays: Vec<_> = (0..8192)
        .map(|i| {
            let mut ray = OneRay { o: rng.point(1.9), d: rng.point(1.0), t_max: f32::INFINITY };
            ray.d[rng.below(3)] = extreme[rng.below(extreme.len())];
            ray.d[rng.below(3)] = extreme[rng.below(extreme.len())];
            if i % 4 == 0 {
                ray.o[rng.below(3)] = extreme[rng.below(extreme.len())];
            }
            ray
        })
        .collect();
    ask_all(&[&accel], &rays);
}

fn assert_width<R: Real>(width: usize) {
    assert_eq!(R::WIDTH, width);
}

#[test]
fn widths_are_what_the_names_say() {
    assert_width::<f32>(1);
    assert_width::<f32x8>(8);
    assert_width::<f32x16>(16);
}
