#![no_main]
//! Any bytes as triangles and rays: a length in two bytes, that many bytes of `.tri`, the rest `.rays`.

mod common;

use octolux::accel::Preset;
use octolux::report::bench_rays::{BenchRaysArgs, TraceMode, bench_rays};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((length, rest)) = data.split_first_chunk::<2>() else { return };
    let (triangles, rays) = rest.split_at(rest.len().min(u16::from_le_bytes(*length) as usize));
    let data = common::folder().join("fuzz");
    std::fs::write(data.with_extension("tri"), triangles).expect("a scratch file");
    std::fs::write(data.with_extension("P.rays"), rays).expect("a scratch file");
    let args = BenchRaysArgs {
        data,
        sets: vec!["P".into()],
        lanes: vec![8],
        threads: vec![1],
        modes: vec![TraceMode::Packet, TraceMode::Brute],
        windows: 1,
        build: Preset::Fast,
    };
    if let Err(error) = bench_rays(&args) {
        assert!(!error.to_string().contains('\n'), "{error}");
    }
});
