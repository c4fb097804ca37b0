//! From inside a closed mesh every ray hits, aimed within an ulp of an edge or a corner or anywhere, at any scale.

use super::random::{Random, nudge};
use super::rays::{Both, OneRay, Verdict, ask};
use super::shapes::{Placed, Shape};
use super::{Effort, Row, naive};
use crate::plan::GeometryMode;
use rayon::prelude::*;

const GROUP: &str = "watertight";
/// Rays a job takes.
const JOB: usize = 4096;

pub fn rows(effort: Effort) -> Vec<Row> {
    let ball = Shape::ball(10, 0.1);
    let origin = [0.0; 3];
    let far = [148_376.0, 1234.0, -223_423.0];
    let many = effort.pick(10_000, 100_000, 1_200_000);
    let powers: Vec<f64> = [-60, -45, -30, -15, 15, 30, 45, 60].map(|k| f64::from(k).exp2()).to_vec();
    let decimal = vec![1e-15, 1e15];
    let mut rows = Vec::new();
    for (place, center) in [("at the origin", origin), ("at (148376, 1234, −223423)", far)] {
        for (scales, list) in [("", vec![1.0]), (" × 2⁻⁶⁰ … 2⁶⁰", powers.clone()), (" × 1e±15", decimal.clone())]
        {
            let each = many / list.len();
            let case = format!("radius 2 {place}{scales}");
            let meshes = list.iter().map(|&scale| ball.placed(center, 2.0, scale));
            rows.push(measure(&case, meshes.collect(), each, aimed_at_edges));
        }
    }
    let grid: Vec<f64> = (-4..=4).map(|i| f64::from(i) / 4.0).collect();
    let cube = Shape::cube(&grid).placed(origin, 1.0, 1.0);
    rows.push(measure("cube, along axes, from its own planes", vec![cube], many, along_axes));
    for (name, width) in [("10⁶ : 1", 2e-6), ("10⁹ : 1", 2e-9)] {
        let slivers = Shape::cube(&[-1.0, 0.0, width, 1.0]).placed(origin, 1.0, 1.0);
        rows.push(measure(&format!("slivers {name}"), vec![slivers], many, aimed_at_edges));
    }
    rows
}

type Aim = fn(&Placed, &mut Random) -> [[f32; 3]; 2];

fn measure(case: &str, meshes: Vec<Placed>, each: usize, aim: Aim) -> Row {
    let mut total = Verdict::default();
    let (mut naive_misses, mut naive_rays) = (0u64, 0u64);
    for mesh in &meshes {
        let worlds = Both { lists: mesh.world(GeometryMode::Brute), tree: mesh.world(GeometryMode::Tree) };
        let scale = worlds.lists.unit.recip();
        let rays = |job: usize| -> Vec<OneRay> {
            let mut rng = Random::new(job as u64);
            let ray = |_| {
                let [o, target] = aim(mesh, &mut rng).map(|p| p.map(|x| x * scale));
                OneRay { o, d: [0, 1, 2].map(|k| target[k] - o[k]) }
            };
            (0..JOB.min(each - job * JOB)).map(ray).collect()
        };
        let verdict = |job: usize| ask(&worlds, &rays(job)).0;
        total = total.and((0..each.div_ceil(JOB)).into_par_iter().map(verdict).reduce(Verdict::default, Verdict::and));
        // The textbook test, on the first rays and the mesh as it was written.
        let first = rays(0);
        let triangles: Vec<_> = (0..mesh.triangles.len()).map(|i| mesh.vertices(i)).collect();
        naive_misses += first.iter().filter(|ray| !naive::moller_trumbore(ray, &triangles, scale)).count() as u64;
        naive_rays += first.len() as u64;
    }
    // Two questions differ from a miss only in what they would hide: both count.
    let row = Row::never(GROUP, case, total.rays, total.misses + total.unequal, "misses, or modes that disagree");
    row.at(total.first.unwrap_or_default())
        .naive(format!("Möller–Trumbore misses {:.2} %", 100.0 * naive_misses as f64 / naive_rays as f64))
}

/// Origin well inside, target within two ulp of an edge or (two of five) a corner.
fn aimed_at_edges(mesh: &Placed, rng: &mut Random) -> [[f32; 3]; 2] {
    let v = mesh.vertices(rng.below(mesh.triangles.len()));
    let reach = (0..3).map(|k| (v[0][k] - mesh.center[k]).abs()).fold(0.0, f32::max);
    let o = [0, 1, 2].map(|k| mesh.center[k] + 0.3 * reach * rng.signed());
    let s = if rng.unit() < 0.4 { 0.0 } else { rng.unit() };
    let edge = rng.below(3);
    let (a, b) = (v[edge], v[(edge + 1) % 3]);
    [o, [0, 1, 2].map(|k| nudge(a[k] + s * (b[k] - a[k]), rng.below(5) as i32 - 2))]
}

/// From planes that cut the faces, or an ulp beside them, with zero components of either sign.
fn along_axes(_: &Placed, rng: &mut Random) -> [[f32; 3]; 2] {
    let o = [(); 3].map(|_| nudge((rng.below(7) as f32 - 3.0) / 4.0, rng.below(3) as i32 - 1));
    let axis = rng.below(3);
    let d = [0, 1, 2].map(|k| if k == axis { 1.0 } else { 0.25 * (rng.below(3) as f32 - 1.0) });
    let keep = rng.below(8);
    let sign = if rng.below(2) == 0 { 1.0 } else { -1.0 };
    // The difference target − o is zero, of either sign, where the component is left out.
    let target = [0, 1, 2].map(|k| if k == axis || keep >> k & 1 == 1 { o[k] + sign * d[k] } else { o[k] });
    [o, target]
}
