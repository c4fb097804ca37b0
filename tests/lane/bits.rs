//! Words in lanes against the standard library's.

use octolux::lane::{Bits, MAX_WIDTH, Real, f32x8, f32x16};

#[test]
fn bits_are_reversed_as_the_standard_library_does() {
    fn check<R: Real>() {
        // Every bit and every byte alone, and words of all kinds.
        let words = (0..32).map(|k| 1 << k).chain((0..=255u32).map(|byte| byte.wrapping_mul(0x0100_0001)));
        let words: Vec<u32> = words.chain((0..10_000u32).map(|i| i.wrapping_mul(0x9e37_79b9))).collect();
        for chunk in words.chunks_exact(R::WIDTH) {
            let reversed = R::Bits::load(chunk).reverse_bits();
            for (lane, word) in chunk.iter().enumerate() {
                assert_eq!(reversed.lane(lane), word.reverse_bits(), "{word:#x} in lane {lane} of {}", R::WIDTH);
            }
        }
    }
    check::<f32>();
    check::<octolux::lane::f32x8>();
    check::<octolux::lane::f32x16>();
}

/// Columns stored as rows, and fetched again.
#[test]
fn rows_are_columns_transposed() {
    fn check<R: Real, const N: usize>() {
        let columns: [R; N] = std::array::from_fn(|c| R::from_fn(|lane| (100 * lane + c) as f32));
        let mut rows = [[-1.0; N]; MAX_WIDTH];
        R::store_rows(&columns, &mut rows);
        for (lane, row) in rows.iter().enumerate() {
            let wanted = |c: usize| if lane < R::WIDTH { (100 * lane + c) as f32 } else { -1.0 };
            assert_eq!(*row, std::array::from_fn(wanted), "lane {lane} of {}", R::WIDTH);
        }
        let last = R::WIDTH as u32 - 1;
        let fetched: [R; N] = R::fetch_rows(&rows, R::Bits::from_fn(|lane| last - lane as u32));
        for (c, column) in fetched.into_iter().enumerate() {
            for lane in 0..R::WIDTH {
                assert_eq!(column.lane(lane), columns[c].lane(R::WIDTH - 1 - lane), "column {c}, lane {lane}");
            }
        }
    }
    fn widths<const N: usize>() {
        check::<f32, N>();
        check::<f32x8, N>();
        check::<f32x16, N>();
    }
    widths::<3>();
    widths::<4>();
    widths::<8>();
    widths::<13>();
    widths::<16>();
}
