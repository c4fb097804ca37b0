//! Arrays of lanes, unrolled.
//!
//! `core::array::map` and `from_fn` are not always inlined: with registers of 64 bytes they then pass everything through
//! memory (measured: brute-force traversal ×1.7 slower). These always are.

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

/// [`Each::each`] for arrays.
pub trait Each<A> {
    type Of<B>;
    /// `[f(a[0]), f(a[1]), …]`.
    fn each<B: Copy>(self, f: impl FnMut(A) -> B) -> Self::Of<B>;
}

impl<A: Copy, const N: usize> Each<A> for [A; N] {
    type Of<B> = [B; N];
    #[inline(always)]
    fn each<B: Copy>(self, mut f: impl FnMut(A) -> B) -> [B; N] {
        from_fn(|i| f(self[i]))
    }
}
