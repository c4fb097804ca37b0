//! Shading normals from images.

use super::*;
use crate::renders::{self, assert_image_mean, image_mean};
use octolux::scene::{NO_NORMAL, Scene};

const SEED: u64 = 33;

/// A white square in the plane z = 0 with u along x and v along y, and a small far lamp in direction `to_lamp`; the
/// camera looks at the origin.
fn lit_square(normal: Option<Texture>, to_lamp: Point, camera: Point) -> Scene {
    let mut set = Set::new(camera, [0.0; 3], 1e-3, 8).bounces(1);
    let (white, lamp) = (set.grey(1.0, 0.0), set.grey(0.0, 1e4));
    edit(&mut set, white).maps.normal = normal;
    edit(&mut set, white).maps.strength = [1.0; 2];
    mapped_quad(&mut set, white, [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    set.sphere(lamp, to_lamp.map(|x| 100.0 * x), 0.1);
    complete(set)
}

/// The texel of a tangent-space normal.
fn texel(n: Point) -> Texture {
    let encoded = n.map(|c| (0.5 + 0.5 * c) as f32);
    image(2, 2, |_, _| encoded)
}

/// A lamp of radiance 10⁴ and sin² = 10⁻⁶ gives a white surface radiance .01 · cos.
fn check(name: &str, normal: Point, to_lamp: Point) {
    let cos = (0..3).map(|k| normal[k] * to_lamp[k]).sum::<f64>().max(0.0);
    for camera in [[0.0, 0.0, 5.0], [1.0, -2.0, 3.0]] {
        let film = renders::film(&renders::world(&lit_square(Some(texel(normal)), to_lamp, camera), SEED), 64);
        // The lamp has an extent of 10⁻³, the film's place on the square one of 10⁻⁴.
        assert_image_mean(name, &film, [0.01 * cos; 3], 2e-5, TESTS);
    }
}

/// Red turns the normal towards growing u, green towards growing v.
#[test]
fn texels_turn_the_normal() {
    let (s, c) = 30f64.to_radians().sin_cos();
    for to_lamp in [[0.0, 0.0, 1.0], [s, 0.0, c], [-s, 0.0, c], [0.0, s, c], [0.0, -s, c]] {
        for normal in [[0.0, 0.0, 1.0], [s, 0.0, c], [0.0, s, c], [0.0, -s, c]] {
            check(&format!("normal {normal:?}, lamp {to_lamp:?}"), normal, to_lamp);
        }
    }
}

/// (128, 128, 255) is flat but for the last bit of a byte: 1/255 of slope.
#[test]
fn a_flat_map_changes_nothing() {
    let bytes = Image { width: 1, height: 1, channels: 3, texels: Texels::Bytes(vec![128, 128, 255]) };
    let flat = Texture::new(Arc::new(bytes), false);
    let (to_lamp, camera) = ([0.6, 0.0, 0.8], [1.0, -2.0, 3.0]);
    let mean = |normal| image_mean(&renders::film(&renders::world(&lit_square(normal, to_lamp, camera), SEED), 64))[1];
    let (with, without) = (mean(Some(flat)).mean, mean(None).mean);
    assert!((with - without).abs() < 0.006 * without, "{with} for {without}");
}

/// Without texture coordinates that span the surface there are no tangents: the map is left aside.
#[test]
fn degenerate_coordinates_leave_the_normal_alone() {
    let (s, c) = 30f64.to_radians().sin_cos();
    let mut scene = lit_square(Some(texel([s, 0.0, c])), [0.0, 0.0, 1.0], [0.0, 0.0, 5.0]);
    scene.mesh.texcoords.iter_mut().for_each(|uv| *uv = [0.3, 0.7]);
    let film = renders::film(&renders::world(&scene, SEED), 64);
    assert_image_mean("flat without tangents", &film, [0.01; 3], 2e-5, TESTS);
    scene.mesh.texcoords.iter_mut().for_each(|uv| uv[1] = 2.0 * uv[0]);
    renders::film(&renders::world(&scene, SEED), 64);
}

/// However wild the normals, a white surface in a furnace shows no more than 1.
#[test]
fn no_energy_is_made() {
    let mut rng = crate::stats::Rng::new(7);
    let wild: Vec<[f32; 3]> = (0..64).map(|_| [rng.f32(), rng.f32(), rng.f32()]).collect();
    for (name, wild) in [("wild", wild), ("along the surface", vec![[1.0, 0.5, 0.5]; 64])] {
        let normal = image(8, 8, |x, y| wild[(y * 8 + x) as usize]);
        let mut set = Set::new([1.5, 1.0, 2.0], [0.0; 3], 40.0, 24).bounces(7).uniform_light();
        let white = set.grey(1.0, 0.0);
        edit(&mut set, white).maps.normal = Some(normal);
        edit(&mut set, white).maps.strength = [3.0; 2];
        mapped_quad(&mut set, white, [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
        set.sphere(white, [0.4, 0.4, 0.6], 0.4);
        let film = renders::film(&renders::world(&complete(set), SEED), 1024);
        let bound = crate::stats::z_bound(24 * 24 * 2);
        for (x, y) in (0..24).flat_map(|y| (0..24).map(move |x| (x, y))) {
            let (mean, variance) = (film.mean(x, y)[1], film.variance_of_mean(x, y).expect("a variance")[1]);
            assert!(mean <= 1.0 + bound * variance.sqrt() + 1e-5, "{name}, pixel {x}, {y}: {mean}");
        }
    }
}

/// Light that grazes the geometry fades (the shadow terminator; its formula worked out here), and what else is in the scene has no part
/// in that.
#[test]
fn images_of_normals_soften_as_those_of_vertices_do() {
    let tilt = 30f64.to_radians().sin_cos();
    let normal = [tilt.0, 0.0, tilt.1];
    let to_lamp = [0.995, 0.0, (1.0f64 - 0.995 * 0.995).sqrt()];
    let alone = lit_square(Some(texel(normal)), to_lamp, [0.0, 0.0, 5.0]);
    let cos = normal[0] * to_lamp[0] + normal[2] * to_lamp[2];
    let g = to_lamp[2] / (cos * normal[2]);
    let expected = 0.01 * cos * (g + g * g - g * g * g);
    let film = renders::film(&renders::world(&alone, SEED), 64);
    assert_image_mean("grazing light", &film, [expected; 3], 2e-5, TESTS);

    let mut beside = alone.clone();
    let mesh = &mut beside.mesh;
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([[0.0, 0.0, -3.0], [1.0, 0.0, -3.0], [0.0, 1.0, -3.0]]);
    mesh.triangles.push([first, first + 1, first + 2]);
    mesh.material.push(0);
    mesh.texcoord_indices.push([NO_TEXCOORD; 3]);
    mesh.normals = vec![[0.6, 0.0, 0.8]];
    mesh.normal_indices = vec![[NO_NORMAL; 3]; mesh.triangles.len() - 1];
    mesh.normal_indices.push([0; 3]);
    crate::equivalence::assert_same(
        "a smooth triangle below",
        &film,
        &renders::film(&renders::world(&beside, SEED), 64),
    );
}
