//! Models that must not load, each with the line that is blamed.

use super::Files;

const MTL: &str = "newmtl red\nKd 1 0 0\n";

/// Checks that the model is refused on `line` of `file`, with a message that holds `words`.
fn refuses_at(files: &Files, file: &str, line: Option<usize>, words: &[&str]) {
    let error = files.error("a.obj");
    let shown = error.to_string();
    println!("{}", shown.replace(files.path("").to_str().expect("a path"), ""));
    assert_eq!((error.file.clone(), error.line), (files.path(file), line), "{shown}");
    assert!(!shown.contains('\n') && !error.mend.is_empty(), "{shown}");
    for word in words {
        assert!(shown.contains(word), "`{word}` is not in: {shown}");
    }
}

fn refuses(obj: &str, line: usize, words: &[&str]) {
    refuses_at(&Files::new(&[("a.obj", obj), ("a.mtl", MTL)]), "a.obj", Some(line), words);
}

fn refuses_mtl(mtl: &str, line: usize, words: &[&str]) {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    refuses_at(&Files::new(&[("a.obj", obj), ("a.mtl", mtl)]), "a.mtl", Some(line), words);
}

#[test]
fn vertices() {
    for bad in ["nan", "inf", "-inf", "1e39", "x", "1,5", "\\"] {
        refuses(&format!("# a\nv 0 0 0\nv 0 {bad} 0\n"), 3, &[bad]);
    }
    refuses("v 0 0\n", 1, &["three"]);
    refuses("v\n", 1, &["three"]);
    refuses("v 0 0 # 0\n", 1, &["three"]);
    refuses("\n\nvn 0 0\n", 3, &["three"]);
    refuses("vn 0 0 z\n", 1, &["z"]);
    refuses("vt a 0\n", 1, &["texture"]);
}

#[test]
fn faces() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\n";
    let face = |corners: &str, words: &[&str]| refuses(&format!("{vertices}f 1 2 3\nf {corners}\n"), 7, words);
    face("1 2 4", &["vertex 4", "3"]);
    face("1 2 0", &["vertex 0"]);
    face("1 2 -4", &["vertex -4"]);
    face("1//1 2//1 3//2", &["normal 2"]);
    face("1//1 2//0 3//1", &["normal 0"]);
    face("1/1 2/1 3/9", &["texture coordinate 9"]);
    face("1//-2 2//1 3//1", &["normal -2"]);
    face("1 2", &["3 corners"]);
    face("1", &["3 corners"]);
    face("", &["3 corners"]);
    face("1 2 x", &["x"]);
    face("1 2 3.0", &["3.0"]);
    face("1 2 3/1/1/1", &["too many"]);
    face("1 2 /1/1", &["no vertex"]);
    // Where tobj's arithmetic would wrap around.
    face("1 2 4294967296", &["4294967296"]);
    face("1//1 2//1 3//6148914691236517206", &["6148914691236517206"]);
    face("1 2 9223372036854775807", &["9223372036854775807"]);
    face("1 2 -9223372036854775808", &["-9223372036854775808"]);
    face("1 2 9223372036854775808", &["9223372036854775808"]);
}

#[test]
fn definitions_that_come_too_late() {
    let late = "v 0 0 0\nv 1 0 0\nusemtl red\nf 1 2 3\nusemtl blue\nv 0 1 0\nf 1 2 3\n";
    refuses(late, 4, &["vertex 3", "before"]);
    let normals = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3//1\nmtllib a.mtl\nusemtl red\nvn 0 0 1\nf 1 2 3\n";
    refuses(normals, 4, &["normal 1", "before"]);
    // Later in the same group they do no harm.
    let obj = "f 1//1 2//1 3//1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n";
    let scene = Files::new(&[("a.obj", obj)]).load("a.obj").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((scene.mesh.positions.len(), scene.mesh.normals.len()), (3, 1));
}

#[test]
fn nothing_to_render() {
    refuses_at(&Files::new(&[("a.obj", "")]), "a.obj", None, &["no faces"]);
    refuses_at(&Files::new(&[("a.obj", "v 0 0 0\nl 1 1\np 1\n")]), "a.obj", None, &["no faces"]);
}

#[test]
fn materials_that_are_not_there() {
    let obj = |head: &str| format!("{head}v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl blue\nf 1 2 3\n");
    refuses(&obj(""), 4, &["blue", "no `mtllib`", "[materials.blue]"]);
    refuses(&obj("mtllib a.mtl\n"), 5, &["blue"]);
    refuses(&obj("mtllib none.mtl\n"), 5, &["blue", "none.mtl", "cannot be read"]);
    refuses("v 0 0 0\nusemtl\n", 2, &["usemtl"]);
    refuses("mtllib \n", 1, &["mtllib"]);
}

#[test]
fn material_libraries() {
    refuses_mtl("Kd 1 1 1\n", 1, &["newmtl"]);
    refuses_mtl("newmtl\n", 1, &["name"]);
    for bad in ["1 0", "1 0 x", "1 0 nan", "1 0 1e39", "", "spectral file.rfl", "1 1 1 1"] {
        refuses_mtl(&format!("newmtl m\n\nKd {bad}\n"), 3, &["Kd"]);
    }
    for key in ["Ns", "Ni", "d", "Pr", "Pm", "Tr"] {
        refuses_mtl(&format!("newmtl m\n{key} x\n"), 2, &[key]);
        refuses_mtl(&format!("newmtl m\n{key}\n"), 2, &[key]);
    }
    for bad in ["-1", "11", "2.5", "x", "", "300"] {
        refuses_mtl(&format!("newmtl m\nillum {bad}\n"), 2, &["illum"]);
    }
    refuses_mtl("newmtl m\nmap_Kd\n", 2, &["map_Kd"]);
}

#[test]
fn material_values_out_of_their_domain() {
    refuses_mtl("newmtl m\nKd 0.5 1.5 0.5\n", 2, &["Kd", "1.5", "[0, 1]"]);
    refuses_mtl("newmtl m\nKd 0.5 -0.5 0.5\n", 2, &["Kd"]);
    refuses_mtl("newmtl m\nKd 1 1 1\nKe 0 0 -1\n", 3, &["Ke"]);
    refuses_mtl("newmtl m\nKd 1 1 1\nillum 7\nNi 0\n", 4, &["Ni"]);
    refuses_mtl("newmtl m\nKs 2 1 1\nillum 5\n", 2, &["Ks"]);
    refuses_mtl("newmtl m\nKd 1 1 1\nPm 1.5\n", 3, &["Pm"]);
    refuses_mtl("newmtl m\nKd 1 1 1\nPm 1\nPr -1\n", 4, &["Pr"]);
}

#[test]
fn values_of_materials_that_nothing_wears_do_not_matter() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nusemtl n\nf 1 2 3\n";
    let files = Files::new(&[("a.obj", obj), ("a.mtl", "newmtl m\nKd 9 9 9\nnewmtl n\nKd .5 .5 .5\n")]);
    let scene = files.load("a.obj").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].name, "n");
}
