//! The path's sampler: the same numbers at any width, even where it says so, and none where it does not.

use octolux::lane::{Bits, Mask, Real, f32x8, f32x16};
use octolux::sampling::{Sampler, SamplerKind, Site, dimensions};

const SEED: u64 = 7;
/// What a path draws; the next is gather's, whose rays are independent.
const DRAWN: usize = dimensions::ROTATION;

/// The numbers of `bounce` for samples `first` … of a pixel, one a lane.
fn bounce<R: Real>(kind: SamplerKind, pixel: u32, first: u32, bounce: u32) -> [R; dimensions::BOUNCE] {
    let mut sampler = Sampler::<R>::idle();
    (0..R::WIDTH).for_each(|i| sampler.seed_lane(kind, i, SEED, Site::alone(pixel), first + i as u32));
    sampler.camera_dims(kind, true);
    let mut u = sampler.bounce_dims(kind, R::zero());
    for b in 1..=bounce {
        u = sampler.bounce_dims(kind, R::splat(b as f32));
    }
    u
}

#[test]
fn every_width_draws_the_same_numbers() {
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        for depth in [0, 1, 17, 5000] {
            let (sixteen, eight) = (bounce::<f32x16>(kind, 3, 16, depth), bounce::<f32x8>(kind, 3, 16, depth));
            for i in 0..16 {
                let one = bounce::<f32>(kind, 3, 16 + i as u32, depth);
                for d in 0..DRAWN {
                    assert_eq!(one[d].to_bits(), sixteen[d].lane(i).to_bits(), "{kind:?} bounce {depth} dimension {d}");
                    assert!((0.0..1.0).contains(&one[d]));
                    if i < 8 {
                        assert_eq!(one[d].to_bits(), eight[d].lane(i).to_bits());
                    }
                }
            }
        }
    }
}

/// Every box of 2^−a × 2^−b of the square holds 2^(k−a−b) of 2^k aligned samples: a (0, k, 2)-net, at any bounce. 256
/// independent points miss about a third of 256 boxes.
#[test]
fn pairs_of_dimensions_are_nets() {
    let pairs = [
        (dimensions::BSDF_DIRECTION, dimensions::BSDF_DIRECTION + 1),
        (dimensions::LIGHT_POSITION, dimensions::LIGHT_POSITION + 1),
        (dimensions::LIGHT_CHOICE, dimensions::BSDF_LOBE),
    ];
    for (depth, first) in [(0, 0), (3, 256), (40, 1024)] {
        for (x, y) in pairs {
            for columns in (0..=8).map(|k| 1 << k) {
                let rows = 256 / columns;
                let mut count = [0; 256];
                for sample in first..first + 256 {
                    let u = bounce::<f32>(SamplerKind::Sobol, 11, sample, depth);
                    let cell = (u[x] * columns as f32) as usize * rows + (u[y] * rows as f32) as usize;
                    count[cell] += 1;
                }
                assert_eq!(count, [1; 256], "dimensions {x} and {y}, bounce {depth}, {columns} columns");
            }
        }
    }
}

/// Padded sets share no structure: over 2¹⁴ samples of as many pixels the correlation of any two dimensions of one bounce,
/// and of one dimension at neighbouring bounces and pixels, is 0 within 5 standard errors of 1/√n.
#[test]
fn dimensions_bounces_and_pixels_are_uncorrelated() {
    let n = 1 << 14;
    let at = |pixel: u32, depth: u32| bounce::<f32>(SamplerKind::Sobol, pixel, pixel % 64, depth);
    let rows: Vec<[f32; 3 * DRAWN]> = (0..n)
        .map(|pixel| {
            let parts = [at(pixel, 1), at(pixel, 2), at(pixel + 1, 1)];
            std::array::from_fn(|k| parts[k / DRAWN][k % DRAWN] - 0.5)
        })
        .collect();
    for a in 0..DRAWN {
        for b in a + 1..3 * DRAWN {
            let sum: f64 = rows.iter().map(|u| f64::from(u[a]) * f64::from(u[b])).sum();
            // Var of a product of two uniform numbers about 0 is 1/144.
            let z = sum * 12.0 / f64::from(n).sqrt();
            assert!(z.abs() < 5.0, "dimensions {a} and {b}: {z:.2} standard errors");
        }
    }
}

#[test]
fn the_number_for_cut_outs_is_that_of_the_bounce() {
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        let mut sampler = Sampler::<f32x8>::idle();
        (0..8).for_each(|i| sampler.seed_lane(kind, i, SEED, Site::alone(i as u32), 5));
        sampler.camera_dims(kind, false);
        let before = sampler.opacity(kind, f32x8::zero());
        let drawn = sampler.bounce_dims(kind, f32x8::zero())[dimensions::OPACITY];
        assert!(before.eq(drawn).all(), "{kind:?}");
        assert_eq!(before.to_bits().lane(3), drawn.to_bits().lane(3));
    }
}
