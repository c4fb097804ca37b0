#![no_main]
//! Any bytes as a model and, after a line `=mtl=`, its material library `m.mtl`.

mod common;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    const CUT: &[u8] = b"\n=mtl=\n";
    let at = data.windows(CUT.len()).position(|w| w == CUT);
    let (obj, mtl) = at.map_or((data, &data[..0]), |at| (&data[..at], &data[at + CUT.len()..]));
    let path = common::folder().join("model.obj");
    std::fs::write(&path, obj).expect("a scratch file");
    std::fs::write(common::folder().join("m.mtl"), mtl).expect("a scratch file");
    common::load_and_prepare(&path);
});
