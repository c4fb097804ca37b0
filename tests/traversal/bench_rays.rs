//! `bench rays`: what it makes of files, good and bad.

use octolux::accel::Preset;
use octolux::report::bench_rays::{BenchRaysArgs, TraceMode, bench_rays};
use proptest::prelude::*;
use std::path::Path;

fn args(data: &Path) -> BenchRaysArgs {
    BenchRaysArgs {
        data: data.into(),
        sets: vec!["P".into(), "A".into()],
        lanes: vec![1, 8, 16],
        threads: vec![1, 2],
        modes: vec![TraceMode::Auto, TraceMode::Brute, TraceMode::Single, TraceMode::Packet, TraceMode::Stream],
        windows: 1,
        build: Preset::Medium,
    }
}

fn words(magic: &[u8], header: &[u32], values: &[f32]) -> Vec<u8> {
    let header = header.iter().flat_map(|w| w.to_le_bytes());
    magic.iter().copied().chain(header).chain(values.iter().flat_map(|x| x.to_le_bytes())).collect()
}

/// A square of two triangles at z = 600 seen from z = −200: coordinates that must be rescaled.
fn write_scene(dir: &Path) -> std::path::PathBuf {
    let z = 600.0;
    let square = [
        [-300.0, -300.0, z, 300.0, -300.0, z, 300.0, 300.0, z],
        [-300.0, -300.0, z, 300.0, 300.0, z, -300.0, 300.0, z],
    ];
    std::fs::write(dir.join("s.tri"), words(b"TRI0", &[2], square.as_flattened())).unwrap();
    // 32 rays straight ahead: half of them inside the square.
    let columns = |f: [&dyn Fn(usize) -> f32; 7]| -> Vec<f32> { f.iter().flat_map(|f| (0..32).map(f)).collect() };
    let x = |i: usize| if i < 16 { 16.0 * i as f32 - 130.0 } else { 400.0 };
    let rays = columns([&x, &|_| 1.0, &|_| -200.0, &|_| 0.0, &|_| 0.0, &|_| 1.0, &|_| f32::INFINITY]);
    std::fs::write(dir.join("s.P.rays"), words(b"RAY0", &[32, 0, 1], &rays)).unwrap();
    let short =
        columns([&x, &|_| 1.0, &|_| -200.0, &|_| 0.0, &|_| 0.0, &|_| 1.0, &|i| if i < 8 { 799.0 } else { 801.0 }]);
    std::fs::write(dir.join("s.A.rays"), words(b"RAY0", &[32, 1, 0], &short)).unwrap();
    dir.join("s")
}

#[test]
fn counts_and_distances_are_in_the_files_units() {
    let dir = tempfile::tempdir().unwrap();
    let report = bench_rays(&args(&write_scene(dir.path()))).unwrap();
    assert_eq!(report.sets.len(), 2 * 3 * 2 * 5);
    for set in &report.sets {
        let (hits, sum_t) = if set.set == "P" { (16, 16.0 * 800.0) } else { (8, 0.0) };
        assert_eq!((set.hits, set.rays, set.sum_t), (hits, 32, sum_t), "{set:?}");
        assert!(set.mrays_per_s > 0.0 && set.min <= set.mrays_per_s && set.mrays_per_s <= set.max, "{set:?}");
    }
}

#[test]
fn broken_files_and_arguments_are_errors_of_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let data = write_scene(dir.path());
    let tri = |bytes: &[u8]| std::fs::write(dir.path().join("s.tri"), bytes).unwrap();
    let good = std::fs::read(dir.path().join("s.tri")).unwrap();
    let complain = |args: &BenchRaysArgs, part: &str| {
        let message = bench_rays(args).expect_err(part).to_string();
        assert!(message.contains(part) && !message.contains('\n'), "{message:?} should say {part:?}");
    };
    for (bytes, part) in [
        (&b""[..], "TRI0"),
        (b"TRI", "TRI0"),
        (b"TRI0\x02\x00", "ends inside its header"),
        (&good[..good.len() - 1], "claims 2 records"),
        (b"TRI0\xff\xff\xff\xff", "at most"),
        (&words(b"TRI0", &[1], &[f32::NAN; 9]), "not a usable coordinate"),
    ] {
        tri(bytes);
        complain(&args(&data), part);
    }
    tri(&good);
    let rays = |bytes: &[u8]| std::fs::write(dir.path().join("s.P.rays"), bytes).unwrap();
    for (bytes, part) in [
        (words(b"RAY0", &[8, 0, 0], &[0.0; 56]), "multiple of 16"),
        (words(b"RAY0", &[16, 2, 0], &[0.0; 112]), "kind 2"),
        (words(b"RAY0", &[16, 0, 0], &[0.0; 111]), "claims 16 records"),
        (words(b"RAY0", &[16, 0, 0], &[f32::INFINITY; 112]), "not a usable origin"),
        (words(b"RAY0", &[16, 0, 0], &[0.0; 112]), "no direction"),
        (words(b"RAY0", &[16, 0, 0], &[[1.0; 96].as_slice(), &[f32::NAN; 16]].concat()), "t_max"),
    ] {
        rays(&bytes);
        complain(&args(&data), part);
    }
    tri(&words(b"TRI0", &[3], &[1e-38; 27]));
    rays(&words(b"RAY0", &[16, 0, 0], &[[0.0; 48].as_slice(), &[1.0; 64]].concat()));
    complain(&BenchRaysArgs { sets: vec!["P".into()], ..args(&data) }, "scale the scene");
    complain(&args(&dir.path().join("absent")), "absent.tri");
    complain(&BenchRaysArgs { lanes: vec![4], ..args(&data) }, "--lanes 4");
    complain(&BenchRaysArgs { threads: vec![0], ..args(&data) }, "--threads 0");
    complain(&BenchRaysArgs { windows: 0, ..args(&data) }, "--windows 0");
}

#[test]
fn an_empty_scene_is_timed_too() {
    let dir = tempfile::tempdir().unwrap();
    let data = write_scene(dir.path());
    std::fs::write(dir.path().join("s.tri"), words(b"TRI0", &[0], &[])).unwrap();
    let report = bench_rays(&args(&data)).unwrap();
    assert!(report.sets.iter().all(|set| set.hits == 0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_of_the_files_panics(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        truncate in any::<bool>(),
        rays in any::<bool>(),
    ) {
        let dir = tempfile::tempdir().unwrap();
        let data = write_scene(dir.path());
        let path = dir.path().join(if rays { "s.P.rays" } else { "s.tri" });
        let mut bytes = std::fs::read(&path).unwrap();
        for (at, value) in edits {
            // The headers, and as often anything.
            let at = at.index(2 * bytes.len());
            let at = if at < bytes.len() { at } else { at % 16 };
            bytes[at] = value;
        }
        if truncate {
            bytes.truncate(cut.index(bytes.len()));
        }
        std::fs::write(&path, bytes).unwrap();
        let one = BenchRaysArgs { sets: vec!["P".into()], lanes: vec![8], threads: vec![1], modes: vec![TraceMode::Packet], ..args(&data) };
        if let Err(error) = bench_rays(&one) {
            prop_assert!(!error.to_string().contains(char::is_control), "{error:?}");
        }
    }
}
