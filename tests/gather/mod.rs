//! The gather and Phong integrators.

mod agreement;
mod claims;
mod exact;
mod lobes;
mod phong;
mod posterior;
mod ranking;
mod shrinkage;

use crate::renders::Set;
use octolux::estimate::bmc::Points;
use octolux::scene::{
    Bsdf, Environment, EnvironmentImage, Gather, GatherLights, GatherMethod, GatherPdf, GatherShrinkage, GatherWeights,
    IntegratorKind, Scene,
};

/// The settings of a method with its own pdf.
pub fn gather(method: GatherMethod) -> Gather {
    let pdf = if method.is_importance() { GatherPdf::Cosine } else { GatherPdf::Uniform };
    Gather { method, pdf, ..Gather::default() }
}

/// The sets without a turn, with the posterior's weights.
pub fn as_they_are(gather: Gather) -> Gather {
    Gather { rotate: false, shrinkage: GatherShrinkage::None, ..gather }
}

/// The same scene, gathered.
pub fn gathered(scene: &Scene, gather: Gather) -> Scene {
    let mut scene = scene.clone();
    scene.integrator.kind = IntegratorKind::Gather;
    scene.integrator.gather = gather;
    scene
}

/// A sky whose radiance is linear in the direction, so without edges, the zenith included; brighter on one side.
pub fn smooth_sky() -> Environment {
    let (width, height) = (128, 64);
    let texel = |i: usize| {
        let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let (sin, cos) = (std::f32::consts::PI * y / height as f32).sin_cos();
        let side = 0.5 + 0.5 * sin * (std::f32::consts::TAU * x / width as f32).cos();
        [0.3 + 0.6 * side, 0.5, 0.66 + 0.5 * cos]
    };
    Environment::Image(EnvironmentImage {
        width,
        height,
        texels: (0..width * height).map(texel).collect(),
        rotation: 0.0,
    })
}

/// A Lambert sphere on a Lambert plane under a sky, and a lamp if wanted.
pub fn sphere_scene(side: u32, lamp: bool) -> Set {
    let mut set = Set::new([0.0, 1.6, 5.0], [0.0, 0.75, 0.0], 36.0, side).bounces(1).environment(smooth_sky());
    let ground = set.grey(0.5, 0.0);
    let plaster = set.material(Bsdf::Diffuse { reflectance: [0.75, 0.55, 0.4] }, [0.0; 3]);
    set.quad(ground, [[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0], [-6.0, 0.0, -6.0]]);
    set.sphere(plaster, [0.0, 1.0, 0.0], 1.0);
    if lamp {
        let light = set.material(Bsdf::Diffuse { reflectance: [0.2; 3] }, [2.0, 3.0, 4.0]);
        set.quad(light, [[-1.0, 3.0, -1.0], [1.0, 3.0, -1.0], [1.0, 3.0, 1.0], [-1.0, 3.0, 1.0]]);
    }
    set
}

/// All that shares nothing between hits, and so is unbiased sample by sample.
pub fn fresh(method: GatherMethod, points: Points, lights: GatherLights, samples: u32) -> Gather {
    Gather { samples, points, lights, weights: GatherWeights::PerHit, rotate: false, ..gather(method) }
}
