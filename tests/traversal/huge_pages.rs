//! The program's allocator: what it gives is the caller's, whole, of the size and alignment asked for.

use octolux::huge_pages::HugePages;
use std::alloc::{GlobalAlloc, Layout};

const MB: usize = 1 << 20;

/// Sizes below, at and beyond what is large and what a huge page holds.
const SIZES: [usize; 8] = [1, 4096, 2 * MB, 32 * MB - 1, 32 * MB, 32 * MB + 1, 34 * MB, 41 * MB + 17];

/// Something else at each place.
fn value(place: usize) -> u8 {
    (place.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as u8
}

fn fill(block: &mut [u8]) {
    block.iter_mut().enumerate().for_each(|(place, byte)| *byte = value(place));
}

fn is_filled(block: &[u8]) -> bool {
    block.iter().enumerate().all(|(place, byte)| *byte == value(place))
}

#[test]
fn blocks_hold_what_is_written_and_grow_and_shrink_with_it() {
    for align in [1, 64, 4 * MB] {
        for pair in SIZES.windows(2).flat_map(|pair| [[pair[0], pair[1]], [pair[1], pair[0]]]) {
            let [size, then] = pair;
            let layout = Layout::from_size_align(size, align).unwrap();
            // SAFETY: sizes are not 0; the slices are as long as the blocks, and nobody else has these.
            unsafe {
                let block = HugePages.alloc(layout);
                assert!(!block.is_null() && (block as usize).is_multiple_of(align));
                fill(std::slice::from_raw_parts_mut(block, size));
                let moved = HugePages.realloc(block, layout, then);
                assert!(!moved.is_null() && (moved as usize).is_multiple_of(align));
                assert!(is_filled(std::slice::from_raw_parts(moved, size.min(then))));
                fill(std::slice::from_raw_parts_mut(moved, then));
                assert!(is_filled(std::slice::from_raw_parts(moved, then)));
                HugePages.dealloc(moved, Layout::from_size_align(then, align).unwrap());
            }
        }
    }
}

#[test]
fn zeroed_blocks_are_zero_though_others_were_there() {
    for size in SIZES {
        let layout = Layout::from_size_align(size, 64).unwrap();
        for _ in 0..3 {
            // SAFETY: as above.
            unsafe {
                let block = HugePages.alloc_zeroed(layout);
                assert!(std::slice::from_raw_parts(block, size).iter().all(|byte| *byte == 0), "{size}");
                fill(std::slice::from_raw_parts_mut(block, size));
                HugePages.dealloc(block, layout);
            }
        }
    }
}

#[test]
fn what_cannot_be_had_is_null() {
    let layout = Layout::from_size_align(1 << 60, 64).unwrap();
    // SAFETY: nothing is done with the blocks.
    unsafe {
        assert!(HugePages.alloc(layout).is_null());
        assert!(HugePages.alloc_zeroed(layout).is_null());
    }
}
