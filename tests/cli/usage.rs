//! Arguments that cannot be, names that mislead, keys that change nothing: one line each, which says what to do.

use super::{Scratch, text};

/// The one line of a command that must be refused, with nothing written.
fn refused(scratch: &Scratch, arguments: &[&str]) -> String {
    let files = || std::fs::read_dir(scratch.folder.path()).unwrap().count();
    let before = files();
    let output = scratch.run(arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(said.starts_with("octolux: ") && said.lines().count() == 1 && said.contains("; "), "{arguments:?}: {said}");
    assert_eq!(files(), before, "{arguments:?}");
    said
}

#[test]
fn arguments_that_cannot_be_take_one_line() {
    let scratch = Scratch::new();
    for (arguments, told) in [
        (&["render"][..], "<SCENE>; `octolux render --help`"),
        (&["compare", "a.exr"], "<B>; `octolux compare --help`"),
        (&["render", "scene.toml", "--sp", "3"], "'--sp' found; a similar argument exists: '--spp'"),
        (
            &["render", "scene.toml", "--spp", "x"],
            "'--spp <N>': must be a whole number, not below 0; `octolux render --help`",
        ),
        (
            &["render", "scene.toml", "--spp", "-1"],
            "invalid value '-1' for '--spp <N>': must be a whole number, not below 0; `octolux render",
        ),
        (&["render", "scene.toml", "--time", "-2.5"], "must be a number above 0; `octolux render"),
        (&["bench", "rays", "x", "--windows", "-1"], "'-1'"),
        (&["bench", "rays"], "; `octolux bench rays --help`"),
        (&["render", "scene.toml", "--time"], "a value is required"),
        (&["render", "scene.toml", "--adaptive", "--tile", "4"], "cannot be used with '--tile"),
        (&["render", "scene.toml", "--exposure", "1"], "--png <FILE.png>; `octolux render"),
        (
            &["completions", "cmd"],
            "[possible values: bash, elvish, fish, powershell, zsh]; `octolux completions --help`",
        ),
        (&["rendre", "scene.toml"], "a similar subcommand exists: 'render'"),
        (&["--sideways"], "'--sideways' found; `octolux --help`"),
        (&["render", "scene.toml", "--spp", "1\n\n2"], "'--spp <N>'"),
    ] {
        let said = refused(&scratch, arguments);
        // A line break in a word ends what is repeated of it.
        assert!(said.contains(told) || arguments.iter().any(|word| word.contains('\n')), "{arguments:?}: {said}");
    }
}

#[test]
fn help_and_versions_are_no_errors() {
    let scratch = Scratch::new();
    for (arguments, code) in
        [(&["--version"][..], 0), (&["--help"], 0), (&["render", "--help"], 0), (&["help", "merge"], 0), (&[], 2)]
    {
        let output = scratch.run(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        let said = if code == 0 { output.stdout } else { output.stderr };
        assert!(text(&said).contains(if arguments == ["--version"] { "octolux " } else { "Usage:" }), "{arguments:?}");
    }
}

#[test]
fn names_that_promise_another_form_are_refused() {
    let scratch = Scratch::new();
    for (arguments, told) in [
        (["-o", "a.png"], "a.png: -o writes EXR; use --png"),
        (["-o", "a.JPG"], "a.JPG: -o writes EXR; use --png"),
        (["--png", "a.exr"], "a.exr: --png writes PNG; use -o"),
        (["-o", "-"], "-: images go into files; for standard output name /dev/stdout"),
        (["--png", "-"], "-: images go into files; for standard output name /dev/stdout"),
    ] {
        for command in [&["render", "scene.toml", "--spp", "1"][..], &["merge", "a.state"]] {
            let said = refused(&scratch, &[command, &arguments].concat());
            assert!(said.contains(told), "{arguments:?}: {said}");
        }
    }
}

#[test]
fn files_that_are_not_there_are_said_with_a_mend() {
    let scratch = Scratch::new();
    std::fs::write(scratch.path("no.exr"), "text").unwrap();
    for arguments in [
        &["compare", "none.exr", "none.exr"][..],
        &["compare", "no.exr", "no.exr"],
        &["merge", "none.state", "-o", "a.exr"],
        &["bench", "rays", "none"],
        &["render", "scene.toml", "-o", "/dev/full", "--spp", "1", "--quiet"],
    ] {
        refused(&scratch, arguments);
    }
}

/// What is to be added is said as TOML has it.
#[test]
fn materials_that_are_not_there_are_named_as_a_scene_would() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    for (name, table) in
        [("steel", "[materials.steel]"), ("", "[materials.\"\"]"), ("old brass", "[materials.\"old brass\"]")]
    {
        let worn = scene.replacen("material = \"metal\"", &format!("material = \"{name}\""), 1);
        assert_ne!(worn, scene);
        std::fs::write(scratch.path("worn.toml"), worn).unwrap();
        let said = refused(&scratch, &["info", "worn.toml"]);
        assert!(said.contains(&format!("add {table}, or")), "{said}");
    }
}

#[test]
fn numbers_without_a_digit_before_the_point_are_told_how_to_be_written() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    for number in [".5", "5."] {
        std::fs::write(scratch.path("point.toml"), scene.replacen("vfov = 40", &format!("vfov = {number}"), 1))
            .unwrap();
        let said = refused(&scratch, &["info", "point.toml"]);
        assert!(said.contains("write digits on both sides of the point, as in 0.5"), "{said}");
    }
}

/// A key that this kind of integrator does not read is no error (who looks at a view changes `kind` alone), and no secret.
#[test]
fn keys_that_change_nothing_are_told() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    let with = |name: &str, integrator: &str, from: &str, to: &str| {
        assert!(scene.contains(from));
        let text = format!("{}\n[integrator]\n{integrator}", scene.replacen(from, to, 1));
        std::fs::write(scratch.path(name), text).unwrap();
        let output = scratch.run(&["info", name]);
        assert!(output.status.success(), "{name}");
        String::from_utf8(output.stderr).unwrap()
    };
    let every = "max_bounces = 3\nroulette_after = 5\nroulette_below = 0.5\nlight_paths = \"off\"\npath_reuse = \"off\"\n\
                 ambient = 0.1\nmax_depth = 2.0\nsamples = 9\nmethod = \"bmc\"\npoints = \"owen\"\npdf = \"uniform\"\n\
                 covariance = \"sobolev\"\nsmoothness = 1.5\nsets = 4\nrotate = \"none\"\nweights = \"shared\"\n\
                 shrinkage = \"none\"\nlights = \"seen\"\n";
    let keys: Vec<&str> = every.lines().map(|line| line.split_once(' ').unwrap().0).collect();
    for (kind, read) in [
        ("path", &keys[..5]),
        ("direct", &keys[..1]),
        ("gather", &[&keys[..3], &keys[7..]].concat()),
        ("phong", &keys[5..6]),
        ("depth", &keys[6..7]),
        ("normals", &[]),
        ("hit", &[]),
    ] {
        let said = with("kind.toml", &format!("kind = \"{kind}\"\n{every}"), "vfov", "vfov");
        for key in &keys {
            let told = said.contains(&format!("`{key}` changes nothing: kind = \"{kind}\" does not read it"));
            assert_eq!(told, !read.contains(key), "{kind}, {key}: {said}");
        }
        assert_eq!(said.lines().count(), keys.len() - read.len(), "{said}");
    }
    let line = 1 + scene.lines().position(|line| line.starts_with("radiance")).unwrap();
    let said = with("sky.toml", "", "[0.2, 0.3, 0.5]", "[0.2, 0.3, 0.5]\nrotation = 90");
    assert!(said.contains(&format!("sky.toml:{}: `rotation` changes nothing", line + 1)), "{said}");
    let said = with("lens.toml", "", "vfov = 40", "vfov = 40\nfocus_distance = 2.0");
    assert!(said.contains("`focus_distance` changes nothing"), "{said}");
    assert_eq!(with("lens.toml", "", "vfov = 40", "vfov = 40\nfocus_distance = 2.0\nlens_radius = 0.1"), "");
    assert_eq!(with("scene.toml", "kind = \"path\"\nmax_bounces = 3\n", "vfov", "vfov"), "");
}
