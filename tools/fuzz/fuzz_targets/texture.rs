#![no_main]
//! Any bytes as an image that a material wears: PNG, JPEG or EXR by its first bytes.

mod common;

const OBJ: &str = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl t\nf 1/1 2/2 3/3\n";
const MTL: &str = "newmtl t\nKd 1 1 1\nmap_Kd t.png\nmap_d t.png\nnorm t.png\n";

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let path = common::folder().join("worn.obj");
    std::fs::write(&path, OBJ).expect("a scratch file");
    std::fs::write(common::folder().join("t.mtl"), MTL).expect("a scratch file");
    std::fs::write(common::folder().join("t.png"), data).expect("a scratch file");
    common::load_and_prepare(&path);
});
