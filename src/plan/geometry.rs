//! The ways to find geometry.

use crate::scene::Scene;

/// Up to this many primitives a ray is tested against all of them and no tree is built.
pub const BRUTE_FORCE_LIMIT: usize = 64;

/// Past this many primitives nobody may ask to have each ray tested against all of them: there a ray takes a quarter of a
/// millisecond (by measuring: .17 to .31 ns a primitive at 16 lanes), and the lists 260 MB.
pub const BRUTE_FORCE_MOST: usize = 1 << 20;

/// How rays find geometry. The bits are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum GeometryMode {
    /// Every primitive in turn; no tree exists.
    Brute,
    /// An 8-wide tree, by the class of a ray: camera rays as packets, rays after a bounce as a stream, each on its own way, and
    /// shadow rays as packets as far as they go together.
    #[value(skip)]
    Tree,
    /// An 8-wide tree, which the rays of every packet walk together (at 1 lane: each alone).
    Packet,
    /// An 8-wide tree, which every ray walks on its own way, many in flight together (at 1 lane: each alone).
    Stream,
}

impl GeometryMode {
    /// All there are.
    pub const ALL: [GeometryMode; 4] =
        [GeometryMode::Brute, GeometryMode::Tree, GeometryMode::Packet, GeometryMode::Stream];

    /// Is there a tree?
    pub fn has_tree(self) -> bool {
        self != GeometryMode::Brute
    }

    /// Do rays of all classes walk the tree in one way?
    pub fn is_uniform(self) -> bool {
        matches!(self, GeometryMode::Packet | GeometryMode::Stream)
    }

    /// As the command line and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            GeometryMode::Brute => "brute",
            GeometryMode::Tree => "tree",
            GeometryMode::Packet => "packet",
            GeometryMode::Stream => "stream",
        }
    }

    /// As a person reads it.
    pub fn describe(self) -> &'static str {
        match self {
            GeometryMode::Brute => "brute force",
            GeometryMode::Tree => "a tree",
            GeometryMode::Packet => "a tree, packets alone",
            GeometryMode::Stream => "a tree, streams alone",
        }
    }

    /// Where a scene has too many primitives for it, why not and what to do.
    pub fn refusal(self, scene: &Scene) -> Option<String> {
        let primitives = scene.mesh.triangles.len() + scene.spheres.len();
        (!self.has_tree() && primitives > BRUTE_FORCE_MOST).then(|| {
            format!(
                "--mode brute tests each ray against all of at most {BRUTE_FORCE_MOST} primitives, and the scene has \
                 {primitives}; let rays walk a tree: --mode packet or stream, or leave it out"
            )
        })
    }
}
