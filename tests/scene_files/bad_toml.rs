//! Scene files that must not load: each with the line that is blamed and words that the message must hold.

use super::{CAMERA, Files, TRIANGLE};
use octolux::scene::Roulette;

/// Checks `text` (with a model `a.obj` beside it): the error is on `line` and names everything in `words`.
fn refuses(text: &str, line: usize, words: &[&str]) {
    let files = Files::new(&[("scene.toml", text), ("a.obj", TRIANGLE), ("b.txt", ""), ("bad.obj", "v 0 0\n")]);
    let error = files.error("scene.toml");
    let shown = error.to_string();
    println!("{}", shown.replace(files.path("").to_str().expect("a path"), ""));
    assert_eq!(error.line, Some(line), "{shown}\n{text}");
    let place = format!("{}:{line}: ", files.path("scene.toml").display());
    assert!(shown.starts_with(&place), "{shown}");
    assert!(!shown.contains('\n'), "{shown}");
    assert!(!error.mend.is_empty());
    for word in words {
        assert!(shown.contains(word), "`{word}` is not in: {shown}");
    }
}

/// As `refuses`, for lines that follow a valid camera; `line` counts from the first of them.
fn refuses_after_camera(text: &str, line: usize, words: &[&str]) {
    refuses(&format!("{CAMERA}{text}"), line + CAMERA.lines().count(), words);
}

#[test]
fn the_table_to_break_is_valid() {
    let files = Files::new(&[("scene.toml", CAMERA)]);
    let scene = files.load("scene.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.camera.up, [0.0, 1.0, 0.0]);
    assert_eq!((scene.film.width, scene.film.height), (512, 512));
    assert_eq!(scene.integrator.max_bounces, 7);
}

#[test]
fn roulette_is_what_the_table_says() {
    let load = |text: &str| {
        let files = Files::new(&[("scene.toml", &format!("{CAMERA}{text}"))]);
        files.load("scene.toml").unwrap_or_else(|error| panic!("{error}")).integrator.roulette
    };
    assert_eq!(load(""), Roulette::default());
    assert_eq!(load("[integrator]\nroulette_after = 5\nroulette_below = 1\n"), Roulette::USUAL);
    assert_eq!(load("[integrator]\nroulette_below = 0.5\n"), Roulette { below: 0.5, ..Roulette::default() });
}

#[test]
fn syntax() {
    refuses("[camera\n", 1, &[]);
    refuses_after_camera("\n[film]\nwidth = = 3\n", 3, &[]);
    refuses_after_camera("vfov = 40\nvfov = 41\n", 2, &["duplicate"]);
    refuses("a = \"\u{7}\"", 1, &[]);
}

#[test]
fn unknown_keys() {
    refuses_after_camera("lens_radios = 0.1\n", 1, &["lens_radios", "vfov"]);
    refuses_after_camera("[filmm]\n", 1, &["filmm", "film"]);
    refuses_after_camera("[film]\nwidth = 3\nheigth = 4\n", 3, &["heigth", "height"]);
    refuses_after_camera("[environment]\nradiance = 1\nrotated = 5\n", 3, &["rotated", "rotation"]);
    refuses_after_camera("[[pointlight]]\nposition = [0, 0, 0]\n", 1, &["pointlight", "point_light"]);
    refuses_after_camera(
        "[integrator]
ambience = [1, 1, 1]
",
        2,
        &["ambience", "ambient"],
    );
    refuses_after_camera(
        "[materials.a]
type = \"diffuse\"
reflectance = 1
transparency = 0
",
        4,
        &["transparency", "opacity"],
    );
    refuses_after_camera("[materials.a]\ntype = \"phong\"\n", 2, &["phong", "diffuse"]);
    refuses_after_camera("[materials.a]\ntype = \"coated\"\nreflectance = 1\n", 2, &["coated"]);
    refuses_after_camera("[integrator]\nkind = \"photons\"\n", 2, &["photons", "path", "gather"]);
    refuses_after_camera("[materials.a]\ntype = \"diffuse\"\nreflectance = 1\nior = 1.5\n", 4, &["diffuse", "ior"]);
    refuses_after_camera("[materials.a]\ntype = \"dielectric\"\nior = 1.5\nf0 = 1\n", 4, &["dielectric", "f0"]);
}

#[test]
fn missing_keys() {
    refuses("[film]\nwidth = 3\n", 1, &["camera"]);
    refuses("\n\n[camera]\nposition = [0, 0, 0]\n", 3, &["look_at"]);
    refuses_after_camera("[materials.a]\nreflectance = 1\n", 1, &["type"]);
    refuses_after_camera("[materials.a]\ntype = \"diffuse\"\n", 2, &["reflectance"]);
    refuses_after_camera("[materials.a]\ntype = \"dielectric\"\n", 2, &["ior"]);
    refuses_after_camera("[materials.a]\ntype = \"conductor\"\n", 2, &["eta", "f0"]);
    refuses_after_camera("[materials.a]\ntype = \"conductor\"\neta = 1\n", 2, &["`k`"]);
    refuses_after_camera("[materials.a]\ntype = \"conductor\"\nf0 = 1\nreflectance = 1\n", 2, &["Fresnel"]);
    refuses_after_camera("[environment]\n", 1, &["radiance"]);
    refuses_after_camera("[[mesh]]\nflat = true\n", 1, &["file"]);
    refuses_after_camera("[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n", 1, &["material"]);
}

#[test]
fn wrong_types() {
    refuses_after_camera("vfov = \"wide\"\n", 1, &["vfov", "wide"]);
    refuses_after_camera("vfov = [1]\n", 1, &["vfov"]);
    refuses_after_camera("up = [0, 1]\n", 1, &["up", "3"]);
    refuses_after_camera("up = [0, 1, 0, 0]\n", 1, &["up"]);
    refuses_after_camera("[film]\nwidth = 2.5\n", 2, &["width"]);
    refuses_after_camera("[integrator]\nmax_bounces = 7.0\n", 2, &["max_bounces"]);
    refuses_after_camera("[[mesh]]\nfile = \"a.obj\"\nflat = 1\n", 3, &["flat"]);
    refuses_after_camera("[[mesh]]\nfile = \"a.obj\"\ntransform = [1, 0, 0]\n", 3, &["transform", "16"]);
    refuses_after_camera("[materials.a]\ntype = \"diffuse\"\nreflectance = true\n", 3, &["reflectance", "image"]);
    refuses_after_camera("[materials.a]\ntype = \"diffuse\"\nreflectance = [1, 1]\n", 3, &["reflectance"]);
    refuses_after_camera("[materials.a]\ntype = \"diffuse\"\nreflectance = [1, 1, 1, 1]\n", 3, &["reflectance"]);
    refuses_after_camera("[mesh]\nfile = \"a.obj\"\n", 1, &[]);
    refuses_after_camera("[materials]\na = 3\n", 2, &[]);
}

#[test]
fn camera_values() {
    refuses("[camera]\nposition = [0, 0, nan]\nlook_at = [0, 0, 0]\n", 2, &["position", "nan"]);
    refuses("[camera]\nposition = [0, 0, 1e39]\nlook_at = [0, 0, 0]\n", 2, &["position", "1e39"]);
    refuses("[camera]\nposition = [\n1, 1,\n1]\nlook_at = [1, 1, 1]\n", 5, &["target"]);
    refuses("[camera]\nposition = [1, 0, 0]\nlook_at = [1.00000001, 0, 0]\n", 3, &["target"]);
    refuses_after_camera("up = [0, 0, 1]\n", 1, &["parallel"]);
    refuses_after_camera("up = [0, 0, -3e-30]\n", 1, &["parallel"]);
    refuses_after_camera("up = [0, 0, 0]\n", 1, &["zero"]);
    refuses("[camera]\nposition = [0, 9, 0]\nlook_at = [0, 0, 0]\n", 3, &["parallel"]);
    for bad in ["0", "-1", "180", "179.9999999999", "inf", "nan", "1e-60"] {
        refuses_after_camera(&format!("vfov = {bad}\n"), 1, &["vfov", bad]);
    }
}

#[test]
fn lens_and_light_values() {
    refuses_after_camera("lens_radius = -0.1\n", 1, &["lens_radius", "-0.1"]);
    refuses_after_camera("focus_distance = 0\n", 1, &["focus_distance", "0"]);
    refuses_after_camera("[environment]\nradiance = 1\nrotation = inf\n", 3, &["rotation", "inf"]);
    let spot = |key: &str, value: &str| {
        let lines = [("position", "[0, 1, 0]"), ("direction", "[0, -1, 0]"), ("intensity", "5"), ("angle", "30")];
        let line = |(k, v): (&str, &str)| format!("{k} = {}\n", if k == key { value } else { v });
        format!("[[spot_light]]\n{}", lines.map(line).concat())
    };
    refuses_after_camera(&spot("position", "[0, inf, 0]"), 2, &["position"]);
    refuses_after_camera(&spot("direction", "[0, 0, 0]"), 3, &["direction", "zero"]);
    refuses_after_camera(&spot("intensity", "-5"), 4, &["intensity", "-5"]);
    for bad in ["0", "-3", "180.1", "nan"] {
        refuses_after_camera(&spot("angle", bad), 5, &["angle", bad]);
    }
    refuses_after_camera("[[point_light]]\nposition = [0, 0, 0]\n", 1, &["intensity"]);
    refuses_after_camera("[[directional_light]]\ndirection = [0, 0, 1]\nirradiance = -1\n", 3, &["irradiance", "-1"]);
    refuses_after_camera("[[directional_light]]\ndirection = [0, 0, 1]\nintensity = 1\n", 3, &["intensity"]);
    refuses_after_camera("[point_light]\nposition = [0, 0, 0]\nintensity = 1\n", 1, &["[[NAME]]"]);
}

#[test]
fn film_and_integrator_values() {
    for bad in ["0", "-3", "65537", "9223372036854775807"] {
        refuses_after_camera(&format!("[film]\nwidth = 3\nheight = {bad}\n"), 3, &["height", bad]);
    }
    refuses_after_camera("[film]\nwidth = 65536\nheight = 65536\n", 2, &["65536 x 65536"]);
    refuses_after_camera("[integrator]\nroulette_after = 0\n", 2, &["roulette_after"]);
    refuses_after_camera("[integrator]\nroulette_below = 1.5\n", 2, &["roulette_below", "[0, 1]"]);
    refuses_after_camera("[integrator]\nroulette_below = nan\n", 2, &["roulette_below"]);
    refuses_after_camera("[integrator]\nmax_bounces = -1\n", 2, &["max_bounces"]);
    refuses_after_camera("[integrator]\nmax_bounces = 4294967296\n", 2, &["max_bounces"]);
    refuses_after_camera("[integrator]\nmax_depth = 0\n", 2, &["max_depth"]);
    refuses_after_camera("[integrator]\nmax_depth = -inf\n", 2, &["max_depth"]);
}

#[test]
fn material_values() {
    let material = |kind: &str, line: &str| format!("[materials.a]\ntype = \"{kind}\"\n{line}\n");
    for bad in ["-0.1", "1.1", "nan", "[0, 0, 2]", "[nan, 0, 0]"] {
        refuses_after_camera(&material("diffuse", &format!("reflectance = {bad}")), 3, &["reflectance", bad, "[0, 1]"]);
        refuses_after_camera(&material("conductor", &format!("f0 = {bad}")), 3, &["f0", "[0, 1]"]);
    }
    for bad in ["-1e-9", "1.0000001", "nan", "inf"] {
        refuses_after_camera(&material("conductor", &format!("alpha = {bad}\nf0 = 1")), 3, &["alpha", bad]);
    }
    for bad in ["0", "-1.5", "inf", "nan", "1e-50"] {
        refuses_after_camera(&material("dielectric", &format!("ior = {bad}")), 3, &["ior", bad]);
    }
    refuses_after_camera(&material("conductor", "eta = [0, 1, 1]\nk = 1"), 3, &["eta"]);
    refuses_after_camera(&material("conductor", "eta = 1\nk = [1, -1, 1]"), 4, &["`k`"]);
    for bad in ["-1", "1.1e7", "inf", "nan"] {
        let phong = format!("diffuse = 0.5\nspecular = 0.5\nexponent = {bad}");
        refuses_after_camera(&material("phong", &phong), 5, &["exponent", bad]);
    }
    let two = "diffuse = [0.5, 0.2, 0]\nspecular = [0.4, 0.81, 0]\nexponent = 9";
    refuses_after_camera(&material("phong", two), 4, &["diffuse", "specular", "more than 1"]);
    for missing in ["diffuse", "specular", "exponent"] {
        let keys = ["diffuse", "specular", "exponent"].into_iter().filter(|key| *key != missing);
        let keys: Vec<String> = keys.map(|key| format!("{key} = 0.3")).collect();
        refuses_after_camera(&material("phong", &keys.join("\n")), 2, &["phong", missing]);
    }
    refuses_after_camera(&material("coated", "ior = 1.5"), 2, &["coated", "reflectance"]);
    refuses_after_camera(&material("coated", "reflectance = 0.5\nior = 0"), 4, &["ior"]);
    refuses_after_camera(&material("coated", "reflectance = 0.5\nior = 1.5\nexponent = 3"), 5, &["coated", "exponent"]);
    refuses_after_camera(&material("dielectric", "ior = 1.5\nmasking = \"none\""), 4, &["none", "separable"]);
    for bad in ["[1, -1, 1]", "[1e39, 0, 0]", "inf"] {
        refuses_after_camera(&material("diffuse", &format!("reflectance = 0\nemission = {bad}")), 4, &["emission"]);
        refuses_after_camera(&format!("[environment]\nradiance = {bad}\n"), 2, &["radiance"]);
    }
    refuses_after_camera("[materials.\"\"]\ntype = \"diffuse\"\nreflectance = 1\n", 1, &["name"]);
}

#[test]
fn spheres_and_meshes() {
    let wall = "[materials.wall]\ntype = \"diffuse\"\nreflectance = 1\n";
    let sphere = |center: &str, radius: &str, material: &str| {
        format!("{wall}[[sphere]]\ncenter = {center}\nradius = {radius}\nmaterial = \"{material}\"\n")
    };
    refuses_after_camera(&sphere("[0, 0, 0]", "1", "wal"), 7, &["wal"]);
    for bad in ["0", "-1", "nan", "inf", "1e-60"] {
        refuses_after_camera(&sphere("[0, 0, 0]", bad, "wall"), 6, &["radius", bad]);
    }
    refuses_after_camera(&sphere("[0, inf, 0]", "1", "wall"), 5, &["center"]);
    refuses_after_camera(&sphere("[0, 3e38, 0]", "2e38", "wall"), 6, &["precision"]);
    let mesh = |file: &str, rest: &str| format!("[[mesh]]\nfile = \"{file}\"\n{rest}\n");
    refuses_after_camera(&mesh("none.obj", ""), 2, &["none.obj", "cannot be read"]);
    refuses_after_camera(&mesh("b.txt", ""), 2, &["b.txt", ".obj"]);
    refuses_after_camera(&mesh("", ""), 2, &[".obj"]);
    let transform = |rows: &str| mesh("a.obj", &format!("transform = [{rows}]"));
    refuses_after_camera(&transform("1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1"), 3, &["singular"]);
    refuses_after_camera(&transform("1,2,3,0, 4,5,6,0, 7,8,9,0, 0,0,0,1"), 3, &["singular"]);
    refuses_after_camera(&transform("0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,1"), 3, &["singular"]);
    refuses_after_camera(&transform("1,0,0,0, 0,1,0,0, 0,0,nan,0, 0,0,0,1"), 3, &["finite"]);
    refuses_after_camera(&transform("1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1"), 3, &["last row"]);
    refuses_after_camera("[environment]\nfile = \"none.exr\"\n", 2, &["none.exr"]);
    refuses_after_camera("[environment]\nfile = \"b.txt\"\n", 2, &["b.txt", ".exr"]);
}

#[test]
fn an_error_inside_a_model_names_the_model() {
    let files =
        Files::new(&[("scene.toml", &format!("{CAMERA}[[mesh]]\nfile = \"bad.obj\"\n")), ("bad.obj", "v 0 0\n")]);
    let error = files.error("scene.toml");
    assert_eq!((error.file.clone(), error.line), (files.path("bad.obj"), Some(1)), "{error}");
}

#[test]
fn files_of_no_known_kind() {
    let files = Files::new(&[("scene.txt", CAMERA), ("latin.toml", "")]);
    assert!(files.error("scene.txt").to_string().contains(".toml"));
    assert!(files.error("none.toml").to_string().contains("cannot be read"));
    assert!(files.error("none.obj").to_string().contains("cannot be read"));
    assert!(files.error("").line.is_none());
    std::fs::write(files.path("latin.toml"), b"[camera]\n# caf\xe9\n").expect("a file");
    assert_eq!(files.error("latin.toml").line, Some(2));
}

#[test]
fn gathers() {
    let integrator = |text: &str, line: usize, words: &[&str]| {
        refuses_after_camera(&format!("[integrator]\nkind = \"gather\"\n{text}\n"), 2 + line, words);
    };
    integrator("samples = 0", 1, &["samples", "1024"]);
    integrator("samples = 4000", 1, &["samples", "1024"]);
    integrator("sets = 1000", 1, &["sets", "256"]);
    integrator("method = \"bmc is\"", 1, &["bmc is", "bmc-is"]);
    integrator("points = \"halton\"", 1, &["halton", "fibonacci"]);
    integrator("rotate = true", 1, &["rotate", "string"]);
    integrator("rotate = \"yes\"", 1, &["yes", "random"]);
    integrator("weights = \"shared\"\nlights = \"both\"", 2, &["both", "sampled"]);
    integrator("weights = \"per-hit\"\nsets = 4", 2, &["sets", "shared"]);
    integrator("method = \"mc\"\npdf = \"cosine\"", 2, &["uniform", "-is"]);
    integrator("pdf = \"uniform\"", 1, &["importance", "cosine"]);
    integrator("covariance = \"matern\"", 1, &["matern", "sobolev"]);
    integrator("covariance = \"se\"\nsmoothness = 1.5", 2, &["smoothness", "sobolev"]);
    integrator("length = 0.5", 1, &["length", "se"]);
    integrator("covariance = \"se\"\nlength = 0", 2, &["length", "0.01"]);
    integrator("smoothness = 2", 1, &["smoothness", "1.95"]);
    integrator("ambient = -1", 1, &["ambient", ">= 0"]);
}
