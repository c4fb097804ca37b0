//! The CPU guard: names the missing feature instead of dying of an illegal instruction.
//!
//! The instruction set is chosen at compile time (lanes are plain registers). `is_x86_feature_detected!` folds to
//! `true` for features the build enables, so the guard asks CPUID itself, before any vector code has run.

use core::arch::x86_64::{__cpuid, __cpuid_count, _xgetbv};

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
compile_error!(
    "octolux needs AVX2 and FMA at compile time. In a checkout .cargo/config.toml asks for the CPU of this machine; \
     where that file or its rustflags are overridden, build with RUSTFLAGS=\"-C target-cpu=x86-64-v3\"."
);

/// Where CPUID tells of a feature: leaf 1, leaf 7 (sub-leaf 0) or leaf 0x8000_0001.
#[derive(Clone, Copy)]
enum Register {
    Leaf1Ecx,
    Leaf7Ebx,
    Leaf7Ecx,
    ExtendedEcx,
}

/// Feature, whether this build uses it, and its CPUID bit (Intel SDM vol. 2A, CPUID; AMD APM vol. 3, appendix E).
macro_rules! features {
    ($($name:literal, $register:ident, $bit:literal;)*) => {
        &[$(($name, cfg!(target_feature = $name), Register::$register, $bit)),*]
    };
}
const FEATURES: &[(&str, bool, Register, u32)] = features! {
    "sse4.2", Leaf1Ecx, 20;
    "popcnt", Leaf1Ecx, 23;
    "fma", Leaf1Ecx, 12;
    "movbe", Leaf1Ecx, 22;
    "avx", Leaf1Ecx, 28;
    "f16c", Leaf1Ecx, 29;
    "bmi1", Leaf7Ebx, 3;
    "avx2", Leaf7Ebx, 5;
    "bmi2", Leaf7Ebx, 8;
    "lzcnt", ExtendedEcx, 5;
    "avx512f", Leaf7Ebx, 16;
    "avx512dq", Leaf7Ebx, 17;
    "avx512ifma", Leaf7Ebx, 21;
    "avx512cd", Leaf7Ebx, 28;
    "avx512bw", Leaf7Ebx, 30;
    "avx512vl", Leaf7Ebx, 31;
    "avx512vbmi", Leaf7Ecx, 1;
    "avx512vbmi2", Leaf7Ecx, 6;
    "gfni", Leaf7Ecx, 8;
    "avx512vnni", Leaf7Ecx, 11;
    "avx512bitalg", Leaf7Ecx, 12;
    "avx512vpopcntdq", Leaf7Ecx, 14;
};

/// The CPU features that this build was compiled to use.
pub fn compiled_features() -> Vec<&'static str> {
    FEATURES.iter().filter(|f| f.1).map(|f| f.0).collect()
}

/// `Err` names the first feature that this build uses and this CPU (or its operating system) lacks.
pub fn guard() -> Result<(), &'static str> {
    let max_leaf = __cpuid(0).eax;
    let leaf1 = __cpuid(1);
    let leaf7 = if max_leaf >= 7 { __cpuid_count(7, 0) } else { __cpuid(0x4000_0000) };
    let (leaf7_ebx, leaf7_ecx) = if max_leaf >= 7 { (leaf7.ebx, leaf7.ecx) } else { (0, 0) };
    let extended = if __cpuid(0x8000_0000).eax >= 0x8000_0001 { __cpuid(0x8000_0001).ecx } else { 0 };
    for &(name, used, register, bit) in FEATURES {
        let word = match register {
            Register::Leaf1Ecx => leaf1.ecx,
            Register::Leaf7Ebx => leaf7_ebx,
            Register::Leaf7Ecx => leaf7_ecx,
            Register::ExtendedEcx => extended,
        };
        if used && word >> bit & 1 == 0 {
            return Err(name);
        }
    }
    const OSXSAVE: u32 = 1 << 27;
    if leaf1.ecx & OSXSAVE == 0 {
        return Err("avx (the operating system does not save its registers)");
    }
    // SAFETY: OSXSAVE says that XGETBV exists.
    let saved = unsafe { enabled_state() };
    let needed: u64 = if cfg!(target_feature = "avx512f") { 0b1110_0110 } else { 0b110 };
    if saved & needed != needed {
        return Err("avx or avx512f (the operating system does not save its registers)");
    }
    Ok(())
}

/// Which register states the operating system saves (XCR0).
#[target_feature(enable = "xsave")]
fn enabled_state() -> u64 {
    // SAFETY: XCR0 exists wherever XGETBV does, which the caller has checked.
    unsafe { _xgetbv(0) }
}
