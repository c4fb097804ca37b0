//! What moves values between lanes without computing on them: permute, compress, rows to lanes.

use super::Real;
use super::array::{map, put};
use wide::{f32x8, f32x16, u32x8, u32x16};

/// Lanes 0 … 7 of row `index[i]`, transposed eight columns at a time.
#[inline(always)]
pub fn rows8<const N: usize>(table: &[[f32; N]], index: [u32; 8]) -> [f32x8; N] {
    let mut out = [f32x8::ZERO; N];
    let rows: [&[f32; N]; 8] = crate::lane::array::from_fn(|i| &table[index[i] as usize]);
    let mut first = 0;
    while first + 8 <= N {
        let part = crate::lane::array::from_fn(|i| <f32x8 as Real>::load(&rows[i][first..first + 8]));
        put(f32x8::transpose(part), &mut out, first);
        first += 8;
    }
    if first + 4 <= N {
        put(four_columns(map(rows, |row| quad(&row[first..first + 4]))), &mut out, first);
        first += 4;
    }
    for (column, values) in out.iter_mut().enumerate().skip(first) {
        *values = f32x8::new(crate::lane::array::from_fn(|i| rows[i][column]));
    }
    out
}

/// Sixteen rows: two halves of eight.
#[inline(always)]
pub fn rows16<const N: usize>(table: &[[f32; N]], index: [u32; 16]) -> [f32x16; N] {
    let low = rows8(table, crate::lane::array::from_fn(|i| index[i]));
    let high = rows8(table, crate::lane::array::from_fn(|i| index[i + 8]));
    crate::lane::array::from_fn(|i| join(low[i], high[i]))
}

/// Lane `i` of the columns to row `i`, transposed eight columns at a time.
#[inline(always)]
pub fn store_rows8<const N: usize>(columns: &[f32x8; N], rows: &mut [[f32; N]]) {
    let mut first = 0;
    while first + 8 <= N {
        let part = f32x8::transpose(crate::lane::array::from_fn(|k| columns[first + k]));
        for (row, part) in rows.iter_mut().zip(part) {
            part.store(&mut row[first..first + 8]);
        }
        first += 8;
    }
    if first + 4 <= N {
        let part = four_rows(crate::lane::array::from_fn(|k| columns[first + k]));
        for (row, part) in rows.iter_mut().zip(part) {
            put(part, row, first);
        }
        first += 4;
    }
    for (k, column) in columns.iter().enumerate().skip(first) {
        for (row, value) in rows.iter_mut().zip(column.to_array()) {
            row[k] = value;
        }
    }
}

/// Sixteen rows: two halves of eight.
#[inline(always)]
pub fn store_rows16<const N: usize>(columns: &[f32x16; N], rows: &mut [[f32; N]]) {
    for (half, rows) in rows.chunks_exact_mut(8).enumerate() {
        let columns: [f32x8; N] = crate::lane::array::from_fn(|k| split(columns[k])[half]);
        store_rows8(&columns, rows);
    }
}

#[inline(always)]
fn quad(row: &[f32]) -> [f32; 4] {
    [row[0], row[1], row[2], row[3]]
}

/// Two 8-lane registers as one of 16.
#[inline(always)]
fn join(low: f32x8, high: f32x8) -> f32x16 {
    #[cfg(all(target_feature = "avx512f", target_feature = "avx512dq"))]
    // SAFETY: the build has these features; registers only. (The transmute below goes through memory, and the wide load
    // then waits for both narrow stores.)
    unsafe {
        use core::arch::x86_64::*;
        f32x16::from(_mm512_insertf32x8::<1>(_mm512_castps256_ps512(low.into()), high.into()))
    }
    #[cfg(not(all(target_feature = "avx512f", target_feature = "avx512dq")))]
    // SAFETY: plain registers, and `f32x16` holds lanes 0 … 7 first.
    unsafe {
        core::mem::transmute::<[f32x8; 2], f32x16>([low, high])
    }
}
#[inline(always)]
fn split(v: f32x16) -> [f32x8; 2] {
    #[cfg(all(target_feature = "avx512f", target_feature = "avx512dq"))]
    // SAFETY: as in `join`.
    unsafe {
        use core::arch::x86_64::*;
        let v = v.into();
        [f32x8::from(_mm512_castps512_ps256(v)), f32x8::from(_mm512_extractf32x8_ps::<1>(v))]
    }
    #[cfg(not(all(target_feature = "avx512f", target_feature = "avx512dq")))]
    // SAFETY: as in `join`.
    unsafe {
        core::mem::transmute::<f32x16, [f32x8; 2]>(v)
    }
}
/// The halves of a register; of one of eight, itself twice.
#[inline(always)]
pub fn halves8(v: f32x8) -> [f32x8; 2] {
    [v, v]
}
#[inline(always)]
pub fn halves16(v: f32x16) -> [f32x8; 2] {
    split(v)
}

/// Lanes where a ≤ b, as bits.
#[inline(always)]
pub fn le_bits8(a: f32x8, b: f32x8) -> u32 {
    #[cfg(all(target_feature = "avx512f", target_feature = "avx512vl"))]
    // SAFETY: the build has AVX-512VL; registers only.
    unsafe {
        use core::arch::x86_64::*;
        u32::from(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(a.into(), b.into()))
    }
    #[cfg(not(all(target_feature = "avx512f", target_feature = "avx512vl")))]
    {
        use super::Mask;
        a.le(b).bits()
    }
}
#[inline(always)]
pub fn le_bits16(a: f32x16, b: f32x16) -> u32 {
    use super::Mask;
    a.le(b).bits()
}

/// Column `c` of eight rows of four.
#[inline(always)]
fn four_columns(rows: [[f32; 4]; 8]) -> [f32x8; 4] {
    // (Written by hand: without the vectorizer of straight lines, see `.cargo/config.toml`, arrays go value by value.)
    #[cfg(target_feature = "avx")]
    // SAFETY: the build has AVX; each load reads the 16 bytes of a row, and no alignment is asked for.
    unsafe {
        use core::arch::x86_64::*;
        let row = |i: usize| _mm_loadu_ps(rows[i].as_ptr());
        // Rows i and i + 4 share a register, so that each half is a square to transpose.
        let wide = |i: usize| _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(row(i)), row(i + 4));
        let (a, b, c, d) = (wide(0), wide(1), wide(2), wide(3));
        let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        [
            _mm256_shuffle_ps::<0x44>(ab, cd).into(),
            _mm256_shuffle_ps::<0xee>(ab, cd).into(),
            _mm256_shuffle_ps::<0x44>(ab_high, cd_high).into(),
            _mm256_shuffle_ps::<0xee>(ab_high, cd_high).into(),
        ]
    }
    #[cfg(not(target_feature = "avx"))]
    crate::lane::array::from_fn(|c| f32x8::new(crate::lane::array::from_fn(|i| rows[i][c])))
}

/// Rows of four columns.
#[inline(always)]
fn four_rows(columns: [f32x8; 4]) -> [[f32; 4]; 8] {
    #[cfg(target_feature = "avx")]
    // SAFETY: the build has AVX; registers only, and each store writes the 16 bytes of a row.
    unsafe {
        use core::arch::x86_64::*;
        let [a, b, c, d] = map(columns, |column| column.into());
        let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        // Rows i and i + 4.
        let pairs = [
            _mm256_shuffle_ps::<0x44>(ab, cd),
            _mm256_shuffle_ps::<0xee>(ab, cd),
            _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
            _mm256_shuffle_ps::<0xee>(ab_high, cd_high),
        ];
        let mut rows = [[0.0; 4]; 8];
        for (i, pair) in pairs.into_iter().enumerate() {
            _mm_storeu_ps(rows[i].as_mut_ptr(), _mm256_castps256_ps128(pair));
            _mm_storeu_ps(rows[i + 4].as_mut_ptr(), _mm256_extractf128_ps::<1>(pair));
        }
        rows
    }
    #[cfg(not(target_feature = "avx"))]
    {
        let columns = map(columns, |column| column.to_array());
        crate::lane::array::from_fn(|i| map(columns, |column| column[i]))
    }
}

/// Lane `i` is `table[index[i] & 3]`.
#[inline(always)]
pub fn lookup4_8(table: &[f32; 4], index: u32x8) -> f32x8 {
    #[cfg(target_feature = "avx2")]
    // SAFETY: the build has AVX2; `table` is 16 readable bytes, and no alignment is asked for.
    unsafe {
        use core::arch::x86_64::*;
        let row = _mm256_broadcast_ps(&*table.as_ptr().cast::<__m128>());
        f32x8::from(_mm256_permutevar_ps(row, index.into()))
    }
    #[cfg(not(target_feature = "avx2"))]
    f32x8::new(map(index.to_array(), |i| table[i as usize & 3]))
}

/// Lane `i` is `table[index[i] & 3]`.
#[inline(always)]
pub fn lookup4_16(table: &[f32; 4], index: u32x16) -> f32x16 {
    #[cfg(target_feature = "avx512f")]
    // SAFETY: the build has AVX-512F; the row is loaded unaligned.
    unsafe {
        use core::arch::x86_64::*;
        let row = _mm512_broadcast_f32x4(_mm_loadu_ps(table.as_ptr()));
        f32x16::from(_mm512_permutevar_ps(row, index.into()))
    }
    #[cfg(not(target_feature = "avx512f"))]
    {
        // SAFETY: as in `join`.
        let [low, high] = unsafe { core::mem::transmute::<u32x16, [u32x8; 2]>(index) };
        join(lookup4_8(table, low), lookup4_8(table, high))
    }
}

/// Lane `i` is `v[index[i] & 7]`.
#[inline(always)]
pub fn permute8(v: f32x8, index: u32x8) -> f32x8 {
    #[cfg(target_feature = "avx2")]
    // SAFETY: the build has AVX2; registers only.
    unsafe {
        use core::arch::x86_64::*;
        f32x8::from(_mm256_permutevar8x32_ps(v.into(), index.into()))
    }
    #[cfg(not(target_feature = "avx2"))]
    {
        let lanes = v.to_array();
        f32x8::new(map(index.to_array(), |i| lanes[i as usize & 7]))
    }
}

/// Lane `i` is `v[index[i] & 15]`.
#[inline(always)]
pub fn permute16(v: f32x16, index: u32x16) -> f32x16 {
    #[cfg(target_feature = "avx512f")]
    // SAFETY: the build has AVX-512F; registers only.
    unsafe {
        use core::arch::x86_64::*;
        f32x16::from(_mm512_permutexvar_ps(index.into(), v.into()))
    }
    #[cfg(not(target_feature = "avx512f"))]
    {
        let lanes = v.to_array();
        f32x16::new(map(index.to_array(), |i| lanes[i as usize & 15]))
    }
}

/// For each of the 256 masks of eight lanes, the indices of its lanes in order, a byte each.
#[cfg(not(all(target_feature = "avx512f", target_feature = "avx512vl")))]
static COMPRESSION: [u64; 256] = {
    let mut table = [0u64; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 != 0 {
                table[mask] |= (lane as u64) << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// The lanes of `bits` (< 256) moved to the front, in order; the others are unspecified.
#[inline(always)]
pub fn compress8(v: f32x8, bits: u32) -> f32x8 {
    #[cfg(all(target_feature = "avx512f", target_feature = "avx512vl"))]
    // SAFETY: the build has AVX-512VL; registers only.
    unsafe {
        use core::arch::x86_64::*;
        f32x8::from(_mm256_maskz_compress_ps(bits as u8, v.into()))
    }
    #[cfg(not(all(target_feature = "avx512f", target_feature = "avx512vl")))]
    {
        let bytes = COMPRESSION[bits as usize & 255];
        // The compiler takes bytes apart one by one and puts them together again.
        #[cfg(target_feature = "avx2")]
        // SAFETY: the build has AVX2; registers only.
        let order = unsafe {
            use core::arch::x86_64::*;
            u32x8::from(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(bytes as i64)))
        };
        #[cfg(not(target_feature = "avx2"))]
        let order = u32x8::new(map(bytes.to_le_bytes(), u32::from));
        permute8(v, order)
    }
}

/// The lanes of `bits` (< 65,536) moved to the front, in order; the others are unspecified.
#[inline(always)]
pub fn compress16(v: f32x16, bits: u32) -> f32x16 {
    #[cfg(target_feature = "avx512f")]
    // SAFETY: the build has AVX-512F; registers only.
    unsafe {
        use core::arch::x86_64::*;
        f32x16::from(_mm512_maskz_compress_ps(bits as u16, v.into()))
    }
    #[cfg(not(target_feature = "avx512f"))]
    {
        let mut out = [0.0; 16];
        let (low, high) = (bits & 255, bits >> 8 & 255);
        let [first, second] = split(v);
        compress8(first, low).store(&mut out);
        compress8(second, high).store(&mut out[low.count_ones() as usize..]);
        <f32x16 as Real>::load(&out)
    }
}

/// Smallest and largest of eight lanes, `better(a, b)` being [`Real::min_or`] or [`Real::max_or`].
#[inline(always)]
pub fn extreme8(v: f32x8, better: impl Fn(f32x8, f32x8) -> f32x8) -> f32 {
    let v = better(v, permute8(v, u32x8::new([4, 5, 6, 7, 0, 1, 2, 3])));
    let v = better(v, permute8(v, u32x8::new([2, 3, 0, 1, 6, 7, 4, 5])));
    better(v, permute8(v, u32x8::new([1, 0, 3, 2, 5, 4, 7, 6]))).to_array()[0]
}
#[inline(always)]
pub fn extreme16(v: f32x16, better: impl Fn(f32x8, f32x8) -> f32x8) -> f32 {
    let [low, high] = split(v);
    extreme8(better(low, high), better)
}
