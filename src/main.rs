//! The `octolux` command: arguments in, one library call, exit code out.

use octolux::huge_pages::HugePages;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: HugePages = HugePages;

fn main() -> ExitCode {
    // Before anything that may hold vector instructions.
    if let Err(feature) = octolux::cpu::guard() {
        eprintln!(
            "octolux: this build uses {feature}, which this CPU lacks; build with RUSTFLAGS=\"-C target-cpu=x86-64-v3\" or on this machine"
        );
        return ExitCode::from(2);
    }
    octolux::cli::run()
}
