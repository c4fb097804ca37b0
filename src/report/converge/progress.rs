//! How far a study is: a bar at a terminal, plain lines elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Plain lines come this far apart at least.
const LINE_EVERY: Duration = Duration::from_secs(1);

/// Counts cells; what is left to do is judged by their samples, since time goes with these.
pub struct CellProgress {
    bar: Option<ProgressBar>,
    plain: bool,
    cells: usize,
    done: usize,
    work: f64,
    work_done: f64,
    start: Instant,
    last: Option<Instant>,
}

impl CellProgress {
    pub fn new(cells: usize, done: usize, work: f64, quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = (terminal && !quiet).then(|| {
            let bar = ProgressBar::with_draw_target(Some(cells as u64), ProgressDrawTarget::stderr());
            // The template is a constant; if it were wrong the default style would serve.
            ProgressStyle::with_template("{bar:32} {msg}").map_or(bar.clone(), |style| bar.with_style(style))
        });
        let start = Instant::now();
        CellProgress { bar, plain: !terminal && !quiet, cells, done, work, work_done: 0.0, start, last: None }
    }

    pub fn start(&mut self, cell: &str) {
        let left = match self.work_done > 0.0 {
            true => {
                let seconds = self.start.elapsed().as_secs_f64() * (self.work - self.work_done) / self.work_done;
                format!("ETA {}", duration(seconds))
            }
            false => "ETA -".to_owned(),
        };
        let message = format!("cell {} of {}: {cell}  {left}", self.done + 1, self.cells);
        if let Some(bar) = &self.bar {
            bar.set_position(self.done as u64);
            bar.set_message(message);
        } else if self.plain && self.last.is_none_or(|last| last.elapsed() >= LINE_EVERY) {
            self.last = Some(Instant::now());
            crate::process::tell(format_args!("{message}\n"));
        }
    }

    pub fn finish(&mut self, work: f64) {
        self.done += 1;
        self.work_done += work;
    }

    pub fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if self.plain || self.bar.is_some() {
            crate::process::tell(format_args!("{} of {} cells finished\n", self.done, self.cells));
        }
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
