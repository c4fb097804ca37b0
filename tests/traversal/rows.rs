//! Rows fetched by lane, and the lane moves they and the trees are made of.

use super::support::Random;
use octolux::geometry::{Rows, TriangleRows};
use octolux::lane::{Bits, Mask, Real, f32x8, f32x16};

/// Few rows are permuted, more are read and transposed.
fn fetched<R: Real, const N: usize>() {
    for count in [1, 2, 7, 8, 9, 15, 16, 17, 31, 32, 33, 97] {
        fetched_of::<R, N>(count);
    }
}

fn fetched_of<R: Real, const N: usize>(count: usize) {
    let mut rng = Random::new(41);
    let table: Vec<[f32; N]> = (0..count).map(|_| [(); N].map(|_| rng.signed())).collect();
    let rows = Rows::new(&table);
    for _ in 0..200 {
        let index: Vec<u32> = (0..R::WIDTH).map(|_| rng.below(count) as u32).collect();
        let bits = rng.below(1 << R::WIDTH) as u32;
        // Dead lanes may hold anything.
        let lanes = R::Bits::from_fn(|i| if bits >> i & 1 != 0 { index[i] } else { u32::MAX - i as u32 });
        let got = rows.fetch::<R>(lanes, R::Mask::from_bits(bits));
        for (column, value) in got.iter().enumerate() {
            for (i, index) in index.iter().enumerate() {
                let row = if bits >> i & 1 != 0 { *index as usize } else { 0 };
                assert_eq!(value.lane(i).to_bits(), table[row][column].to_bits(), "N {N} lane {i} column {column}");
            }
        }
    }
}

#[test]
fn rows_come_back_by_lane() {
    fetched::<f32, 4>();
    fetched::<f32, 16>();
    fetched::<f32x8, 3>();
    fetched::<f32x8, 4>();
    fetched::<f32x8, 8>();
    fetched::<f32x8, 12>();
    fetched::<f32x8, 15>();
    fetched::<f32x16, 4>();
    fetched::<f32x16, 7>();
    fetched::<f32x16, 8>();
    fetched::<f32x16, 16>();
}

#[test]
fn an_empty_table_gives_zeros_to_dead_lanes() {
    let rows = TriangleRows::new(&[], &[]);
    let at = rows.fetch::<f32x8>(Bits::splat(u32::MAX), Mask::splat(false));
    assert_eq!((at.p0.lane(3), at.area.lane(7)), ([0.0; 3], 0.0));
}

fn moves<R: Real>() {
    let mut rng = Random::new(42);
    for _ in 0..300 {
        let values: Vec<f32> = (0..R::WIDTH).map(|_| rng.signed()).collect();
        let v = R::load(&values);
        let index: Vec<u32> = (0..R::WIDTH).map(|_| rng.below(R::WIDTH) as u32).collect();
        let permuted = v.permute(R::Bits::load(&index));
        let four = [(); 4].map(|_| rng.signed());
        let small: Vec<u32> = (0..R::WIDTH).map(|_| rng.below(4) as u32).collect();
        let looked = R::lookup4(&four, R::Bits::load(&small));
        for i in 0..R::WIDTH {
            assert_eq!(permuted.lane(i), values[index[i] as usize]);
            assert_eq!(looked.lane(i), four[small[i] as usize]);
        }
        let all = u32::MAX >> (32 - R::WIDTH);
        for bits in (0..256).chain((0..256).map(|bits| bits << 8)).chain([all, rng.below(1 << R::WIDTH) as u32]) {
            let packed = v.compress(bits & all);
            let wanted = (0..R::WIDTH).filter(|i| (bits & all) >> i & 1 != 0).map(|i| values[i]);
            for (place, value) in wanted.enumerate() {
                assert_eq!(packed.lane(place), value, "{bits:#x}");
            }
        }
        assert_eq!(v.lowest(), values.iter().copied().fold(f32::INFINITY, f32::min));
        assert_eq!(v.highest(), values.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        let mut stored = vec![0; R::WIDTH];
        R::Bits::load(&index).store(&mut stored);
        assert_eq!(stored, index);
    }
}

#[test]
fn lanes_move_where_they_should() {
    moves::<f32>();
    moves::<f32x8>();
    moves::<f32x16>();
    // A node's order: slot 3·i bits up, in any higher digits' company.
    let order = 0o7_6543_2107u32 << 3 | 3;
    let v = f32x8::from_fn(|i| i as f32);
    let turned = v.permute(<f32x8 as Real>::Bits::unpack_octal(order));
    for i in 0..8 {
        assert_eq!(turned.lane(i), (order >> (3 * i) & 7) as f32);
    }
}

fn compared<R: Real>() {
    let edges = [0u32, 1, 2, 0x7f7f_ffff, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, 0xffff_fffe, u32::MAX];
    let mut rng = Random::new(43);
    for _ in 0..1000 {
        let mut draw = || R::Bits::from_fn(|_| edges[rng.below(edges.len())].wrapping_add(rng.below(2) as u32));
        let (a, b) = (draw(), draw());
        for i in 0..R::WIDTH {
            assert_eq!(a.lt(b).lane(i), a.lane(i) < b.lane(i), "{} {}", a.lane(i), b.lane(i));
        }
    }
}

#[test]
fn words_compare_without_sign() {
    compared::<f32>();
    compared::<f32x8>();
    compared::<f32x16>();
}
