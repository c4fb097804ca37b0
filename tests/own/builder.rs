//! Scenes made in code: what is out of its domain is said, and nothing panics.

use super::table;
use octolux::own::{Nothing, Own};
use octolux::scene::{Bsdf, Camera, DeltaLight, IntegratorKind, Material, SceneBuilder};
use octolux::{RenderError, Renderer};

#[track_caller]
fn refused(change: impl Fn(&mut SceneBuilder), words: &str) {
    let (mut scene, _) = table(3);
    change(&mut scene);
    let error = scene.build().expect_err(words).to_string();
    assert!(error.contains(words) && !error.contains('\n'), "{error}: does not say `{words}`");
}

#[test]
fn what_is_out_of_its_domain_is_named() {
    let one = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    refused(|s| s.mesh(&one, &[[0, 1, 7]], 0), "triangle 2: position 11 of 7");
    refused(|s| s.mesh(&one, &[[0, 1, 2]], 9), "triangle 2: material 9 of 3");
    refused(|s| s.mesh(&[[f32::NAN; 3]], &[], 0), "position 4: a coordinate is NaN");
    refused(
        |s| s.mesh_with(&one, &[[0, 1, 2]], &[[0.0, 2.0, 0.0]; 3], &[], 0),
        "normal 0: it [0.0, 2.0, 0.0] is not a unit",
    );
    refused(|s| s.mesh_with(&one, &[[0, 1, 2]], &[[0.0, 1.0, 0.0]], &[], 0), "triangle 2: normal 1 of 1");
    refused(|s| s.sphere([0.0; 3], 0.0, 0), "sphere 3: radius is 0; it must be finite and > 0");
    refused(|s| s.sphere([0.0; 3], 1.0, 3), "sphere 3: material 3 of 3");
    refused(|s| s.environment([-1.0, 0.0, 0.0]), "environment: radiance is -1");
    refused(|s| s.light(DeltaLight::Directional { direction: [0.0; 3], irradiance: [1.0; 3] }), "light 0: direction");
    refused(|s| s.light(DeltaLight::Point { position: [0.0; 3], intensity: [f32::INFINITY; 3] }), "light 0");
    refused(
        |s| {
            s.material(Bsdf::Diffuse { reflectance: [1.5; 3] });
        },
        "material 3: reflectance is 1.5; it must be in [0, 1]",
    );
    refused(
        |s| {
            s.material(Bsdf::Phong { diffuse: [0.7; 3], specular: [0.7; 3], exponent: 1.0 });
        },
        "material 3: diffuse + specular is 1.4",
    );
    refused(
        |s| {
            s.material(Material { opacity: 2.0, ..Material::default() });
        },
        "material 3: opacity is 2",
    );
}

#[test]
fn cameras_and_films_are_looked_at() {
    let refused = |camera, width, words: &str| {
        let error = SceneBuilder::new(camera, width, 8).build().expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(Camera::towards([0.0; 3], [0.0; 3], 40.0), 8, "camera: `up`");
    refused(Camera::towards([0.0; 3], [0.0, 1.0, 0.0], 40.0), 8, "camera: `up`");
    refused(Camera::towards([0.0; 3], [0.0, 0.0, 1.0], 180.0), 8, "camera: vfov is 180");
    refused(Camera::towards([0.0; 3], [0.0, 0.0, 1.0], 40.0), 0, "film: 0 × 8 pixels");
}

/// A scene changed after it was built is looked at again.
#[test]
fn a_renderer_validates() {
    let mut scene = table(3).0.build().expect("a scene");
    scene.mesh.triangles[0][1] = 1000;
    assert!(matches!(Renderer::new(1).render(&scene), Err(RenderError::Scene(_))));
    let mut scene = table(3).0.build().expect("a scene");
    scene.integrator.kind = IntegratorKind::Normals;
    let own: Own<Nothing, Nothing> = Own::new();
    assert!(matches!(Renderer::new(1).render_with(&scene, &own), Err(RenderError::NoPaths(IntegratorKind::Normals))));
}

/// Normals and texture coordinates of one mesh do not slip to another's triangles.
#[test]
fn meshes_with_and_without_normals_mix() {
    let mut scene = SceneBuilder::new(Camera::towards([0.0, 0.0, 4.0], [0.0; 3], 40.0), 8, 8);
    let grey = scene.material(Bsdf::Diffuse { reflectance: [0.5; 3] });
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let up = [[0.0, 0.0, 1.0]; 3];
    scene.mesh(&corners, &[[0, 1, 2]], grey);
    scene.mesh_with(&corners, &[[2, 1, 0]], &up, &[], grey);
    scene.mesh_with(&corners, &[[0, 1, 2]], &[], &[[0.0; 2]; 3], grey);
    let mesh = scene.build().expect("a scene").mesh;
    let none = [u32::MAX; 3];
    assert_eq!(mesh.triangles, [[0, 1, 2], [5, 4, 3], [6, 7, 8]]);
    assert_eq!(mesh.normal_indices, [none, [2, 1, 0], none]);
    assert_eq!(mesh.texcoord_indices, [none, none, [0, 1, 2]]);
}
