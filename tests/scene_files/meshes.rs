//! What becomes of triangles, normals and materials on their way into the scene.

use super::references::check_invariants;
use super::{CAMERA, Files, TRIANGLE};
use octolux::scene::{Bsdf, ConductorFresnel, Masking, NO_NORMAL, Scene};

fn scene_of(obj: &str, mesh: &str) -> Scene {
    let files = Files::new(&[("scene.toml", &format!("{CAMERA}[[mesh]]\nfile = \"a.obj\"\n{mesh}\n")), ("a.obj", obj)]);
    loaded(&files, "scene.toml")
}

fn loaded(files: &Files, name: &str) -> Scene {
    let scene = files.load(name).unwrap_or_else(|error| panic!("{error}"));
    check_invariants(&scene);
    scene
}

fn corners(scene: &Scene, triangle: usize) -> [[f32; 3]; 3] {
    scene.mesh.triangles[triangle].map(|i| scene.mesh.positions[i as usize])
}

/// Twice the area times the unit normal of the counter-clockwise side.
fn normal_of([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn shading_normal(scene: &Scene, triangle: usize, corner: usize) -> [f32; 3] {
    scene.mesh.normals[scene.mesh.normal_indices[triangle][corner] as usize]
}

#[test]
fn polygons_become_fans_in_file_order() {
    let obj = "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 1 2 0\nv -1 1 0\nf 1 2 3 4 5\nf 5/1/1 -4 -3\nf 1 2 3 4\nvt 0 0\nvn 0 0 1\n";
    let scene = scene_of(obj, "");
    let [a, b, c, d, e] = [[0., 0., 0.], [2., 0., 0.], [3., 1., 0.], [1., 2., 0.], [-1., 1., 0.]];
    let expected = [[a, b, c], [a, c, d], [a, d, e], [e, b, c], [a, b, c], [a, c, d]];
    let found: Vec<_> = (0..scene.mesh.triangles.len()).map(|i| corners(&scene, i)).collect();
    assert_eq!(found, expected);
}

#[test]
fn degenerate_triangles_keep_their_place() {
    let scene = scene_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 1\nf 1 2 3\nf 1 2 2\n", "");
    assert_eq!(scene.mesh.triangles.len(), 3);
    assert_eq!(normal_of(corners(&scene, 1)), [0.0, 0.0, 1.0]);
}

#[test]
fn a_transform_is_row_major_with_the_translation_last_in_each_row() {
    let scene = scene_of(TRIANGLE, "transform = [0, -2, 0, 10,  1, 0, 0, 20,  0, 0, 3, 30,  0, 0, 0, 1]");
    assert_eq!(corners(&scene, 0), [[10., 20., 30.], [10., 21., 30.], [8., 20., 30.]]);
}

#[test]
fn without_a_transform_positions_keep_their_bits() {
    let scene = scene_of("v -0.0 0.1 1e-40\nv 3.4e38 0 0\nv 0 1 0\nf 1 2 3\n", "");
    let bits = |p: [f32; 3]| p.map(f32::to_bits);
    assert_eq!(bits(scene.mesh.positions[0]), bits([-0.0, 0.1, 1e-40]));
    assert_eq!(scene.mesh.positions[1][0], 3.4e38);
}

#[test]
fn a_transform_that_overflows_is_an_error() {
    let files = Files::new(&[
        (
            "scene.toml",
            &format!("{CAMERA}[[mesh]]\nfile = \"a.obj\"\ntransform = [1e20,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"),
        ),
        ("a.obj", "v 1e20 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"),
    ]);
    assert!(files.error("scene.toml").to_string().contains("precision"));
}

#[test]
fn fronts_follow_their_normals_through_mirrors_and_shears() {
    // A tilted triangle whose three vertex normals are its own geometric normal.
    let obj = "v 1 0 0\nv 0 2 0\nv 0 0 3\nvn 6 3 2\nf 1//1 2//1 3//1\n";
    for rows in [
        "1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1",
        "-1,0,0,5, 0,1,0,0, 0,0,1,0, 0,0,0,1",
        "-1,0,0,0, 0,-2,0,0, 0,0,-3,0, 0,0,0,1",
        "0,1,0,0, 1,0,0,0, 0,0,1,9, 0,0,0,1",
        "1,2,0,0, 0,1,0,0, 0,5,-1,0, 0,0,0,1",
        "1e-6,2e-6,0,0, 0,1e-6,0,0, 0,5e-6,1e-6,0, 0,0,0,1",
    ] {
        let scene = scene_of(obj, &format!("transform = [{rows}]"));
        let geometric = normal_of(corners(&scene, 0)).map(f64::from);
        let length = geometric.iter().map(|c| c * c).sum::<f64>().sqrt();
        for corner in 0..3 {
            let shading = shading_normal(&scene, 0, corner).map(f64::from);
            let cosine: f64 = geometric.iter().zip(shading).map(|(g, s)| g / length * s).sum();
            // The cosine of an angle of a few f32 ulps (edges, their products, the normal) is within its square of 1;
            // what is left is rounding of the sum itself.
            assert!(cosine > 1.0 - 4.0 * f64::from(f32::EPSILON), "{rows}: {cosine}");
        }
    }
}

#[test]
fn a_mirrored_triangle_keeps_each_normal_at_its_corner() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 1 0 1\nvn 0 1 1\nf 1//1 2//2 3//3\n";
    let scene = scene_of(obj, "transform = [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]");
    let half = std::f32::consts::FRAC_1_SQRT_2;
    for corner in 0..3 {
        let [x, y, _] = corners(&scene, 0)[corner];
        let expected = if x < 0.0 {
            [-half, 0.0, half]
        } else if y > 0.0 {
            [0.0, half, half]
        } else {
            [0.0, 0.0, 1.0]
        };
        assert_eq!(shading_normal(&scene, 0, corner), expected);
    }
    assert!(normal_of(corners(&scene, 0))[2] > 0.0);
}

#[test]
fn normals_without_direction_make_their_triangle_flat() {
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\n";
    for bad in ["0 0 0", "nan 0 1", "inf 0 0", "0 -inf 0"] {
        let scene = scene_of(&format!("{head}vn {bad}\nf 1//1 2//1 3//1\nf 1//1 2//2 3//1\nf 1//1 2//1 3//1\n"), "");
        assert_eq!(scene.mesh.normal_indices[1], [NO_NORMAL; 3], "{bad}");
        for triangle in [0, 2] {
            assert_eq!(shading_normal(&scene, triangle, 1), [0.0, 0.0, 1.0], "{bad}");
        }
        let scene = scene_of(&format!("{head}vn {bad}\nf 1//2 2//2 3//2\n"), "");
        assert!(scene.mesh.normals.is_empty() && scene.mesh.normal_indices.is_empty(), "{bad}");
    }
    // So short that their squares vanish in single precision: still a direction.
    let scene = scene_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 1e-30 0\nf 1//1 2//1 3//1\n", "");
    assert_eq!(shading_normal(&scene, 0, 0), [0.0, 1.0, 0.0]);
}

#[test]
fn faces_without_normals_get_none_of_their_neighbours() {
    let faces = ["f 1 2 3", "f 1//1 2//1 3//1", "f 1 2 3 4", "f 1//1 2//1 3", "f 1//2 2//2 3//2 4//2", "f 4 2 1"];
    let obj = format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 1 0 0\n{}\n", faces.join("\n"));
    let scene = scene_of(&obj, "");
    let has: Vec<bool> = scene.mesh.normal_indices.iter().map(|t| t[0] != NO_NORMAL).collect();
    assert_eq!(has, [false, true, false, false, false, true, true, false]);
    assert_eq!(shading_normal(&scene, 1, 2), [0.0, 0.0, 1.0]);
    assert_eq!(shading_normal(&scene, 6, 2), [1.0, 0.0, 0.0]);
    let flat = scene_of(&obj, "flat = true");
    assert!(flat.mesh.normals.is_empty() && flat.mesh.normal_indices.is_empty());
}

/// What tobj is given leaves texture coordinates out and nothing else, be indices counted from either end.
#[test]
fn normals_stay_beside_texture_coordinates() {
    let faces = ["f 1/1/2 2/1/2 3/1/2", "f -4/-1/-2 -3/-1/-2 -1/-1/-2", "f 1/1 2/1 3/1", "f 1/1 2//1 3/1/1"];
    let obj = format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nvn 1 0 0\n{}\n", faces.join("\n"));
    let scene = scene_of(&obj, "");
    let has: Vec<bool> = scene.mesh.normal_indices.iter().map(|t| t[0] != NO_NORMAL).collect();
    assert_eq!(has, [true, true, false, false]);
    assert_eq!(shading_normal(&scene, 0, 2), [1.0, 0.0, 0.0]);
    assert_eq!(shading_normal(&scene, 1, 0), [0.0, 0.0, 1.0]);
    assert_eq!(corners(&scene, 1), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn meshes_are_concatenated() {
    let smooth = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
    let meshes = "[[mesh]]\nfile = \"a.obj\"\n[[mesh]]\nfile = \"b.obj\"\n[[mesh]]\nfile = \"a.obj\"\n\
                  transform = [1,0,0,7, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n";
    let files = Files::new(&[("scene.toml", &format!("{CAMERA}{meshes}")), ("a.obj", TRIANGLE), ("b.obj", smooth)]);
    let scene = loaded(&files, "scene.toml");
    assert_eq!(scene.mesh.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    assert_eq!(corners(&scene, 2)[0], [7.0, 0.0, 0.0]);
    assert_eq!(scene.mesh.normal_indices, [[NO_NORMAL; 3], [0; 3], [NO_NORMAL; 3]]);
    assert_eq!(scene.assumptions.len(), 2, "one grey for each model: {:?}", scene.assumptions);
}

#[test]
fn materials_go_by_name_and_the_scene_file_wins() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 3 2 1\nusemtl with space\nf 1 2 3\nusemtl wall\nf 1 2 3\n\
               o again\nusemtl with space\nf 1 2 3\nf 2 3 1\n";
    let mtl = "newmtl with space\nKd .1 .2 .3\nKe 1 2 3\nnewmtl wall\nKd .5 .5 .5\nnewmtl unworn\nKd 7 7 7\n";
    let toml = format!(
        "{CAMERA}[[mesh]]\nfile = \"a.obj\"\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"wall\"\n\
         [materials.wall]\ntype = \"conductor\"\nalpha = 0.25\nf0 = [1, 0.5, 0.25]\n"
    );
    let scene = loaded(&Files::new(&[("scene.toml", &toml), ("a.obj", obj), ("a.mtl", mtl)]), "scene.toml");
    let worn: Vec<&str> = scene.mesh.material.iter().map(|&m| scene.materials[m as usize].name.as_str()).collect();
    assert_eq!(worn, ["", "with space", "wall", "with space", "with space"]);
    assert_eq!(scene.materials.len(), 3);
    let material = |name: &str| scene.materials.iter().find(|m| m.name == name).expect("the material");
    assert_eq!(material("with space").bsdf, Bsdf::Diffuse { reflectance: [0.1, 0.2, 0.3] });
    assert_eq!(material("with space").emission, [1.0, 2.0, 3.0]);
    let fresnel = ConductorFresnel::Schlick { f0: [1.0, 0.5, 0.25] };
    assert_eq!(material("wall").bsdf, Bsdf::Conductor { alpha: 0.25, masking: Masking::Correlated, fresnel });
    assert_eq!(scene.materials[scene.spheres[0].material as usize].name, "wall");
}

#[test]
fn the_same_name_in_two_libraries_is_two_materials() {
    let obj = |mtl: &str| format!("mtllib {mtl}\n{}", TRIANGLE.replace("f ", "usemtl m\nf "));
    let meshes = "[[mesh]]\nfile = \"a.obj\"\n[[mesh]]\nfile = \"b.obj\"\n[[mesh]]\nfile = \"a.obj\"\n";
    let files = Files::new(&[
        ("scene.toml", &format!("{CAMERA}{meshes}")),
        ("a.obj", &obj("a.mtl")),
        ("b.obj", &obj("none.mtl b.mtl")),
        ("a.mtl", "newmtl m\nKd 0 0 0\n"),
        ("b.mtl", "newmtl m\nKd 1\n"),
    ]);
    let scene = loaded(&files, "scene.toml");
    assert_eq!(scene.mesh.material, [0, 1, 0]);
    assert_eq!(scene.materials[1].bsdf, Bsdf::Diffuse { reflectance: [1.0; 3] });
}

#[test]
fn mtl_models() {
    let bsdf = |lines: &str| {
        let obj = format!("mtllib a.mtl\n{}", TRIANGLE.replace("f ", "usemtl m\nf "));
        let files = Files::new(&[("a.obj", &obj), ("a.mtl", &format!("newmtl m\n{lines}\n"))]);
        loaded(&files, "a.obj").materials[0].bsdf
    };
    let glass = |ior| Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior };
    let metal = |alpha, fresnel| Bsdf::Conductor { alpha, masking: Masking::Correlated, fresnel };
    for illum in [4, 6, 7, 9] {
        assert_eq!(bsdf(&format!("illum {illum}\nNi 1.25\nd .1\nPm 1")), glass(1.25));
    }
    assert_eq!(bsdf("illum 7"), glass(1.5));
    assert_eq!(bsdf("illum 5"), metal(0.0, ConductorFresnel::Constant { reflectance: [1.0; 3] }));
    assert_eq!(bsdf("illum 5\nKs .5 .25 1"), metal(0.0, ConductorFresnel::Constant { reflectance: [0.5, 0.25, 1.0] }));
    let gold = ConductorFresnel::Schlick { f0: [1.0, 0.5, 0.25] };
    assert_eq!(bsdf("Kd 1 .5 .25\nPm .5\nPr .5"), metal(0.25, gold));
    assert_eq!(bsdf("Kd 1 .5 .25\nPm 1"), metal(0.25, gold));
    let wall = Bsdf::Diffuse { reflectance: [1.0, 0.5, 0.25] };
    for lines in ["Pm .4", "Ks 1 1 1\nNs 0", "Ks 1 1 1\nNs -2", "Ks 0 0 0\nNs 9", "Ks 1 0 0\nNs 9", "d .5"] {
        assert_eq!(bsdf(&format!("Kd 1 .5 .25\n{lines}")), wall, "{lines}");
    }
    for lines in ["illum 3 # mirror", "Tr 1", "Ks 1 1 1"] {
        assert_eq!(bsdf(&format!("Kd 1 .5 .25\n{lines}")), wall, "{lines}");
    }
    let shiny = |specular, exponent| Bsdf::Phong { diffuse: [1.0, 0.5, 0.25], specular, exponent };
    assert_eq!(bsdf("Kd 1 .5 .25\nillum 2\nKs 1 .25 .5\nNs 10"), shiny([0.0, 0.25, 0.5], 10.0));
    assert_eq!(bsdf("Kd 1 .5 .25\nKs 3 3 3\nNs 1e9"), shiny([0.0, 0.5, 0.75], 1e7));
    let coat = |alpha, ior| Bsdf::Coated { reflectance: [1.0, 0.5, 0.25], alpha, masking: Masking::Correlated, ior };
    assert_eq!(bsdf("Kd 1 .5 .25\nPr .5\nKs 1 1 1\nNs 10"), coat(0.25, 1.5));
    assert_eq!(bsdf("Kd 1 .5 .25\nPm .4\nPr 0\nNi 1.25"), coat(0.0, 1.25));
    assert_eq!(bsdf("illum 2"), Bsdf::Diffuse { reflectance: [0.8; 3] });
}

#[test]
fn files_as_others_write_them() {
    let obj = "\u{feff}# DOS, tabs, comments, colours\r\nmtllib  none.mtl\r\n\r\nv\t0 0 0 1.0 # here\r\n  v 1 0 0\r\nv 0 1 0 .5 .5 .5\r\n\
               vn 0 0 1\r\nvt 0\r\ng\r\ns off\r\nf  1/1/1  2/1/1 3/1/1 # there\r\nl 1 2 3\r\np 1\r\n";
    let scene = scene_of(obj, "");
    assert_eq!(corners(&scene, 0), [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
    assert_eq!(scene.mesh.triangles.len(), 1);
    let latin: Vec<u8> = b"mtllib a.mtl\nusemtl caf\xe9\n".iter().chain(TRIANGLE.as_bytes()).copied().collect();
    let files = Files::new(&[]);
    std::fs::write(files.path("a.obj"), latin).expect("a file");
    std::fs::write(files.path("a.mtl"), b"newmtl caf\xe9\nKd 1 1 1\n").expect("a file");
    assert_eq!(loaded(&files, "a.obj").materials[0].bsdf, Bsdf::Diffuse { reflectance: [1.0; 3] });
}

/// A `\` at the end of a line takes in the next, in models and libraries, with the coordinates of textures too; in a
/// comment it does not, and what comes after keeps its line number.
#[test]
fn lines_go_on_after_a_backslash() {
    let mtl = "newmtl \\\nm\nKd 1 \\\n.5 .25\nmap_Kd \\\r\na.png\n";
    let obj = "mtllib \\\na.mtl\n# C:\\models\\\nv 0 0 \\\n0\nv 1 \\\r\n0 \\ \r\n 0\nv 0 1 0 # in C:\\\nv -1 0\\\n0\nvt 0 0\nvt 1\\\n0\n\
               vt 0 1\nusemtl \\\nm\nf 1/1 2/2\\\n3/3 \\\n\\\n4/1 \\";
    let files = Files::new(&[("a.obj", obj), ("a.mtl", mtl)]);
    let file = std::fs::File::create(files.path("a.png")).expect("a file");
    let image = png::Encoder::new(file, 1, 1).write_header().and_then(|mut writer| writer.write_image_data(&[0]));
    image.expect("an image");
    let scene = loaded(&files, "a.obj");
    let [a, b, c, d] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.]];
    assert_eq!([0, 1].map(|i| corners(&scene, i)), [[a, b, c], [a, c, d]]);
    let uv = |i: u32| scene.mesh.texcoords[i as usize];
    let [first, second, third] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let found: Vec<_> = scene.mesh.texcoord_indices.iter().map(|corners| corners.map(uv)).collect();
    assert_eq!(found, [[first, second, third], [first, third, first]]);

    let error = Files::new(&[("a.obj", "v 0 0 \\\n0\nv 1 0 \\\n x\n")]).error("a.obj");
    assert_eq!(error.line, Some(3), "{error}");
    let error = Files::new(&[("a.obj", "v 0 0 \\\n0\nv 1 0 x\n")]).error("a.obj");
    assert_eq!(error.line, Some(3), "{error}");
}

/// Concave faces are covered once by their triangles, wherever the file starts them and however it is placed.
#[test]
fn concave_faces_keep_their_shape() {
    let bracket = [[0, 0], [6, 0], [6, 1], [1, 1], [1, 7], [0, 7]];
    let star: Vec<[i32; 2]> = (0..10)
        .map(|i| {
            let (s, c) = (f64::from(i) * std::f64::consts::PI / 5.0).sin_cos();
            let r = if i % 2 == 0 { 1000.0 } else { 300.0 };
            [(r * c) as i32, (r * s) as i32]
        })
        .collect();
    // A square with a square hole, joined by a slit.
    let frame = [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [3, 3], [3, 6], [6, 6], [6, 3], [3, 3]];
    let arrow = [[0, 0], [4, 0], [1, 1], [0, 4]];
    for ring in [&bracket[..], &star[..], &frame[..], &arrow[..]] {
        let n = ring.len();
        for (start, mirrors) in (0..n).flat_map(|start| [(start, false), (start, true)]) {
            let mut obj: String = ring.iter().map(|[x, y]| format!("v {x} {y} 7\nvn {x} 0 1\n")).collect();
            let face: String = (0..n).map(|i| format!(" {0}//{0}", (start + i) % n + 1)).collect();
            obj.push_str(&format!("f{face}\n"));
            let transform = if mirrors { "transform = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]" } else { "" };
            let toml = format!("{CAMERA}[[mesh]]\nfile = \"a.obj\"\n{transform}\n");
            let scene = loaded(&Files::new(&[("scene.toml", &toml), ("a.obj", &obj)]), "scene.toml");
            assert_eq!(scene.mesh.triangles.len(), n - 2);
            let area = |p: [[f32; 3]; 3]| {
                let edge = |i: usize, k: usize| f64::from(p[i][k]) - f64::from(p[0][k]);
                0.5 * (edge(1, 0) * edge(2, 1) - edge(1, 1) * edge(2, 0))
            };
            let areas: Vec<f64> = (0..n - 2).map(|i| area(corners(&scene, i))).collect();
            let expected: f64 = (0..n)
                .map(|i| {
                    let ([x0, y0], [x1, y1]) = (ring[i], ring[(i + 1) % n]);
                    0.5 * f64::from(x0 * y1 - x1 * y0)
                })
                .sum();
            // Triangles that all turn one way and sum to the area overlap nowhere.
            assert!(areas.iter().all(|&a| a >= 0.0), "{ring:?} from {start}: {areas:?}");
            assert!((areas.iter().sum::<f64>() - expected).abs() < 1e-6 * expected, "{ring:?} from {start}: {areas:?}");
            for (triangle, normals) in scene.mesh.triangles.iter().zip(&scene.mesh.normal_indices) {
                assert!(triangle.iter().zip(normals).all(|(v, n)| v == n), "normals stay with their corners");
            }
        }
    }
}
