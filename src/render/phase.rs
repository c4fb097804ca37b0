//! A sign of life from a phase that has no end in sight: its name and the seconds since it began.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Plain lines come this far apart; a terminal's line moves more often.
const LINE_EVERY: Duration = Duration::from_secs(1);
const TICK: Duration = Duration::from_millis(100);

/// Tells that a phase is going on, from now until it is dropped.
pub struct Phase {
    bar: Option<ProgressBar>,
    lines: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Phase {
    /// On standard error; says nothing where `quiet`.
    pub fn begin(name: &str, quiet: bool) -> Self {
        if quiet {
            return Phase { bar: None, lines: None };
        }
        if !std::io::stderr().is_terminal() {
            return Phase { bar: None, lines: lines(name.to_string()) };
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        // The template is a constant; if it were wrong the default style would serve.
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(name.to_string());
        bar.enable_steady_tick(TICK);
        Phase { bar: Some(bar), lines: None }
    }
}

/// A line a second; none where the system gives no thread for it.
fn lines(name: String) -> Option<(Sender<()>, JoinHandle<()>)> {
    let (sender, receiver) = channel();
    let start = Instant::now();
    let tell = move || {
        while receiver.recv_timeout(LINE_EVERY) == Err(RecvTimeoutError::Timeout) {
            crate::process::tell(format_args!("{name} {:.0} s\n", start.elapsed().as_secs_f64()));
        }
    };
    Some((sender, std::thread::Builder::new().spawn(tell).ok()?))
}

impl Drop for Phase {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if let Some((sender, thread)) = self.lines.take() {
            drop(sender);
            // It prints and nothing else: it cannot have failed.
            let _ = thread.join();
        }
    }
}
