//! Ctrl-C: the first ends the render after the jobs at hand; the third, for those who find even that long, the process.

use std::sync::atomic::{AtomicU32, Ordering};

static PRESSED: AtomicU32 = AtomicU32::new(0);

/// From now on Ctrl-C asks the render to end; a third one ends the process. Call once.
pub fn listen() {
    // Failing to install the handler leaves the default one, which ends the process: nothing better to do.
    let _ = ctrlc::set_handler(|| {
        if PRESSED.fetch_add(1, Ordering::Relaxed) >= 2 {
            std::process::exit(130);
        }
    });
}

/// Has Ctrl-C been pressed?
pub fn asked() -> bool {
    PRESSED.load(Ordering::Relaxed) > 0
}
