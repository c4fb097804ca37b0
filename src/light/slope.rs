//! Numbers of a lamp made denser where a receiver gets more from.
//!
//! What a small part of a lamp sends to a receiver goes with cosθ/d⁴ (as the other cosine is that of a plane, height over d).
//! Along each side of a parallelogram the numbers follow the density ∝ 1/(1 − g + 2gx)², whose ends are in that proportion in
//! the middle between the other two sides: to the fourth power of the distances exactly, to the cosines about. Its distribution
//! function is a quotient of linear functions, as is the inverse: two divisions a sample, neither root nor arc. Against the
//! exact choices, uniform in the solid angle (Ureña, Fajardo, King 2013) and bilinear between cosθ/d⁴ at the corners, it has
//! the same noise.

use crate::geometry::Rows;
use crate::lane::{Real, Vec3};
use glam::DVec3;

/// The largest slope: numbers are 1/3 to 3 times as dense along a side as evenly.
const STEEPEST: f32 = 0.5;

/// Centre, halves of the sides, their squared lengths.
type Row = [f32; 12];

/// What it takes of parallelograms, and of those that stand for [triangles](of_triangle).
pub(super) struct Slopes(Rows<12>);

/// Numbers, and how much of the square one of them stands for: over that of uniform numbers.
pub(super) struct Sloped<R> {
    pub u: [R; 2],
    pub stretch: R,
}

impl Slopes {
    /// Of parallelograms, by a vertex and those next to it.
    pub fn of(vertices: impl Iterator<Item = [DVec3; 3]>) -> Self {
        Self(Rows::new(&vertices.map(row).collect::<Vec<Row>>()))
    }

    /// Lamps.
    pub fn len(&self) -> usize {
        self.0.count()
    }

    pub fn bytes(&self) -> usize {
        self.0.bytes()
    }

    /// For a receiver at `p` whose normal, on the side that is lit, is `n`; 0 for one that counts no cosine.
    #[inline(always)]
    pub fn lean<R: Real>(&self, lamp: R::Bits, valid: R::Mask, p: Vec3<R>, n: Vec3<R>, u: [R; 2]) -> Sloped<R> {
        let [x, y, z, ax, ay, az, bx, by, bz, aa, bb, _] = self.0.fetch::<R>(lamp, valid);
        let (way, a, b) = (Vec3::new(x, y, z) - p, Vec3::new(ax, ay, az), Vec3::new(bx, by, bz));
        let squared = way.length_squared();
        // Squared distances of the two ends are of ± so much.
        let (mean_a, mean_b) = (squared + aa, squared + bb);
        let (off_a, off_b) = (way.dot(a), way.dot(b));
        let (rise_a, rise_b) = (n.dot(a), n.dot(b));
        // Where the horizon cuts the lamp the cosine is taken to reach 0 at a corner.
        let height = n.dot(way).max_or(rise_a.abs() + rise_b.abs());
        let height = R::select(height.gt(R::zero()), height, R::one());
        let share = R::splat(0.5) / (mean_a * mean_b * height);
        let slope = |rise: R, mean: R, off: R, other: R| {
            let wanted = (off * height).mul_add(R::splat(-4.0), rise * mean) * (other * share);
            // NaN, where numbers leave the range, gives way to either.
            wanted.max_or(R::splat(-STEEPEST)).min_or(R::splat(STEEPEST))
        };
        let (ga, gb) = (slope(rise_a, mean_a, off_a, mean_b), slope(rise_b, mean_b, off_b, mean_a));
        let one = R::one();
        let below = |g: R, u: R| g.mul_add(u + u - one, one);
        let (below_a, below_b) = (below(ga, u[0]), below(gb, u[1]));
        let inverse = (below_a * below_b).recip();
        let spread = (one - ga * ga) * (one - gb * gb);
        Sloped {
            u: [
                (u[0] * (one + ga) * (below_b * inverse)).min_or(one),
                (u[1] * (one + gb) * (below_a * inverse)).min_or(one),
            ],
            stretch: spread * (inverse * inverse),
        }
    }
}

fn row([p, next, last]: [DVec3; 3]) -> Row {
    let (a, b) = (0.5 * (next - p), 0.5 * (last - p));
    let mut row = [0.0; 12];
    for (k, v) in [p + a + b, a, b].map(DVec3::as_vec3).iter().enumerate() {
        row[3 * k..3 * k + 3].copy_from_slice(&v.to_array());
    }
    (row[9], row[10]) = (a.length_squared() as f32, b.length_squared() as f32);
    row
}

/// The parallelogram that stands for a triangle: as long as the [map](crate::sampling::warp::uniform_triangle) from the square to it is
/// on average along either number, about the same middle.
pub(super) fn of_triangle([p, next, last]: [DVec3; 3]) -> [DVec3; 3] {
    let (a, b) = (next - p, last - p);
    let corner = p + (a + b) / 12.0;
    [corner, corner + 0.75 * a - 0.25 * b, corner + 0.75 * b - 0.25 * a]
}
