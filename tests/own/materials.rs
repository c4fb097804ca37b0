//! A BSDF of a program's own in the path estimator.

use super::{SAMPLES, same_bits, table, with_lamp};
use crate::equivalence::assert_same;
use crate::renders;
use octolux::Renderer;
use octolux::bsdf::{Diffuse, Eval, Model, Sample};
use octolux::lane::{Mask, Real, Vec3, math};
use octolux::own::{Bsdf, Own};
use octolux::plan::Force;
use octolux::sampling::{SamplerKind, warp};

/// The scene's Lambert under another name.
struct Lambert([f32; 3]);

impl Bsdf for Lambert {
    fn eval<R: Real>(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        Diffuse { reflectance: Vec3::splat(self.0) }.eval(wo, wi)
    }
    fn sample<R: Real>(&self, wo: Vec3<R>, u_lobe: R, u: [R; 2]) -> Sample<R> {
        Diffuse { reflectance: Vec3::splat(self.0) }.sample(wo, u_lobe, u)
    }
}

/// Bright at the rim: f·cosθi = ρ/2π exp(−a cosθo), on the side of the viewer, directions uniform.
pub struct Velvet {
    pub sheen: f32,
}

impl Bsdf for Velvet {
    fn eval<R: Real>(&self, wo: Vec3<R>, wi: Vec3<R>) -> Eval<R> {
        let same = (wo.z * wi.z).gt(R::zero());
        let value = math::exp(-(wo.z.abs() * R::splat(self.sheen))) * R::splat(0.8 / std::f32::consts::TAU);
        let pdf = R::splat(1.0 / std::f32::consts::TAU);
        Eval { value: Vec3::all(value).masked(same), pdf: pdf.masked(same) }
    }
    fn sample<R: Real>(&self, wo: Vec3<R>, _u_lobe: R, u: [R; 2]) -> Sample<R> {
        let up = warp::uniform_hemisphere(u);
        let wi = Vec3::new(up.x, up.y, up.z.copysign(wo.z));
        let Eval { value, pdf } = self.eval(wo, wi);
        let valid = pdf.gt(R::zero());
        let weight = (value * R::select(valid, pdf, R::one()).recip()).masked(valid);
        Sample { wi, weight, pdf, eta: R::one(), delta: R::Mask::splat(false), valid }
    }
}

/// An own BSDF takes the same random numbers at the same place as the scene's, with both kinds of samples at every vertex: it
/// alone knows what light samples may leave out.
#[test]
fn an_own_lambert_has_the_bits_of_the_scenes() {
    for balls in [8, 70] {
        let (scene, ball) = table(balls);
        let scene = with_lamp(scene).build().expect("a scene");
        let own = Own::new().bsdf(ball, Lambert([0.3, 0.6, 0.8]));
        let found = Renderer::new(SAMPLES).render_with(&scene, &own).expect("a film");
        let mut world = renders::sampled(&scene, 0, Force::default(), SamplerKind::Sobol).without_light_paths();
        world.reach = None;
        world.plan.path_reuse = false;
        assert_same(&format!("{balls} balls"), &found, &renders::film(&world, SAMPLES));
    }
}

#[test]
fn an_own_bsdf_gives_the_same_bits_at_any_width() {
    for balls in [8, 70] {
        let (scene, ball) = table(balls);
        let scene = with_lamp(scene).build().expect("a scene");
        let own = Own::new().bsdf(ball, Velvet { sheen: 2.0 });
        let film = same_bits("velvet", |renderer| renderer.render_with(&scene, &own).expect("a film"));
        let scenes = Renderer::new(SAMPLES).render(&scene).expect("a film");
        let changed = (0..film.width()).filter(|&x| film.mean(x, 15) != scenes.mean(x, 15)).count();
        assert!(changed > 5, "the balls look as before");
    }
}

/// Under an even sky what a convex body shows is its albedo: here 0.8 exp(−a cosθo), at the centre of the ball cosθo = 1.
#[test]
fn albedo_of_an_own_bsdf() {
    use octolux::scene::{Camera, SceneBuilder};
    let mut scene = SceneBuilder::new(Camera::towards([0.0, 0.0, 8.0], [0.0; 3], 0.01), 1, 1);
    let ball = scene.material(octolux::scene::Bsdf::Diffuse { reflectance: [0.0; 3] });
    scene.sphere([0.0; 3], 1.0, ball);
    scene.environment([1.0; 3]);
    let own = Own::new().bsdf(ball, Velvet { sheen: 1.5 });
    let film = Renderer::new(1024).render_with(&scene.build().expect("a scene"), &own).expect("a film");
    // Light samples and BSDF samples have other densities: MIS leaves some noise.
    let (mean, expected) = (film.mean(0, 0)[0], 0.8 * f64::exp(-1.5));
    let sigma = film.variance_of_mean(0, 0).expect("a variance")[0].sqrt();
    assert!((mean - expected).abs() < 4.0 * sigma + 1e-6, "{mean}, expected {expected} ± {sigma}");
    assert!(sigma < 0.01 * expected);
}
