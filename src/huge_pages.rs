//! Huge pages for large blocks of memory.
//!
//! A tree of millions of triangles lies on some hundred thousand pages of 4 KB: each is a fault when it is first written, and a
//! walk down the tree misses the translation of its address at nearly every node. Where Linux gives huge pages to those who
//! ask (`madvise`, the usual setting), the allocator below asks. `benches/README.md` has what that is worth.

use nix::sys::mman::{MmapAdvise, madvise};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::NonNull;

/// Of x86-64, in bytes.
const HUGE_PAGE: usize = 2 << 20;

/// Bytes from which a block is worth it: in a virtual machine whose host takes free memory back, a huge page may have to be made
/// anew, and smaller sets of data then take longer to be there than they save.
const LARGE: usize = 32 << 20;

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

/// Asks for huge pages where the block holds whole ones; returns the block.
fn ask(block: *mut u8, size: usize) -> *mut u8 {
    let inside = block.align_offset(HUGE_PAGE);
    if size >= LARGE
        && let Some(first) = NonNull::new(block.wrapping_add(inside))
        && !block.is_null()
    {
        let whole = (size - inside) / HUGE_PAGE * HUGE_PAGE;
        // SAFETY: the range lies in the block, which is the caller's alone, and the advice changes nothing but by what pages
        // the system keeps it. Where there are no huge pages to be had nothing is lost.
        let _ = unsafe { madvise(first.cast(), whole, MmapAdvise::MADV_HUGEPAGE) };
    }
    block
}
