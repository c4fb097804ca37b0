//! What a program adds of its own: through the public interface alone.

mod builder;
mod directions;
mod integrands;
mod lights;
mod materials;
mod numbers;

use crate::equivalence::assert_same;
use octolux::Renderer;
use octolux::film::Film;
use octolux::kernel::Width;
use octolux::scene::{Bsdf, Camera, DeltaLight, SceneBuilder};

const SAMPLES: u64 = 16;

/// A floor, balls of several materials and a lamp: with `balls` > 60 there is a tree. Returns the material of the first
/// ball, too.
fn table(balls: u32) -> (SceneBuilder, u32) {
    let mut scene = SceneBuilder::new(Camera::towards([0.0, 3.0, 6.0], [0.0, 0.3, 0.0], 40.0), 40, 30);
    let floor = scene.material(Bsdf::Diffuse { reflectance: [0.6, 0.5, 0.4] });
    let ball = scene.material(Bsdf::Diffuse { reflectance: [0.3, 0.6, 0.8] });
    let gloss = scene.material(Bsdf::Phong { diffuse: [0.2; 3], specular: [0.5; 3], exponent: 30.0 });
    let corners = [[-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0], [-4.0, 0.0, -4.0]];
    scene.mesh(&corners, &[[0, 1, 2], [0, 2, 3]], floor);
    for i in 0..balls {
        let (x, z) = ((i % 10) as f32 * 0.7 - 3.0, (i / 10) as f32 * 0.7 - 2.0);
        scene.sphere([x, 0.3, z], 0.3, if i % 3 == 1 { gloss } else { ball });
    }
    (scene, ball)
}

fn with_lamp(mut scene: SceneBuilder) -> SceneBuilder {
    let lamp = scene.emitter([9.0, 8.0, 7.0]);
    scene.sphere([1.0, 3.0, 1.0], 0.4, lamp);
    scene.light(DeltaLight::Point { position: [-2.0, 2.0, 1.0], intensity: [2.0; 3] });
    scene
}

/// Renders at every width, with threads and tiles that differ, and holds all to width 1 on one thread.
#[track_caller]
fn same_bits(name: &str, render: impl Fn(&Renderer) -> Film) -> Film {
    let expected = render(&Renderer::new(SAMPLES).lanes(Width::One).threads(1));
    for (width, threads, tile) in [
        (Width::One, 2, 7),
        (Width::Eight, 1, 16),
        (Width::Eight, 2, 5),
        (Width::Sixteen, 2, 16),
        (Width::Sixteen, 3, 9),
    ] {
        let found = render(&Renderer::new(SAMPLES).lanes(width).threads(threads).tile(tile));
        assert_same(&format!("{name}, {} lanes, {threads} threads, tile {tile}", width.lanes()), &found, &expected);
    }
    let lit = (0..expected.height()).any(|y| (0..expected.width()).any(|x| expected.mean(x, y)[0] > 0.01));
    assert!(lit, "{name}: nothing is seen");
    expected
}
