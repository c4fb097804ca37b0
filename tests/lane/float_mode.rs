//! Workers compute as IEEE 754 has it, whatever the thread that made them does.

use octolux::lane::float_mode;
use octolux::render;
use std::hint::black_box;

/// FTZ, DAZ and rounding towards zero, all exceptions masked: what a host built with -ffast-math leaves, and worse.
const FLUSHING: u32 = 0xffc0;

/// Runs `f` on a thread of its own with another mode, as the library would be called from such a host.
fn in_a_flushing_host<T: Send>(f: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let host = scope.spawn(|| {
            let mode = FLUSHING;
            // SAFETY: a valid MXCSR, on a thread that ends here and restores it before anything is judged.
            unsafe { core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const mode, options(nostack, readonly)) };
            let result = f();
            float_mode::restore();
            result
        });
        host.join().expect("the host thread")
    })
}

fn halved_smallest_normal() -> f32 {
    black_box(f32::MIN_POSITIVE) * black_box(0.5)
}

#[test]
fn the_other_mode_is_seen() {
    assert!(float_mode::is_default());
    let (default, halved) = in_a_flushing_host(|| (float_mode::is_default(), halved_smallest_normal()));
    assert!(!default);
    assert_eq!(halved, 0.0, "the host does not flush: this file tests nothing");
}

/// Without the workers' start handler they inherit the host's mode: halved subnormals are 0 in all of them.
#[test]
fn workers_of_a_flushing_host_do_not_flush() {
    let found = in_a_flushing_host(|| {
        let pools = [render::thread_pool(3), render::pinned_thread_pool(2)].map(|pool| pool.expect("threads"));
        let workers =
            pools.iter().flat_map(|pool| pool.broadcast(|_| (float_mode::is_default(), halved_smallest_normal())));
        workers.collect::<Vec<_>>()
    });
    assert_eq!(found.len(), 5);
    assert!(found.iter().all(|&(default, halved)| default && halved == f32::MIN_POSITIVE / 2.0), "{found:?}");
}

#[test]
fn an_image_of_a_flushing_host_has_the_same_bits() {
    let world = crate::renders::world(&crate::equivalence::scenes::everything(), 3);
    let film = |pool: &rayon::ThreadPool| crate::renders::film_on(pool, &world, 4, crate::renders::How::default());
    let expected = film(&render::thread_pool(2).expect("threads"));
    let found = in_a_flushing_host(|| film(&render::thread_pool(2).expect("threads")));
    crate::equivalence::assert_same("rendered from a flushing host", &found, &expected);
}
