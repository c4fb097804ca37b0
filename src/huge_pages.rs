//! Memory in huge pages, and kept.
//!
//! Fresh memory costs a fault for every 4 KB when it is first written, some 2 µs each in a virtual machine: a third of the
//! time to set up a scene of a hundred thousand triangles. In a tree of millions of them a walk also misses the translation of
//! its address at nearly every node. So the program asks for huge pages of 2 MB, which Linux gives to those who ask
//! (`madvise`, the usual setting), and keeps what it frees for what it needs next. `benches/README.md` has what that is worth.

use nix::sys::mman::{MmapAdvise, madvise};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::NonNull;

/// Bytes from which a block is worth a call of the system.
const LARGE: usize = 128 << 10;

/// What the heap grows by, and what is asked for: all around a block as far as places of this size reach, and one more. Its
/// neighbours are then in huge pages, too.
const AROUND: usize = 64 << 20;

/// Tells the system's allocator to keep what is freed, to grow by much, and to have one heap for all threads, whose growth is
/// then in whole huge pages (threads' own heaps grow by a few small ones). To be called before there are threads.
pub fn keep_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        let growth = AROUND as libc::c_int;
        let settings = [
            // Blocks from this size on are mapped, and given back, each on its own.
            (libc::M_MMAP_THRESHOLD, 32 << 20),
            (libc::M_TOP_PAD, growth),
            // Free memory at the end of the heap is given back beyond this.
            (libc::M_TRIM_THRESHOLD, 256 << 20),
            (libc::M_ARENA_MAX, 1),
        ];
        for (parameter, value) in settings {
            // SAFETY: parameters and values are those of mallopt(3), which changes where blocks come from and nothing else;
            // where it refuses, all is as it was.
            unsafe { libc::mallopt(parameter, value) };
        }
        // So that it grows now, and all of what it grew by is asked for.
        std::hint::black_box(Vec::<u8>::with_capacity(LARGE));
    }
}

/// The system's allocator, with huge pages for large blocks where they can be had.
pub struct HugePages;

// SAFETY: every block comes from `System` and goes back to it, with the layout that the caller gave; `ask` neither moves nor
// writes nor frees memory, does not allocate, and does not unwind.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those that `System` asks for.
        ask(unsafe { System.alloc(layout) }, layout.size())
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        ask(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above; the block is one of `System`'s.
        unsafe { System.dealloc(block, layout) }
    }
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        // SAFETY: as above; the block is one of `System`'s.
        ask(unsafe { System.realloc(block, layout, new_size) }, new_size)
    }
}

/// Asks for huge pages around a large block; returns the block.
fn ask(block: *mut u8, size: usize) -> *mut u8 {
    if size >= LARGE && !block.is_null() {
        let inside = block as usize % AROUND;
        if let Some(first) = NonNull::new(block.wrapping_sub(inside)) {
            let length = (inside + size + AROUND).next_multiple_of(AROUND);
            // SAFETY: the advice changes by what pages the system keeps what is mapped there, and nothing of what is in
            // them, whosever they are. Where nothing is mapped, or there are no huge pages to be had, nothing is lost.
            let _ = unsafe { madvise(first.cast(), length, MmapAdvise::MADV_HUGEPAGE) };
        }
    }
    block
}
