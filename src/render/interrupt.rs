//! Ctrl-C. Before there is anything to keep it ends the process. Then the first ends the render after the jobs at hand; the third,
//! for those who find even that long, the process.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

static PRESSED: AtomicU32 = AtomicU32::new(0);
static KEEPS: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C calls `leave`, once there is something to [`keep`] asks the render to end, and pressed three times ends the
/// process. Call once.
pub fn listen(leave: fn()) {
    // Failing to install the handler leaves the default one, which ends the process: nothing better to do.
    let _ = ctrlc::set_handler(move || {
        if !KEEPS.load(Ordering::Relaxed) {
            leave();
        } else if PRESSED.fetch_add(1, Ordering::Relaxed) >= 2 {
            std::process::exit(130);
        }
    });
}

/// From now on there is something to keep.
pub fn keep() {
    KEEPS.store(true, Ordering::Relaxed);
}

/// Has Ctrl-C been pressed?
pub fn asked() -> bool {
    PRESSED.load(Ordering::Relaxed) > 0
}
