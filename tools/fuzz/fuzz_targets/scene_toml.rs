#![no_main]
//! Any bytes as a scene file.

mod common;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let path = common::folder().join("scene.toml");
    std::fs::write(&path, data).expect("a scratch file");
    common::load_and_prepare(&path);
});
