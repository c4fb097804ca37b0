//! The floating-point mode: IEEE 754 as it is by default, in every thread that computes.
//!
//! Subnormals are kept (neither flush-to-zero nor denormals-are-zero), rounding is to nearest, nothing traps: that is what
//! the bounds of [`math`](super::math) and the claim of equal bits are for, and what Rust takes for granted. A thread
//! starts with the mode of the one that creates it, and that need not be the default: a program that links code built with
//! `-ffast-math` flushes subnormals from its first instruction on. So each worker of ours restores the default before it
//! computes anything, and set-up, which runs on the caller's thread, warns where that one differs. The mode is never
//! changed otherwise.

/// MXCSR after reset (Intel SDM vol. 1, §10.2.3): exceptions masked, round to nearest, no FTZ, no DAZ.
const DEFAULT: u32 = 0x1f80;
/// All but the six exception flags, which say only what has happened.
const CONTROL: u32 = 0xffc0;

/// Does the calling thread compute as IEEE 754 and Rust have it?
pub fn is_default() -> bool {
    let mut mode = 0u32;
    // SAFETY: stores four bytes where `mode` is; MXCSR exists on every x86-64.
    unsafe {
        core::arch::asm!("stmxcsr [{}]", in(reg) &raw mut mode, options(nostack, preserves_flags));
    }
    mode & CONTROL == DEFAULT
}

/// Gives the calling thread the default mode.
pub fn restore() {
    let mode = DEFAULT;
    // SAFETY: loads a valid MXCSR. Code may not leave another mode than Rust's own behind: this is that one.
    unsafe {
        core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const mode, options(nostack, readonly, preserves_flags));
    }
}
