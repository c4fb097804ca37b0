//! Arrays of lanes, unrolled.
//!
//! `core::array::map` and `from_fn` and `copy_from_slice` are not always inlined: with registers of 64 bytes they then pass
//! everything through memory (measured: brute-force traversal ×1.7 slower). These always are.
//!
//! (Nor are `Zip` and `flat_map`, but by optimising the whole crate at once: the hottest loops go by index.)

/// `[f(0), f(1), …]`.
#[inline(always)]
pub fn from_fn<const N: usize, B: Copy>(mut f: impl FnMut(usize) -> B) -> [B; N] {
    let mut out = [f(0); N];
    let mut i = 1;
    while i < N {
        out[i] = f(i);
        i += 1;
    }
    out
}

/// Writes `values` to places `first` … of `to`. Panics past the end.
#[inline(always)]
pub fn put<const N: usize, A: Copy>(values: [A; N], to: &mut [A], first: usize) {
    let to = &mut to[first..first + N];
    let mut i = 0;
    while i < N {
        to[i] = values[i];
        i += 1;
    }
}

/// `[f(a[0]), f(a[1]), …]`.
#[inline(always)]
pub fn map<const N: usize, A: Copy, B: Copy>(a: [A; N], mut f: impl FnMut(A) -> B) -> [B; N] {
    from_fn(|i| f(a[i]))
}
