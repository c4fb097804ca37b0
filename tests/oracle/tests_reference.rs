//! The oracle against converged images of a third renderer (../shared/refs): the only test of both eyes at once.

use super::reference::{read_image, read_scene};
use super::*;
use crate::stats::shared_dir;
use octolux::scene::{Bsdf, Masking};

/// Renders the scene at 32 × 32 pixels, so that one of ours is a square of theirs (box filters), and compares blocks of
/// `block` × `block` of ours: normal enough for a z-test at `spp` samples a pixel.
fn compare(name: &str, spp: u32, block: usize) -> Option<String> {
    let refs = shared_dir()?.join("refs");
    let mut scene = read_scene(&refs.join(name));
    let theirs = read_image(&refs, name, scene.film.width as usize / 32);
    (scene.film.width, scene.film.height) = (32, 32);
    let image = render(&scene, Region::whole(&scene), spp, 17);
    for (c, e) in image.mean().into_iter().enumerate() {
        let n = theirs.len() as f64;
        let mean = theirs.iter().map(|p| p[c].mean).sum::<f64>() / n;
        println!(
            "{name} channel {c}: {:.6} ± {:.1e}, reference {mean:.6}, {:+.2} σ",
            e.mean,
            e.std_error,
            (e.mean - mean) / e.std_error
        );
    }
    image.disagreement(&theirs, block, 0.0)
}

#[track_caller]
fn assert_same(name: &str, spp: u32, block: usize) {
    if let Some(problem) = compare(name, spp, block) {
        panic!("{name}: {problem}");
    }
}

/// In quarters: where a block only just touches the sphere, a sample or none hits it and no normal test applies.
#[test]
fn furnaces_match_the_reference_renderer() {
    assert_same("furnace_diffuse05", 256, 16);
    assert_same("furnace_ggx_a0.2", 256, 16);
    assert_same("furnace_ggx_a1", 256, 16);
    assert_same("furnace_rglass_a0.5", 256, 16);
}

/// The image means that refs/README.md has by quadrature (five digits), for the masking the references do not show.
#[test]
fn furnaces_match_with_correlated_masking() {
    let Some(refs) = shared_dir().map(|d| d.join("refs")) else { return };
    let cases = [("furnace_ggx_a0.2", 0.96634), ("furnace_ggx_a1", 0.76779), ("furnace_rglass_a0.5", 0.82480)];
    for (name, mean) in cases {
        let mut scene = read_scene(&refs.join(name));
        match &mut scene.materials[0].bsdf {
            Bsdf::Conductor { masking, .. } | Bsdf::Dielectric { masking, .. } => *masking = Masking::Correlated,
            other => panic!("{name} is {other:?}"),
        }
        render(&scene, Region::whole(&scene), 64, 19).assert_mean(name, [mean; 3], 5e-6, 3 * cases.len());
    }
}

#[test]
fn cornell_boxes_match_the_reference_renderer() {
    assert_same("cornell_direct", 256, 4);
    assert_same("cornell", 256, 4);
}

/// Glossy plates see small lights by chance here: 8 × 8 of our pixels a block.
#[test]
fn veach_plates_match_the_reference_renderer() {
    assert_same("veach_mis", 256, 8);
}

/// Caustics are rare bright paths: the image in four quarters.
#[test]
fn glass_matches_the_reference_renderer() {
    assert_same("glass", 256, 16);
}
