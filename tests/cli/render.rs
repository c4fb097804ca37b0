//! `octolux render`.

use super::{Scratch, text};
use octolux::film::read_exr;

#[test]
fn writes_an_exr_with_variance_and_metadata() {
    let scratch = Scratch::new();
    let output = scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "8", "--seed", "3", "--aovs"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let image = read_exr(&scratch.path("a.exr")).unwrap();
    assert_eq!((image.width, image.height), (24, 16));
    assert!(image.variance().is_some(), "eight samples have a variance");
    let raw = std::fs::read(scratch.path("a.exr")).unwrap();
    for channel in
        ["albedo.R", "N.X", "Z", "variance.G", "octolux.samples", "octolux.stopped_by", "octolux.cpu_features"]
    {
        assert!(raw.windows(channel.len()).any(|w| w == channel.as_bytes()), "{channel} is in the header");
    }
    assert_eq!(["samples", "seed"].map(|name| image.attribute(name).unwrap().to_string()), ["8", "3"]);
}

/// What images say of themselves is what comparing them goes by.
#[test]
fn compared_images_tell_their_samples_and_seeds() {
    let scratch = Scratch::new();
    for (file, spp) in [("few.exr", "4"), ("a.exr", "64"), ("b.exr", "128")] {
        let render =
            ["render", "scene.toml", "-o", file, "--spp", spp, "--sampler", "independent", "--path-reuse", "off"];
        assert!(scratch.run(&render).status.success());
    }
    let said = text(&scratch.run(&["compare", "a.exr", "b.exr"]).stdout);
    for note in ["samples per pixel: A 64, B 128", "both used seed 0", "64 samples against 128"] {
        assert!(said.contains(note), "{note}: {said}");
    }
    let said = text(&scratch.run(&["compare", "few.exr", "b.exr"]).stdout);
    assert!(said.contains("4 samples are few") && !said.contains("4 samples against"), "{said}");
}

#[test]
fn one_sample_has_no_variance_layer() {
    let scratch = Scratch::new();
    scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "1"]);
    assert!(read_exr(&scratch.path("a.exr")).unwrap().variance().is_none());
}

#[test]
fn json_on_standard_output_is_complete_and_alone() {
    let scratch = Scratch::new();
    let report = scratch.json(&[
        "render",
        "scene.toml",
        "-o",
        "a.exr",
        "--spp",
        "4",
        "--json",
        "-",
        "--threads",
        "2",
        "--lanes",
        "8",
    ]);
    for key in [
        "render_seconds",
        "setup_seconds",
        "wall_seconds",
        "samples_per_pixel",
        "paths_per_second",
        "rays_per_second",
        "discarded_samples",
        "lanes",
        "threads",
        "seed",
        "stopped_by",
    ] {
        assert!(!report[key].is_null(), "{key} is missing in {report}");
    }
    assert_eq!(report["samples_per_pixel"], 4);
    assert_eq!(report["discarded_samples"], 0);
    assert_eq!(report["lanes"], 8);
    assert_eq!(report["stopped_by"], "samples");
    assert_eq!(report["paths"], 24 * 16 * 4);
    let (setup, render, wall) = (&report["setup_seconds"], &report["render_seconds"], &report["wall_seconds"]);
    assert!(
        setup.as_f64().unwrap() + render.as_f64().unwrap() <= wall.as_f64().unwrap() + 0.02,
        "parts add up: {report}"
    );
}

#[test]
fn the_same_command_gives_the_same_file_contents_and_another_seed_does_not() {
    let scratch = Scratch::new();
    let pixels = |name: &str, seed: &str| {
        scratch.run(&["render", "scene.toml", "-o", name, "--spp", "4", "--seed", seed]);
        read_exr(&scratch.path(name)).unwrap().rgb().concat()
    };
    assert_eq!(pixels("a.exr", "1"), pixels("b.exr", "1"));
    assert_ne!(pixels("c.exr", "1"), pixels("d.exr", "2"));
}

#[test]
fn png_is_a_png_of_the_asked_size() {
    let scratch = Scratch::new();
    let output =
        scratch.run(&["render", "scene.toml", "--png", "a.png", "--spp", "1", "--size", "30x20", "--exposure", "-1"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(scratch.path("a.png")).unwrap()));
    let reader = decoder.read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (30, 20));
    assert!(!scratch.path("scene.exr").exists(), "with --png alone no EXR is written");
}

#[test]
fn explain_says_what_was_left_out_and_why() {
    let scratch = Scratch::new();
    let output = scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "1", "--explain"]);
    let said = text(&output.stderr);
    let line = |what: &str| said.lines().find(|l| l.contains(what)).unwrap_or_default().to_string();
    assert!(line("tree").contains("left out") && line("tree").contains("primitives"), "{said}");
    assert!(line("shading normals").contains("left out"), "{said}");
    assert!(line("environment").contains("kept"), "{said}");
    assert!(line("conductor").contains("kept"), "{said}");
}

#[test]
fn quiet_says_nothing() {
    let scratch = Scratch::new();
    let output = scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "1", "--quiet"]);
    assert_eq!((text(&output.stdout), text(&output.stderr)), (String::new(), String::new()));
    // But that the image lacks something is said.
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    let glaring = scene.replace("[20, 18, 15]", "[2e38, 2e38, 2e38]").replace("[0.2, 0.3, 0.5]", "[2e38, 2e38, 2e38]");
    std::fs::write(scratch.path("glaring.toml"), glaring).unwrap();
    let output = scratch.run(&["render", "glaring.toml", "-o", "a.exr", "--spp", "64", "--quiet"]);
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("not finite"), "{}", text(&output.stderr));
}

#[test]
fn views_read_zero_where_nothing_is_hit() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    for kind in ["normals", "depth", "hit"] {
        let view = format!("{scene}\n[integrator]\nkind = \"{kind}\"\nmax_depth = 10.0\n");
        std::fs::write(scratch.path("view.toml"), view).unwrap();
        let output = scratch.run(&["render", "view.toml", "-o", "view.exr", "--spp", "1"]);
        assert!(output.status.success(), "{kind}: {}", text(&output.stderr));
        let image = read_exr(&scratch.path("view.exr")).unwrap();
        let pixel = |x: usize, y: usize| image.rgb().map(|channel| channel[24 * y + x]);
        assert_eq!(pixel(0, 0), [0.0; 3], "{kind}: the sky is a miss");
        assert_ne!(pixel(12, 15), [0.0; 3], "{kind}: the floor is a hit");
    }
}

#[test]
fn a_view_does_not_load_the_environment() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    let image = scene.replace("radiance = [0.2, 0.3, 0.5]", "file = \"nowhere.exr\"");
    std::fs::write(scratch.path("lit.toml"), &image).unwrap();
    std::fs::write(scratch.path("view.toml"), format!("{image}\n[integrator]\nkind = \"hit\"\n")).unwrap();
    assert_eq!(scratch.run(&["render", "lit.toml", "-o", "a.exr", "--spp", "1"]).status.code(), Some(2));
    assert!(scratch.run(&["render", "view.toml", "-o", "a.exr", "--spp", "1"]).status.success());
}

/// What an image of a gather says of its variances: shared sets err alike in all samples, a hit's own do not.
#[test]
fn a_gathers_variances_say_what_they_are() {
    use octolux::film::{Attribute, VarianceValidity};
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    let render = |name: &str, integrator: &str, more: &[&str]| {
        std::fs::write(scratch.path(name), format!("{scene}\n[integrator]\nkind = \"gather\"\n{integrator}\n"))
            .unwrap();
        let all: Vec<&str> =
            ["render", name, "-o", "g.exr", "--spp", "2", "--aovs"].iter().chain(more).copied().collect();
        let output = scratch.run(&all);
        assert!(output.status.success(), "{}", text(&output.stderr));
        read_exr(&scratch.path("g.exr")).unwrap()
    };
    let shared = render("shared.toml", "samples = 16\nsets = 1", &["--state", "g.state"]);
    assert_eq!(shared.variance_validity(), Some(VarianceValidity::Shared));
    let belief = shared.channel("bmc.variance.G").expect("a posterior");
    assert!(belief.iter().any(|&v| v > 0.0) && belief.iter().all(|v| v.is_finite() && *v >= 0.0));
    assert!(matches!(shared.attribute("bmc_variance"), Some(Attribute::Text(_))));
    // The state has it too.
    let output = scratch.run(&["merge", "g.state", "-o", "again.exr", "--quiet"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let again = read_exr(&scratch.path("again.exr")).unwrap();
    assert_eq!(again.channel("bmc.variance.G").unwrap(), belief);
    assert_eq!(again.variance_validity(), Some(VarianceValidity::Shared));
    let own = render("own.toml", "samples = 16\nmethod = \"mc-is\"\nweights = \"per-hit\"", &[]);
    assert_eq!(own.variance_validity(), Some(VarianceValidity::Independent));
    assert!(own.channel("bmc.variance.G").is_none() && own.attribute("bmc_variance").is_none());
}

/// Where few samples carry the error, most renders miss some of what there is: their estimate is no upper bound then.
#[test]
fn an_error_that_is_not_to_be_trusted_is_no_bound() {
    let scratch = Scratch::new();
    let mut seen = [0, 0];
    for spp in ["2", "4", "8", "512"] {
        let said = text(&scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", spp]).stderr);
        let trusted = !said.contains("this error is not to be trusted");
        assert_eq!(said.contains(", at most: "), trusted, "{said}");
        seen[usize::from(trusted)] += 1;
    }
    assert!(seen[0] > 0 && seen[1] > 0, "{seen:?}");
}
