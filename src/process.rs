//! What the operating system knows of this process.

use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::time::{ClockId, clock_gettime};
use nix::unistd::Pid;
use std::sync::OnceLock;
use std::time::Instant;

/// Wall-clock seconds since this process was started by exec, by the kernel's record where it can be read, else (and
/// under `cargo run`) since the first call.
pub fn seconds_since_process_start() -> f64 {
    static ORIGIN: OnceLock<(Instant, f64)> = OnceLock::new();
    // `cargo run` becomes the program it has built: the process is then as old as the compilation.
    let under_cargo = || std::env::var_os("CARGO").is_some();
    let age = || if under_cargo() { 0.0 } else { process_age().unwrap_or(0.0) };
    let (instant, age) = ORIGIN.get_or_init(|| (Instant::now(), age()));
    age + instant.elapsed().as_secs_f64()
}

/// Says on standard error how work goes on. Where nobody reads that any more (`2>&1 | head`) the work goes on all the same:
/// `eprintln!` would end it.
pub fn tell(text: std::fmt::Arguments) {
    use std::io::Write;
    // Nothing could be done about it, and nobody be told.
    let _ = std::io::stderr().write_fmt(text);
}

/// The command line that this process was given, quoted where a shell needs it.
pub fn command_line() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+".contains(c);
    let quoted = |word: std::ffi::OsString| {
        let word = word.to_string_lossy();
        match !word.is_empty() && word.chars().all(plain) {
            true => word.into_owned(),
            false => format!("'{}'", word.replace('\'', "'\\''")),
        }
    };
    let words = std::env::args_os().skip(1).map(quoted);
    std::iter::once("octolux".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Age from /proc: start time in clock ticks since boot (field 22 of stat), and the uptime. Linux counts 100 ticks a
/// second for user space on every architecture it runs on.
fn process_age() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is the program's name in parentheses and may hold blanks.
    let start: f64 = stat.rsplit_once(')')?.1.split_whitespace().nth(19)?.parse().ok()?;
    let uptime: f64 = std::fs::read_to_string("/proc/uptime").ok()?.split_whitespace().next()?.parse().ok()?;
    Some((uptime - start / 100.0).max(0.0))
}

/// The largest resident set so far; `None` where /proc does not tell.
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// The cores this process may run on; empty where that cannot be told.
pub fn allowed_cores() -> Vec<usize> {
    let Ok(set) = sched_getaffinity(Pid::from_raw(0)) else { return Vec::new() };
    (0..CpuSet::count()).filter(|&core| set.is_set(core).unwrap_or(false)).collect()
}

/// Keeps the calling thread on one core. Where that is not allowed it stays where it is: measurements are then noisier.
pub fn pin_to_core(core: usize) {
    let mut set = CpuSet::new();
    if set.set(core).is_ok() {
        let _ = sched_setaffinity(Pid::from_raw(0), &set);
    }
}

/// Processor time that the calling thread has used, in seconds; 0 where the system does not tell.
pub fn thread_cpu_seconds() -> f64 {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).map_or(0.0, |t| t.tv_sec() as f64 + 1e-9 * t.tv_nsec() as f64)
}

/// The processor's name; `None` where /proc does not tell.
pub fn cpu_model() -> Option<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = info.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Processor seconds of all threads of this process so far; 0 where the system does not tell.
pub fn cpu_seconds() -> f64 {
    clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).map_or(0.0, |t| t.tv_sec() as f64 + 1e-9 * t.tv_nsec() as f64)
}
