//! Integrands of a program's own.

use super::{same_bits, table, with_lamp};
use octolux::Renderer;
use octolux::lane::{Real, Vec3};
use octolux::own::{CameraSample, Integrand};
use octolux::sampling::dimensions::BSDF_DIRECTION;
use octolux::sampling::{Frame, SamplerKind, warp};
use octolux::scene::{Bsdf, Camera, SceneBuilder};

/// How much of the hemisphere is open, by directions of density cosθ/π.
struct Openness;

impl Integrand for Openness {
    fn radiance<R: Real>(&self, sample: &mut CameraSample<R>) -> Vec3<R> {
        let (ray, active) = (sample.ray, sample.active);
        let hit = sample.closest(&ray, active);
        let found = active & hit.valid();
        let at = sample.surface(&ray, &hit, found);
        let u = sample.numbers();
        let n = Vec3::select(at.ng.dot(ray.direction).gt(R::zero()), -at.ng, at.ng);
        let towards = warp::cosine_hemisphere([u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]]);
        let hidden = sample.occluded(&at.ray_towards(Frame::from_normal(n).to_world(towards)), found);
        Vec3::all(R::select(hidden, R::zero(), R::one())).masked(found)
    }
}

/// Light that arrives at the first surface straight from lamps and sky, by light samples alone.
struct Lit;

impl Integrand for Lit {
    fn radiance<R: Real>(&self, sample: &mut CameraSample<R>) -> Vec3<R> {
        let (ray, active) = (sample.ray, sample.active);
        let hit = sample.closest(&ray, active);
        let found = active & hit.valid();
        let at = sample.surface(&ray, &hit, found);
        let u = sample.numbers();
        let Some((light, shadow)) = sample.light(&at, &u, found) else { return Vec3::zero() };
        let f = sample.eval(&at, -ray.direction, light.wi, found);
        let carries = found & light.pdf.gt(R::zero());
        let carries = carries & !sample.occluded(&shadow, carries);
        let one = R::one();
        (f.value.hadamard(light.radiance) * R::select(carries, light.pdf, one).recip()).masked(carries)
    }
}

#[test]
fn integrands_give_the_same_bits_at_any_width() {
    for balls in [8, 70] {
        let scene = with_lamp(table(balls).0).build().expect("a scene");
        same_bits("openness", |renderer| renderer.integrate(&scene, &Openness).expect("a film"));
        same_bits("lit", |renderer| renderer.integrate(&scene, &Lit).expect("a film"));
    }
}

/// A ball of radius r above a floor, its centre at distance d and angle θ from the normal of a point, hides r²cosθ/d² of what
/// that point sees (Nusselt 1928).
#[test]
fn openness_below_a_ball() {
    let mut scene = SceneBuilder::new(Camera::towards([0.0, 0.5, 2.0], [0.0; 3], 0.01), 1, 1);
    let grey = scene.material(Bsdf::Diffuse { reflectance: [0.5; 3] });
    let corners = [[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]];
    scene.mesh(&corners, &[[0, 1, 2], [0, 2, 3]], grey);
    scene.sphere([1.0, 2.0, 0.0], 0.9, grey);
    let renderer = Renderer::new(65_536).sampler(SamplerKind::Independent);
    let film = renderer.integrate(&scene.build().expect("a scene"), &Openness).expect("a film");
    let squared = 1.0f64 + 4.0;
    let expected = 1.0 - 0.81 / squared * (2.0 / squared.sqrt());
    let sigma = film.variance_of_mean(0, 0).expect("a variance")[0].sqrt();
    let mean = film.mean(0, 0)[0];
    assert!((mean - expected).abs() < 4.0 * sigma, "{mean}, expected {expected} ± {sigma}");
}

/// The same as `direct` finds where light samples have all the weight: lamps without extent.
#[test]
fn light_from_points_is_what_direct_finds() {
    use octolux::scene::{DeltaLight, Integrator, IntegratorKind};
    let (mut scene, _) = table(8);
    scene.light(DeltaLight::Point { position: [0.5, 1.5, 0.5], intensity: [3.0; 3] });
    scene.integrator(Integrator { kind: IntegratorKind::Direct, ..Integrator::default() });
    let scene = scene.build().expect("a scene");
    let renderer = Renderer::new(4);
    let (found, expected) = (renderer.integrate(&scene, &Lit), renderer.render(&scene));
    let (found, expected) = (found.expect("a film"), expected.expect("a film"));
    for y in 0..found.height() {
        for x in 0..found.width() {
            let (f, e) = (found.mean(x, y)[0], expected.mean(x, y)[0]);
            assert!((f - e).abs() <= 1e-6 * e, "pixel {x}, {y}: {f}, direct {e}");
        }
    }
    assert!(!Renderer::new(1).threads(1).integrate(&scene, &Lit).expect("a film").mean(20, 25)[0].is_nan());
}
