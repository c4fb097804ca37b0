//! The lane generator against `rand_xoshiro`, its keys, its numbers.

use octolux::lane::{Bits, Real, f32x8, f32x16};
use octolux::sampling::{ONE_BELOW, Xoshiro, dimensions, rescale, sample_key};
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use std::collections::HashSet;

fn keys() -> Vec<u64> {
    let edge = [0, 1, u64::MAX, u64::MAX - 1, 1 << 32, 0x9e37_79b9_7f4a_7c15, 0x9e37_79b9_7f4a_7c15u64.wrapping_neg()];
    edge.into_iter().chain((0..41).map(|i| sample_key(7, i, i * i))).collect()
}

fn equals_the_crate<R: Real>() {
    for keys in keys().chunks_exact(R::WIDTH) {
        let mut lanes = Xoshiro::<R>::from_keys(|i| keys[i]);
        let mut scalars: Vec<_> = keys.iter().map(|&key| Xoshiro128PlusPlus::seed_from_u64(key)).collect();
        for draw in 0..5000 {
            if draw == 2500 {
                // Regeneration: one lane starts again, the others go on.
                lanes.seed_lane(R::WIDTH / 2, 99);
                scalars[R::WIDTH / 2] = Xoshiro128PlusPlus::seed_from_u64(99);
            }
            let bits = lanes.next_bits();
            for (i, scalar) in scalars.iter_mut().enumerate() {
                assert_eq!(bits.lane(i), scalar.next_u32(), "lane {i} of {}, draw {draw}", R::WIDTH);
            }
        }
    }
}

#[test]
fn every_lane_equals_rand_xoshiro() {
    equals_the_crate::<f32>();
    equals_the_crate::<f32x8>();
    equals_the_crate::<f32x16>();
}

#[test]
fn units_are_the_upper_24_bits_and_never_1() {
    let mut lanes = Xoshiro::<f32x16>::from_keys(|i| i as u64);
    let mut scalars: Vec<_> = (0..16).map(Xoshiro128PlusPlus::seed_from_u64).collect();
    let (mut least, mut most) = (1.0f32, 0.0f32);
    for _ in 0..200_000 {
        let unit = lanes.next_unit();
        for (i, scalar) in scalars.iter_mut().enumerate() {
            let expected = (scalar.next_u32() >> 8) as f32 / (1u32 << 24) as f32;
            assert_eq!(unit.lane(i), expected);
            (least, most) = (least.min(expected), most.max(expected));
        }
    }
    // Of 3.2 million draws the extremes lie within 2⁻¹⁶ of the ends but for a chance of e⁻⁴⁸.
    assert!(least < 2f32.powi(-16) && most > 1.0 - 2f32.powi(-16) && most <= ONE_BELOW);
}

#[test]
fn the_extreme_draw_is_below_1() {
    assert_eq!((u32::MAX >> 8) as f32 * (1.0 / (1u32 << 24) as f32), ONE_BELOW);
    const { assert!(ONE_BELOW < 1.0) };
}

#[test]
fn bounces_can_be_skipped_to() {
    for bounce in [0, 1, 5, 100] {
        let mut replay = Xoshiro::<f32x8>::from_keys(|i| sample_key(1, 2, i as u32));
        let mut whole = replay;
        replay.skip_to_bounce(bounce);
        let camera: [f32x8; dimensions::CAMERA] = whole.camera_dims();
        assert_eq!(camera.len() + dimensions::BOUNCE * bounce as usize, 4 + 12 * bounce as usize);
        for _ in 0..bounce {
            whole.bounce_dims();
        }
        assert_eq!(replay.next_bits().lane(3), whole.next_bits().lane(3));
    }
}

#[test]
fn keys_differ_within_a_seed() {
    // Corners of the index space: a shared key among these 2¹⁸ would need (pixel, sample) to overlap.
    let near = |k: u32| if k < 256 { k } else { (k - 256).wrapping_neg().wrapping_sub(1) };
    for seed in [0, 1, u64::MAX] {
        let mut seen = HashSet::new();
        for pixel in (0..512).map(near) {
            for sample in (0..512).map(near) {
                assert!(seen.insert(sample_key(seed, pixel, sample)), "seed {seed}, pixel {pixel}, sample {sample}");
            }
        }
    }
    assert_ne!(sample_key(0, 5, 6), sample_key(1, 5, 6));
}

#[test]
fn one_changed_input_bit_changes_half_the_key() {
    // 128 flips of 64 bits each: mean 32, standard error √16/√(flips) per base point; 64 base points in all.
    let mut flipped = 0u32;
    let mut flips = 0u32;
    for base in 0..64u32 {
        let [pixel, sample] = [base.wrapping_mul(7919), base];
        let key = sample_key(u64::from(base), pixel, sample);
        for bit in 0..32 {
            flipped += (key ^ sample_key(u64::from(base), pixel ^ 1 << bit, sample)).count_ones();
            flipped += (key ^ sample_key(u64::from(base), pixel, sample ^ 1 << bit)).count_ones();
            flips += 2;
        }
    }
    let z = (f64::from(flipped) / f64::from(flips) - 32.0) / (4.0 / f64::from(flips).sqrt());
    assert!(z.abs() < 3.89, "z = {z}");
}

#[test]
fn a_rescaled_number_is_uniform_and_below_1() {
    let (lo, hi) = (0.3f32, 0.7f32);
    let mut rng = Xoshiro::<f32x8>::from_keys(|i| 1000 + i as u64);
    let (mut sum, mut n) = (0.0, 0u32);
    for _ in 0..100_000 {
        let u = rng.next_unit();
        let v = rescale(u, f32x8::splat(lo), f32x8::splat(hi));
        for i in (0..8).filter(|&i| (lo..hi).contains(&u.lane(i))) {
            assert!((0.0..1.0).contains(&v.lane(i)));
            sum += f64::from(v.lane(i));
            n += 1;
        }
    }
    let z = (sum / f64::from(n) - 0.5) * (12.0 * f64::from(n)).sqrt();
    assert!(z.abs() < 3.89, "z = {z}");
    // The upper end rounds to 1 without the clamp; an empty choice stays finite.
    assert_eq!(rescale(hi, lo, hi), ONE_BELOW);
    assert!((0.0..1.0).contains(&rescale(0.5f32, 0.5, 0.5)));
    assert!((0.0..1.0).contains(&rescale(0.2f32, 0.5, 0.5)));
}
