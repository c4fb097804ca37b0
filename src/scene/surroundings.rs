//! What lies around the centre of a model: its bounding box, and a few rays against every triangle.

use super::Mesh;
use glam::DVec3;

/// A mesh and the bounding box of its triangles.
pub(super) struct Surroundings<'a> {
    mesh: &'a Mesh,
    low: DVec3,
    high: DVec3,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
pub(super) struct Hit {
    /// In units of the ray's direction.
    pub t: f64,
    /// Is it the counter-clockwise side?
    pub front: bool,
}

/// Off the axes by amounts that no model shares: a ray along an axis would run through the diagonals of its quads.
const SKEW: [f64; 2] = [0.012_345_6, 0.007_654_3];

impl<'a> Surroundings<'a> {
    /// Of a mesh with at least one triangle.
    pub fn of(mesh: &'a Mesh) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &corner in mesh.triangles.iter().flatten() {
            let position = corner_position(mesh, corner);
            (low, high) = (low.min(position), high.max(position));
        }
        Self { mesh, low, high }
    }

    pub fn center(&self) -> DVec3 {
        (self.low + self.high) / 2.0
    }

    pub fn size(&self) -> DVec3 {
        self.high - self.low
    }

    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::select(glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), self.low, self.high)
        })
    }

    /// Does the model enclose its centre as a room does: with walls on all six sides, and the centre not in the
    /// matter? It is in the matter where a ray leaves through back faces once more than it enters through front faces
    /// (a statue encloses its centre, too, but is to be seen from outside); the majority of the rays decides.
    pub fn is_room(&self) -> bool {
        let mut in_the_open = 0;
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let skew = DVec3::new(axis.z, axis.x, axis.y) * SKEW[0] + DVec3::new(axis.y, axis.z, axis.x) * SKEW[1];
            for direction in [axis + skew, -axis + skew] {
                let (mut hits, mut leaves_minus_enters) = (0, 0);
                self.hits(self.center(), direction, |hit| {
                    hits += 1;
                    leaves_minus_enters += if hit.front { -1 } else { 1 };
                });
                if hits == 0 {
                    return false;
                }
                in_the_open += usize::from(leaves_minus_enters <= 0);
            }
        }
        in_the_open > 3
    }

    /// The nearest hit.
    pub fn nearest(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.hits(origin, direction, |hit| {
            if nearest.is_none_or(|best| hit.t < best.t) {
                nearest = Some(hit);
            }
        });
        nearest
    }

    /// Every triangle in front of the origin (Möller and Trumbore 1997, in double precision).
    fn hits(&self, origin: DVec3, direction: DVec3, mut found: impl FnMut(Hit)) {
        for &triangle in &self.mesh.triangles {
            let [a, b, c] = triangle.map(|corner| corner_position(self.mesh, corner));
            let (ab, ac) = (b - a, c - a);
            let across = direction.cross(ac);
            let determinant = ab.dot(across);
            if determinant == 0.0 {
                continue;
            }
            let from_a = origin - a;
            let u = from_a.dot(across) / determinant;
            let around = from_a.cross(ab);
            let v = direction.dot(around) / determinant;
            let t = ac.dot(around) / determinant;
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 {
                found(Hit { t, front: determinant > 0.0 });
            }
        }
    }
}

fn corner_position(mesh: &Mesh, corner: u32) -> DVec3 {
    DVec3::from(mesh.positions[corner as usize].map(f64::from))
}
