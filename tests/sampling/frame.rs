//! Frames around normals from all sides, the poles included.

use crate::lane::widths::{LaneFunction, assert_same_bits};
use octolux::lane::{Real, Vec3};
use octolux::sampling::{Frame, Xoshiro, warp};

struct FrameOf;
impl LaneFunction for FrameOf {
    fn call<R: Real>(&self, input: &[R]) -> Vec<R> {
        let frame = Frame::from_normal(Vec3::new(input[0], input[1], input[2]));
        let v = Vec3::new(input[3], input[4], input[5]);
        let (local, world) = (frame.to_local(v), frame.to_world(v));
        [frame.tangent, frame.bitangent, local, world].iter().flat_map(|v| [v.x, v.y, v.z]).collect()
    }
}

fn normals() -> Vec<[f32; 3]> {
    let mut rng = Xoshiro::<f32>::from_keys(|_| 5);
    let mut normals: Vec<[f32; 3]> =
        (0..100_000).map(|_| warp::uniform_sphere([rng.next_unit(), rng.next_unit()]).lane(0)).collect();
    for tilt in [0.0, 1e-30, 1e-10, 1e-5, 1e-3] {
        for z in [1.0, -1.0] {
            normals.extend([[tilt, 0.0, z], [0.0, -tilt, z], [-tilt, tilt, z]]);
        }
    }
    normals.extend([[1.0, 0.0, 0.0], [0.0, 1.0, -0.0], [0.0, -1.0, 0.0], [-1.0, 0.0, -0.0]]);
    normals
}

#[test]
fn frames_are_orthonormal_and_right_handed() {
    let mut worst = 0.0f64;
    for n in normals() {
        // The given normal is a unit vector to rounding only; what is asked is against the exact one of its direction.
        let n64 = n.map(f64::from);
        let length = n64.iter().map(|x| x * x).sum::<f64>().sqrt();
        let frame = Frame::from_normal(Vec3::<f32>::splat(n));
        let [t, b] = [frame.tangent, frame.bitangent].map(|v| v.lane(0).map(f64::from));
        let n64 = n64.map(|x| x / length);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = [t[1] * b[2] - t[2] * b[1], t[2] * b[0] - t[0] * b[2], t[0] * b[1] - t[1] * b[0]];
        for error in [dot(t, t) - 1.0, dot(b, b) - 1.0, dot(t, b), dot(t, n64), dot(b, n64), dot(cross, n64) - 1.0] {
            worst = worst.max(error.abs());
        }
    }
    println!("frame: worst deviation {worst:e}");
    // Six products and sums of numbers up to 2, each rounded to 2⁻²⁴ of that.
    assert!(worst < 12.0 * 2f64.powi(-24));
}

#[test]
fn to_world_undoes_to_local() {
    for (n, v) in normals().into_iter().zip(normals().into_iter().rev()) {
        let frame = Frame::from_normal(Vec3::<f32>::splat(n));
        let back = frame.to_world(frame.to_local(Vec3::splat(v))).lane(0);
        // Three entries of the basis' product with its transpose, each off by 12 units at most (above), and six roundings.
        assert!((0..3).all(|i| (back[i] - v[i]).abs() < 42.0 * 2f32.powi(-24)), "{v:?} → {back:?}");
    }
}

#[test]
fn the_same_bits_at_every_width() {
    let normals = normals();
    let rows: Vec<Vec<f32>> =
        normals.iter().zip(normals.iter().rev()).map(|(n, v)| [&n[..], &v[..]].concat()).collect();
    assert_same_bits(&FrameOf, &rows);
}
