//! How light is followed.

use super::{Gather, GatherWeights, LightPaths, PathReuse, Roulette};

/// Paths that nothing ends (in a sealed white room roulette lets all go on) would hold an interrupted render for ever; kernels count
/// in single precision.
pub const MOST_BOUNCES: u32 = 65_535;

/// How light is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    /// Which estimator or view.
    pub kind: IntegratorKind,
    /// Scattering events on a path: 0 emission only, 1 direct light, 2 one indirect bounce …; at most [`MOST_BOUNCES`].
    pub max_bounces: u32,
    /// `depth` view: the distance that reads 0.
    pub max_depth: f32,
    /// `phong`: radiance that arrives from everywhere, ≥ 0.
    pub ambient: [f32; 3],
    /// `path`: are paths traced from the lights, too?
    pub light_paths: LightPaths,
    /// `path`: do pixels share what their paths find?
    pub path_reuse: PathReuse,
    /// `path`: when paths may end by chance.
    pub roulette: Roulette,
    /// Read for `gather` alone.
    pub gather: Gather,
}

/// How light is followed where the scene does not say.
impl Default for Integrator {
    fn default() -> Self {
        let kind = IntegratorKind::Path;
        Integrator {
            kind,
            max_bounces: 7,
            max_depth: 5.0,
            ambient: [0.0; 3],
            light_paths: LightPaths::default(),
            path_reuse: PathReuse::default(),
            roulette: Roulette::default(),
            gather: Gather::default(),
        }
    }
}

impl Integrator {
    /// As the command line has them, those of its settings that it has, each after a blank.
    pub fn options(&self) -> String {
        let (light_paths, path_reuse, roulette) = (self.light_paths.name(), self.path_reuse.name(), self.roulette);
        format!(" --light-paths {light_paths} --path-reuse {path_reuse} --roulette {roulette}")
    }

    /// Do samples share anything besides the scene?
    pub fn shares_points(&self) -> bool {
        self.kind == IntegratorKind::Gather && self.gather.weights == GatherWeights::Shared
    }

    /// What an estimate's reader must know beyond how it was stopped; `None` where every sample is unbiased.
    pub fn note(&self) -> Option<&'static str> {
        let gather = Some(self.gather).filter(|_| self.kind == IntegratorKind::Gather)?;
        match (gather.method.is_bayesian(), gather.weights) {
            (true, _) => Some("posterior means: biased, and what hits share does not average out over samples"),
            (false, GatherWeights::Shared) => {
                Some("point sets are shared: unbiased over seeds, but their error does not average out over samples")
            }
            (false, GatherWeights::PerHit) => None,
        }
    }
}

/// An estimator of radiance, or a view of the geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegratorKind {
    /// Paths of up to `max_bounces` scattering events.
    Path,
    /// Paths of one scattering event.
    Direct,
    /// At the first hit, n directions with the weights of an estimator.
    Gather,
    /// Ambient light, and lights without extent with their shadows: nothing is random but the camera's numbers.
    Phong,
    /// Shading normals towards the viewer.
    Normals,
    /// 1 − distance/`max_depth`, at least 0.
    Depth,
    /// 1 where something is hit.
    Hit,
}
