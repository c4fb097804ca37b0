//! The command line: one file a command.

mod bench;
mod check;
mod check_numerics;
mod converge;
mod error;
mod estimate;
mod info;
mod keeper;
mod ladder;
mod merge;
mod problem;
mod render;
mod replay;
mod replay_text;
mod scene_args;
mod state_args;
mod targets;
mod usage;
mod variants;

pub use error::CliError;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// A CPU Monte Carlo renderer kernel: 8-wide ray packets, BRDF·cos/pdf in SoA lanes, the same bits at any width.
#[derive(Parser)]
#[command(version, about, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene file or a bare OBJ model
    Render(render::RenderArgs),
    /// Make one image of states rendered in parts, bit for bit as if rendered at once
    Merge(merge::MergeArgs),
    /// Compare two EXR images: RMSE, relMSE, mean ratio, z-scores
    Compare(crate::report::CompareArgs),
    /// Prove on a scene that lane width, threads, tiles and specialisation leave no trace in the bits; or with
    /// --numerics hold this build on this CPU to the catalogue of extreme cases
    Check(check::CheckArgs),
    /// Say what a scene holds: primitives, materials, lights, bounds, memory, plan
    Info(info::InfoArgs),
    /// Print one path: every vertex of a pixel's sample, what it met and what it added
    Replay(replay::ReplayArgs),
    /// Measure error against samples and run time, and write the report of it
    Converge(converge::ConvergeArgs),
    /// Measure paths per second on a scene, or rays per second on recorded rays
    Bench(bench::BenchArgs),
    /// Study estimators on problems with known answers: error against samples and run time
    Estimate(estimate::EstimateArgs),
    /// Print a completion script: `octolux completions bash > ~/.local/share/bash-completion/completions/octolux`
    Completions {
        /// bash, zsh, fish, elvish or powershell
        shell: clap_complete::Shell,
    },
}

/// Runs the command of this process's arguments.
#[inline(never)]
pub fn run() -> ExitCode {
    // The age of the process is read first of all, so that budgets count from exec.
    crate::process::seconds_since_process_start();
    end_with_the_reader();
    log_to_stderr();
    let cli = match parse() {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let result = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Compare(args) => compare(&args),
        Command::Check(args) => check::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "octolux", &mut script);
            print!("{}", String::from_utf8_lossy(&script));
            Ok(true)
        }
        Command::Replay(args) => replay::run(&args),
        Command::Converge(args) => converge::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Estimate(args) => estimate::run(&args),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            complain(&error);
            ExitCode::from(FAILED)
        }
    }
}

/// Of this process's arguments. Where there is nothing to do but to print, or to complain, that is done: the exit code.
fn parse() -> Result<Cli, ExitCode> {
    let mut command = usage::with_negative_numbers(Cli::command());
    let parsed =
        command.try_get_matches_from_mut(std::env::args_os()).and_then(|matches| Cli::from_arg_matches(&matches));
    parsed.map_err(|error| match usage::complaint(&error) {
        Some(complaint) => {
            let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
            complain(&CliError::Usage(complaint.line(&command, words)));
            ExitCode::from(FAILED)
        }
        None => error.exit(),
    })
}

/// Exit code of bad input, and of all that was in vain.
const FAILED: u8 = 2;

fn complain(error: &CliError) {
    // `eprintln!` would panic where nobody listens, and a script be given another exit code.
    crate::process::tell(format_args!("octolux: {}\n", printable(&error.to_string())));
}

/// Ends the process where there is nothing to keep yet.
fn leave() {
    complain(&CliError::Interrupted);
    std::process::exit(FAILED.into());
}

fn compare(args: &crate::report::CompareArgs) -> Result<bool, CliError> {
    let written = args.json.iter().filter(|path| path.as_os_str() != "-").chain(&args.diff);
    targets::check_apart(written.map(PathBuf::as_path), [args.a.as_path(), args.b.as_path()])?;
    Ok(crate::report::compare_command(args)?)
}

/// What a file says may hold control characters, which a terminal would obey.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// What a shell says of a program that SIGPIPE ended, as it ends those that write to a reader that is gone.
const BROKEN_PIPE: i32 = 128 + 13;

/// Where the reader of what is printed goes away (`| head`), the command ends without a word: Rust ignores the signal that would
/// do that, and `print!` panics instead. So it does where a disk is full, of which a line is said.
fn end_with_the_reader() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let Some(why) = panic.payload_as_str().and_then(|text| text.strip_prefix("failed printing to ")) else {
            return report(panic);
        };
        if why.contains("os error 32") {
            std::process::exit(BROKEN_PIPE);
        }
        crate::process::tell(format_args!("octolux: {why}; write where there is room\n"));
        std::process::exit(FAILED.into());
    }));
}

/// The library's warnings go to standard error, a line each.
fn log_to_stderr() {
    struct Stderr;
    impl log::Log for Stderr {
        fn enabled(&self, metadata: &log::Metadata) -> bool {
            metadata.level() <= log::Level::Warn && metadata.target().starts_with("octolux")
        }
        fn log(&self, record: &log::Record) {
            if self.enabled(record.metadata()) {
                let text = printable(&record.args().to_string());
                crate::process::tell(format_args!("octolux: {}: {text}\n", record.level().as_str().to_lowercase()));
            }
        }
        fn flush(&self) {}
    }
    // It can only fail where a logger is set already: then that one serves.
    if log::set_logger(&Stderr).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}
