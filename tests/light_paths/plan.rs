//! When the plan keeps them.

use super::{flat_images, shop, with};
use crate::equivalence::scenes;
use crate::renders::{self, Set};
use octolux::plan::{Force, Plan};
use octolux::scene::{Bsdf, IntegratorKind, LightPaths, Masking, Scene};

fn kept(scene: &Scene) -> bool {
    let kept = |general| Plan::new(scene, Force { general, geometry: None }, false).light_paths;
    assert_eq!(kept(false), kept(true), "the general kernel decides alike");
    kept(false)
}

#[test]
fn where_glass_or_mirrors_focus_light() {
    assert!(kept(&shop(false)));
    assert!(!kept(&scenes::lambert_room()));
    assert!(kept(&with(scenes::lambert_room(), LightPaths::On)));
    assert!(!kept(&with(shop(false), LightPaths::Off)));
}

#[test]
fn not_where_they_cannot_be() {
    let on = |scene| with(scene, LightPaths::On);
    assert!(!kept(&on(scenes::spheres_under_a_sky())), "nothing in it emits");
    assert!(!kept(&on(scenes::everything())), "it has shading normals");
    assert!(!kept(&on(scenes::images())), "it has images of normals");
    assert!(kept(&on(flat_images())));
    let mut direct = on(shop(false));
    direct.integrator.kind = IntegratorKind::Direct;
    assert!(!kept(&direct));
    let mut set = Set::new([0.0, 0.0, 3.0], [0.0; 3], 40.0, 8);
    let glass = set.material(Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior: 1.5 }, [0.0; 3]);
    set.sphere(glass, [0.0; 3], 1.0);
    assert!(!kept(&on(set.finish())));
}

/// With no scattering at all an image is of emitters alone: a light path that is connected to the camera has scattered once.
#[test]
fn not_where_nothing_may_scatter() {
    for (wish, scene) in [(LightPaths::On, scenes::lambert_room()), (LightPaths::Auto, shop(false))] {
        let mut scene = with(scene, wish);
        scene.integrator.max_bounces = 0;
        let film = |scene: &Scene| renders::film(&renders::world(scene, 5), 8);
        let (found, alone) = (film(&scene), film(&with(scene.clone(), LightPaths::Off)));
        let pixels = (0..found.height()).flat_map(|y| (0..found.width()).map(move |x| (x, y)));
        assert!(pixels.clone().any(|(x, y)| alone.mean(x, y) != [0.0; 3]), "an emitter is seen");
        pixels.for_each(|(x, y)| assert_eq!(found.mean(x, y), alone.mean(x, y), "{}: {x},{y}", wish.name()));
        assert!(!kept(&scene));
    }
}

/// Emitters that cannot be sampled start none.
#[test]
fn an_emitter_without_area_starts_none() {
    let mut set = Set::new([0.0, 0.0, 3.0], [0.0; 3], 40.0, 8);
    let (lamp, wall) = (set.grey(0.5, 1.0), set.grey(0.5, 0.0));
    set.triangle(lamp, [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    set.sphere(wall, [0.0; 3], 0.5);
    let world = renders::world(&with(set.finish(), LightPaths::On), 1);
    assert!(world.light_paths.is_none());
    renders::film(&world, 2);
}
