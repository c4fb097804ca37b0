#![no_main]
//! Any bytes as the EXR file of an environment.

mod common;

const SCENE: &str = "[camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\n[environment]\nfile = \"e.exr\"\n";

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let path = common::folder().join("lit.toml");
    std::fs::write(&path, SCENE).expect("a scratch file");
    std::fs::write(common::folder().join("e.exr"), data).expect("a scratch file");
    common::load_and_prepare(&path);
});
