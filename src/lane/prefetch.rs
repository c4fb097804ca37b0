//! Bringing memory nearer before it is read.

/// Starts to bring what is at `pointer` into the nearest cache; any pointer will do, nothing is read.
#[inline(always)]
pub fn prefetch<T>(pointer: *const T) {
    prefetch_to::<3, T>(pointer);
}

/// [`prefetch`] into the second cache: of much, which would push out of the nearest what is at work.
#[inline(always)]
pub fn prefetch_second<T>(pointer: *const T) {
    prefetch_to::<2, T>(pointer);
}

/// `LEVEL` as `_mm_prefetch` counts: 3 for the nearest cache, 2 for the second.
#[inline(always)]
fn prefetch_to<const LEVEL: i32, T>(pointer: *const T) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of::<T>()).step_by(64) {
        // SAFETY: a prefetch is a hint; it neither faults nor changes anything, whatever the address.
        unsafe {
            use core::arch::x86_64::*;
            _mm_prefetch::<LEVEL>(pointer.cast::<i8>().wrapping_add(line));
        }
    }
}
