//! The scenes of `scenes/`: they load, render without a sample lost, and keep their bits.

use super::assert_same;
use crate::renders::{How, film_on, forced, world};
use octolux::kernel::Width;
use octolux::plan::{Force, GeometryMode};
use octolux::render::thread_pool;
use octolux::scene::{self, FilmSize, Scene};
use std::path::Path;

const NAMES: [&str; 9] =
    ["cornell", "course", "courtyard", "furnace", "isothermal", "lens", "stage", "sun-sky", "veach"];

fn load(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).join("scene.toml");
    let mut scene = scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    scene.film = FilmSize { width: 24, height: 18 };
    scene
}

#[test]
fn shipped_scenes_keep_their_bits() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folders = std::fs::read_dir(folder).expect("scenes").filter(|e| e.as_ref().is_ok_and(|e| e.path().is_dir()));
    assert_eq!(folders.count(), NAMES.len(), "a scene is missing from the list");
    let pool = thread_pool(2).expect("threads");
    let general = Force { general: true, geometry: Some(GeometryMode::Tree) };
    for name in NAMES {
        let scene = load(name);
        let expected = film_on(&pool, &forced(&scene, 23, general), 8, How { width: Width::One, tile: 16 });
        for width in Width::ALL {
            let found = film_on(&pool, &world(&scene, 23), 8, How { width, tile: 9 });
            assert_same(&format!("{name}, {} lanes", width.lanes()), &found, &expected);
        }
    }
}

/// The box is lit from above and sealed but for its front: every ray from the camera hits something it can see the
/// front of, so that no wall was wound the wrong way.
#[test]
fn the_cornell_box_faces_its_room() {
    let scene = load("cornell");
    let mesh = &scene.mesh;
    let eye = [278.0, 273.0, 279.6]; // the middle of the room, outside both blocks
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].map(f64::from));
        let edge = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| p[k] - a[k]) };
        let (u, v, w) = (edge(b), edge(c), edge(eye));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let facing = (0..3).map(|k| n[k] * w[k]).sum::<f64>();
        let wall = [a, b, c].iter().all(|p| outermost(*p));
        assert!(!wall || facing > 0.0, "triangle {i} of the room faces outwards");
    }
    let lamp = mesh.material.iter().filter(|&&m| scene.materials[m as usize].emission[0] > 0.0).count();
    assert_eq!(lamp, 2);
}

/// Is the point on a wall, the floor, the ceiling or the lamp, not on a block above the floor?
fn outermost([x, y, z]: [f64; 3]) -> bool {
    y > 540.0 || !(1.0..=549.0).contains(&x) || z > 550.0
}
