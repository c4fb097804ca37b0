//! A light of a program's own in the path estimator.

use super::{same_bits, table, with_lamp};
use crate::equivalence::assert_same;
use octolux::Renderer;
use octolux::lane::{Mask, Real, Vec3};
use octolux::own::{Arrival, Light, Own};
use octolux::sampling::{SamplerKind, warp};
use octolux::scene::{DeltaLight, PathReuse, SceneBuilder};

/// The same radiance from everywhere, as the scene's constant environment.
struct EvenSky([f32; 3]);

impl Light for EvenSky {
    fn sample<R: Real>(&self, _p: Vec3<R>, u: [R; 2]) -> Arrival<R> {
        let (wi, pdf) = (warp::uniform_sphere(u), warp::uniform_sphere_pdf());
        let distance = R::splat(f32::INFINITY);
        Arrival { wi, distance, radiance: Vec3::splat(self.0), pdf, delta: R::Mask::splat(false) }
    }
    fn outside<R: Real>(&self, _wi: Vec3<R>) -> (Vec3<R>, R) {
        (Vec3::splat(self.0), warp::uniform_sphere_pdf())
    }
}

/// A point light.
struct Bulb {
    at: [f32; 3],
    intensity: f32,
}

impl Light for Bulb {
    fn sample<R: Real>(&self, p: Vec3<R>, _u: [R; 2]) -> Arrival<R> {
        let way = Vec3::splat(self.at) - p;
        let squared = way.length_squared();
        let distance = squared.sqrt();
        Arrival {
            wi: way * distance.recip(),
            distance,
            radiance: Vec3::all(R::splat(self.intensity) / squared),
            pdf: R::one(),
            delta: R::Mask::splat(true),
        }
    }
}

#[test]
fn an_own_even_sky_has_the_bits_of_the_scenes() {
    let (mut lit, _) = table(8);
    let dark = lit.build().expect("a scene");
    lit.environment([0.9, 1.0, 1.1]);
    let mut lit = lit.build().expect("a scene");
    lit.integrator.path_reuse = PathReuse::Off;
    let expected = Renderer::new(16).render(&lit).expect("a film");
    let own = Own::new().light(EvenSky([0.9, 1.0, 1.1]));
    let found = same_bits("even sky", |renderer| renderer.render_with(&dark, &own).expect("a film"));
    assert_same("even sky", &found, &expected);
}

/// Mean over the film of each channel's first, and its standard error, with independent samples.
fn mean(scene: &SceneBuilder, own: Option<&Own<octolux::own::Nothing, impl Light>>) -> (f64, f64) {
    let renderer = Renderer::new(256).sampler(SamplerKind::Independent).seed(u64::from(own.is_some()));
    let scene = scene.build().expect("a scene");
    let film = own.map_or_else(|| renderer.render(&scene), |own| renderer.render_with(&scene, own)).expect("a film");
    let pixels = || (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    let count = pixels().count() as f64;
    let sum: f64 = pixels().map(|(x, y)| film.mean(x, y)[0]).sum();
    let variance: f64 = pixels().map(|(x, y)| film.variance_of_mean(x, y).expect("samples")[0]).sum();
    (sum / count, variance.sqrt() / count)
}

/// Two images of the same light, one with it as the program's own beside the scene's lamps: z within 4.
#[track_caller]
fn agree(name: &str, scenes: (f64, f64), own: (f64, f64)) {
    let z = (own.0 - scenes.0) / (own.1.powi(2) + scenes.1.powi(2)).sqrt();
    assert!(z.abs() < 4.0, "{name}: {own:?}, the scene's own {scenes:?}, z = {z:.2}");
    assert!(own.1 < 0.01 * own.0, "{name}: too noisy to tell: {own:?}");
}

#[test]
fn an_own_sky_beside_a_scenes_lights_is_unbiased() {
    let (scene, _) = table(8);
    let lamps = with_lamp(scene);
    let mut all = lamps.clone();
    all.environment([0.5; 3]);
    agree("sky", mean(&all, None::<&Own>), mean(&lamps, Some(&Own::new().light(EvenSky([0.5; 3])))));
}

/// Each of two skies is weighed by the density of its own samples: by that of both, a ninth of the light would be lost.
#[test]
fn an_own_sky_beside_a_scenes_sky_is_unbiased() {
    let (dark, _) = table(8);
    let with_sky = |radiance: [f32; 3]| {
        let mut scene = dark.clone();
        scene.environment(radiance);
        scene
    };
    let own = mean(&with_sky([0.5; 3]), Some(&Own::new().light(EvenSky([0.5; 3]))));
    agree("two skies", mean(&with_sky([1.0; 3]), None::<&Own>), own);
}

#[test]
fn an_own_bulb_beside_a_scenes_lights_is_unbiased() {
    let (scene, _) = table(8);
    let mut lamps = with_lamp(scene);
    lamps.environment([0.1; 3]);
    let mut all = lamps.clone();
    let at = [0.5, 1.5, 0.5];
    all.light(DeltaLight::Point { position: at, intensity: [3.0; 3] });
    agree("bulb", mean(&all, None::<&Own>), mean(&lamps, Some(&Own::new().light(Bulb { at, intensity: 3.0 }))));
}

#[test]
fn own_lights_give_the_same_bits_at_any_width() {
    for balls in [8, 70] {
        let (scene, _) = table(balls);
        let scene = with_lamp(scene).build().expect("a scene");
        let bulb = Own::new().light(Bulb { at: [0.5, 1.5, 0.5], intensity: 3.0 });
        same_bits("bulb", |renderer| renderer.render_with(&scene, &bulb).expect("a film"));
        let sky = Own::new().light(EvenSky([0.5; 3]));
        same_bits("sky", |renderer| renderer.render_with(&scene, &sky).expect("a film"));
    }
}
