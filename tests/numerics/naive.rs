//! The textbook forms that the catalogue's own table does not print, in f32 and on the inputs that break them, beside ours. What
//! they give stands at each.

use crate::stats::Rng;
use octolux::accel::{Accel, Brute, BuildOptions};
use octolux::check::numerics::shapes::Shape;
use octolux::geometry::{MISS, Ray, slab};
use octolux::kernel::mis_weight;
use octolux::lane::{Bits, Mask, Real, Vec3, f32x8};
use octolux::light::{Emitter, EmitterShape, Lights};
use octolux::sampling::Frame;

type P = [f32; 3];

fn sub(a: P, b: P) -> P {
    std::array::from_fn(|k| a[k] - b[k])
}
fn cross(a: P, b: P) -> P {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn dot(a: P, b: P) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn hits(accel: &Accel, o: P, d: P) -> bool {
    let ray = Ray::<f32>::new(Vec3::splat(o), Vec3::splat(d), f32::INFINITY);
    accel.trace::<f32, Brute>(&ray, true).primitive.lane(0) != MISS
}

/// Woop, Benthin and Wald's test with its edge functions as `edge`.
fn woop(v: [P; 3], o: P, d: P, edge: fn([f32; 2], [f32; 2]) -> f32) -> bool {
    let z = (0..3).max_by(|&a, &b| d[a].abs().total_cmp(&d[b].abs())).expect("three axes");
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let v_depth = v.map(|p| p[z]);
    let [a, b, c] = v.map(|p| {
        let p = sub(p, o);
        [p[x] - d[x] / d[z] * p[z], p[y] - d[y] / d[z] * p[z]]
    });
    let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
    // The far side of a closed mesh is behind the origin.
    let depth = |i: usize| (v_depth[i] - o[z]) / d[z];
    let ahead = (u * depth(0) + v * depth(1) + w * depth(2)) * (u + v + w) > 0.0;
    ahead && ((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0))
}

/// One fused multiply-add in an edge function, and the edge that two triangles share is on neither of them in .6 % of rays
/// (4.5 % of those aimed within an ulp); with plain products in none.
#[test]
fn a_fused_multiply_add_opens_the_edges() {
    let mesh = Shape::ball(10, 0.1).placed([0.0; 3], 1.0, 1.0);
    let accel = Accel::build(&mesh.positions, &mesh.triangles, &[], BuildOptions::lists());
    let mut rng = Rng::new(71);
    let (mut fused, mut plain) = (0, 0);
    const RAYS: usize = 20_000;
    for _ in 0..RAYS {
        let v = mesh.vertices((rng.u64() % mesh.triangles.len() as u64) as usize);
        let s = rng.f32();
        let o: P = std::array::from_fn(|_| 0.6 * rng.f32() - 0.3);
        let d = sub(std::array::from_fn(|k| v[0][k] + s * (v[1][k] - v[0][k])), o);
        let any = |edge| (0..mesh.triangles.len()).any(|i| woop(mesh.vertices(i), o, d, edge));
        fused += usize::from(!any(|a, b| a[0].mul_add(b[1], -(a[1] * b[0]))));
        plain += usize::from(!any(|a, b| a[0] * b[1] - a[1] * b[0]));
        assert!(hits(&accel, o, d));
    }
    println!("misses of {RAYS}: fused {fused}, plain {plain}");
    assert!(plain == 0 && fused > RAYS / 1000, "{fused} {plain}");
}

/// An absolute bound on the determinant (1e-8, Möller & Trumbore 1997): a triangle with edges of 5e-5 is not there, from
/// wherever one looks; ours is.
#[test]
fn small_triangles_do_not_vanish() {
    let v = [[0.3f32, 0.2, 0.5], [0.300_05, 0.2, 0.5], [0.3, 0.200_05, 0.500_02]];
    let accel = Accel::build(&v, &[[0, 1, 2]], &[], BuildOptions::lists());
    let (e1, e2) = (sub(v[1], v[0]), sub(v[2], v[0]));
    let centre: P = std::array::from_fn(|k| (v[0][k] + v[1][k] + v[2][k]) / 3.0);
    let mut rng = Rng::new(72);
    for _ in 0..1000 {
        let o: P =
            std::array::from_fn(|k| centre[k] + if k == 2 { 0.2 + 0.5 * rng.f32() } else { 0.2 * rng.f32() - 0.1 });
        let d = sub(centre, o);
        let length = dot(d, d).sqrt();
        assert!(dot(e1, cross(d.map(|x| x / length), e2)).abs() < 1e-8);
        assert!(hits(&accel, o, d));
    }
}

/// Frisvad's frame (2012) just above n = −z, where 1 + z has lost its digits: off by tenths; Duff et al. (2017) by ulps.
#[test]
fn frames_near_the_south_pole() {
    let (mut theirs, mut ours) = (0.0f64, 0.0f64);
    let mut rng = Rng::new(73);
    for _ in 0..10_000 {
        let (sin, phi) = (10f64.powf(rng.range(-4.0, -3.4)), rng.range(0.0, 7.0));
        let n = [(sin * phi.cos()) as f32, (sin * phi.sin()) as f32, -(1.0 - sin * sin).sqrt() as f32];
        let [x, y, z] = n;
        let (a, b) = (1.0 / (1.0 + z), -x * y / (1.0 + z));
        let frisvad = [[1.0 - x * x * a, b, -x], [b, 1.0 - y * y * a, -y]];
        let frame = Frame::from_normal(Vec3::<f32>::splat(n));
        let off = |[t, b]: [P; 2]| {
            let length = |v: P| (f64::from(dot(v, v)) - 1.0).abs();
            length(t).max(length(b)).max(f64::from(dot(t, b)).abs()).max(f64::from(dot(t, n)).abs())
        };
        if frisvad.as_flattened().iter().all(|x| x.is_finite()) {
            theirs = theirs.max(off(frisvad));
        }
        ours = ours.max(off([frame.tangent.lane(0), frame.bitangent.lane(0)]));
    }
    println!("worst: {theirs:e}, ours {ours:e}");
    assert!(theirs > 0.05 && ours < 12.0 * 2f64.powi(-24), "{theirs:e} {ours:e}");
}

/// The solid angle of triangles from 1e-12 sr as the excess of their angles over π: nothing left, in f32, below some 1e-7. Lights
/// are sampled by area here: their density's reciprocal has that solid angle (Van Oosterom & Strackee 1983, in f64) as its mean.
#[test]
fn small_solid_angles_are_there() {
    let mut rng = Rng::new(74);
    for size in [1e-6f32, 1e-4, 1e-2, 0.5] {
        let v = [[0.0f32, 0.0, 1.0], [0.0, size, 1.0], [size, 0.0, 1.0 + 0.1 * size]];
        let (e1, e2) = (sub(v[1], v[0]), sub(v[2], v[0]));
        let shape = EmitterShape::Triangle { p0: v[0], e1, e2 };
        let lights = Lights::build(vec![Emitter { primitive: 0, shape, radiance: [1.0; 3] }], None).expect("one light");
        let w = [0, 1, 2].map(|i| {
            // As the light knows its corners.
            let edge = [[0.0; 3], e1, e2][i];
            let p: [f64; 3] = std::array::from_fn(|k| f64::from(v[0][k]) + f64::from(edge[k]));
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            p.map(|x| x / length)
        });
        let dot64 = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let triple = w[0][0] * (w[1][1] * w[2][2] - w[1][2] * w[2][1])
            + w[0][1] * (w[1][2] * w[2][0] - w[1][0] * w[2][2])
            + w[0][2] * (w[1][0] * w[2][1] - w[1][1] * w[2][0]);
        let exact = 2.0 * triple.abs().atan2(1.0 + dot64(w[0], w[1]) + dot64(w[1], w[2]) + dot64(w[2], w[0]));
        let n = 1 << 16;
        let one = |_| {
            let s = lights.sample::<f32>(Vec3::splat([0.0; 3]), rng.f32(), [rng.f32(), rng.f32()], true);
            1.0 / f64::from(s.pdf)
        };
        let mean = (0..n).map(one).sum::<f64>() / f64::from(n);
        // Girard: the angles between the sides' planes.
        let side = |a: usize, b: usize| cross(w[a].map(|x| x as f32), w[b].map(|x| x as f32));
        let angle = |a: P, b: P| (-dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()).clamp(-1.0, 1.0).acos();
        let [a, b, c] = [side(0, 1), side(1, 2), side(2, 0)];
        let excess = angle(a, b) + angle(b, c) + angle(c, a) - std::f32::consts::PI;
        println!("{exact:e} sr: {mean:e}, by angles {excess:e}");
        // The spread of 1/pdf is that of t² over cos: below half the size, of the mean.
        let spread = 0.5 * f64::from(size) / f64::from(n).sqrt();
        assert!((mean / exact - 1.0).abs() < 4.0 * spread + 8.0 * 2f64.powi(-24), "{exact:e}: {mean:e}");
        assert!(size > 1e-3 || (f64::from(excess) / exact - 1.0).abs() > 0.5, "{exact:e}: {excess:e}");
    }
}

/// a²/(a² + b²) is ∞/∞ above 1.8e19, and 0/0 below 1e-23; 1/(1 + (b/a)²) is right for pdfs from 1e-30 to 1e30 and ∞.
#[test]
fn mis_weights_of_extreme_densities() {
    let naive = |a: f32, b: f32| a * a / (a * a + b * b);
    assert!(naive(2e19, 1e19).is_nan() && naive(1e-30, 1e-30).is_nan());
    let densities = [1e-30f32, 1e-23, 1e-7, 1.0, 1e7, 2e19, 1e30];
    for (a, b) in densities.iter().flat_map(|&a| densities.map(|b| (a, b))) {
        let (x, y) = (f64::from(a), f64::from(b));
        let exact = x * x / (x * x + y * y);
        let found = f64::from(mis_weight(a, b));
        assert!((found - exact).abs() <= 5.0 * 2f64.powi(-24) * exact + 1e-38, "{a:e} {b:e}: {found:e} for {exact:e}");
        let both = found + f64::from(mis_weight(b, a));
        assert!((both - 1.0).abs() <= 4.0 * 2f64.powi(-24), "{a:e} {b:e}: {both}");
    }
    assert_eq!((mis_weight(f32::INFINITY, 1.0), mis_weight(1.0, 0.0), mis_weight(1.0, f32::INFINITY)), (1.0, 1.0, 0.0));
    assert_eq!(mis_weight(0.0f32, 1.0), 0.0);
}

/// A table of 8 million lights as sums in f32: the sum stops to see what is added, and a third of the cells are off by more than a
/// tenth. Ours is stated by the table that samples: 2²⁰ lights here, each within its grid.
#[test]
fn many_lights_keep_their_shares() {
    let cells = 1 << 23;
    let mut rng = Rng::new(75);
    let powers: Vec<f32> = (0..cells).map(|_| rng.f32()).collect();
    let mut sum = 0f32;
    let ends: Vec<f32> = powers
        .iter()
        .map(|p| {
            sum += p;
            sum
        })
        .collect();
    let exact: f64 = powers.iter().map(|&p| f64::from(p)).sum();
    let wrong = |i: usize| {
        let share = f64::from(ends[i] - if i > 0 { ends[i - 1] } else { 0.0 }) / f64::from(sum);
        (share * exact / f64::from(powers[i]) - 1.0).abs() > 0.1
    };
    let off = (0..cells).filter(|&i| wrong(i)).count() as f64 / cells as f64;
    println!("{off}");
    assert!(off > 0.2, "{off}");
    let n = 1 << 20;
    let lamp = |i: usize| {
        let shape =
            EmitterShape::Triangle { p0: [i as f32 / n as f32, 0.0, 1.0], e1: [0.0, 1e-3, 0.0], e2: [1e-3, 0.0, 0.0] };
        Emitter { primitive: i as u32, shape, radiance: [powers[i]; 3] }
    };
    let lights = Lights::build((0..n).map(lamp).collect(), None).expect("a million lights");
    let total: f64 = powers[..n].iter().map(|&p| f64::from(p)).sum();
    let edge = f64::from(1e-3f32);
    let area = 0.5 * edge * edge;
    let mut mass = 0.0;
    for (i, &power) in powers[..n].iter().enumerate() {
        // Straight below: t = 1, cos = 1.
        let found = f64::from(lights.pdf_area::<f32>(Bits::splat(i as u32), Vec3::splat([0.0; 3]), 1.0, 1.0)) * area;
        mass += found;
        let share = f64::from(power) / total;
        // Half a step of the thresholds' grid a slot, roundings of the weight and of the stored quotient; what n slots have
        // rounded off, at random, is left to the last.
        let bound = 2f64.powi(-24) * (6.0 * share + (1.0 + (n as f64).sqrt()) / n as f64);
        assert!((found - share).abs() <= bound, "{i}: {found:e} for {share:e}");
    }
    assert!((mass - 1.0).abs() < 1e-6, "{mass}");
}

/// Bits · 2⁻³² gives 1 for the largest 128 of 2³²; the upper 24 bits never do.
#[test]
fn the_naive_unit_number_reaches_1() {
    let naive = |bits: u32| bits as f32 * 2f32.powi(-32);
    assert_eq!((naive(u32::MAX), naive(u32::MAX - 127)), (1.0, 1.0));
    assert!(naive(u32::MAX - 128) < 1.0);
    let bits = <f32x8 as Real>::Bits::from_fn(|i| u32::MAX - 20 * i as u32);
    assert!(octolux::sampling::to_unit::<f32x8>(bits).lt(f32x8::one()).all());
}

/// √ of what rounding made negative is NaN, and NaN · 0 stays NaN: a mask that multiplies does not help, one that selects does, and
/// neither is needed where the argument is held to 0 first.
#[test]
fn roots_of_negative_rounding() {
    let x = f32x8::from_fn(|i| -1e-9 * i as f32);
    assert!((x.sqrt() * f32x8::zero()).lane(3).is_nan());
    assert!(x.sqrt().masked(Mask::splat(false)).eq(f32x8::zero()).all());
    assert!(x.safe_sqrt().eq(f32x8::zero()).all());
}

/// Distances to the planes of a box rounded as they come: the box is missed by rays to its corners; with the far distance
/// padded (Ize 2013) never.
#[test]
fn unpadded_slabs_miss_corners() {
    let mut rng = Rng::new(76);
    let (mut tried, mut naive) = (0, 0);
    for _ in 0..20_000 {
        let (lo, hi): (P, P) = (std::array::from_fn(|_| -rng.f32()), std::array::from_fn(|_| rng.f32()));
        let corner: P = std::array::from_fn(|k| if rng.u64() & 1 == 0 { lo[k] } else { hi[k] });
        let o: P = std::array::from_fn(|_| 4.0 * rng.f32() - 2.0);
        if (0..3).all(|k| lo[k] <= o[k] && o[k] <= hi[k]) {
            continue;
        }
        let d = sub(corner, o);
        let near = std::array::from_fn(|k| if d[k] < 0.0 { hi[k] } else { lo[k] });
        let far = std::array::from_fn(|k| if d[k] < 0.0 { lo[k] } else { hi[k] });
        let (enters, leaves) = slab::slab::<f32>(near, far, o, d.map(|x| 1.0 / x));
        assert!(enters <= leaves, "{o:?} {d:?}: {enters} {leaves}");
        tried += 1;
        naive += u32::from(enters > leaves / slab::FAR_PAD);
    }
    println!("{naive} of {tried} without the pad");
    assert!(naive > tried / 20, "{naive} of {tried}");
}
