//! `octolux merge`: states of parts of a render become one, bit for bit as if rendered on one machine.

use super::CliError;
use super::targets::{Facts, ImageArgs, check_apart, check_folders, same_file};
use crate::render::{self, Phase, State};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct MergeArgs {
    /// States of the same scene, seed and size, of ranges that do not overlap; in any order
    #[arg(required = true, value_name = "FILE.state")]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    images: ImageArgs,
    /// Keep the merged state, to go on with it or to merge it further
    #[arg(long, value_name = "FILE.state")]
    state: Option<PathBuf>,
    /// Say nothing
    #[arg(long)]
    quiet: bool,
}

pub fn run(args: &MergeArgs) -> Result<bool, CliError> {
    if args.images.files().next().is_none() && args.state.is_none() {
        return Err(CliError::Usage("nothing to write: give -o OUT.exr, --png OUT.png or --state OUT.state".into()));
    }
    args.images.check()?;
    check_folders(args.images.files().chain(args.state.as_deref()))?;
    // What is merged may take the place of a part, an image may not.
    check_apart(args.images.files(), args.parts.iter().map(PathBuf::as_path))?;
    check_apart(args.images.files().chain(args.state.as_deref()), [])?;
    let phase = Phase::begin("reading states", args.quiet);
    let mut parts = args.parts.iter().map(PathBuf::as_path);
    let mut load = || parts.next().map(|path| Ok::<_, CliError>((path, State::load(path)?))).transpose();
    let Some((_, mut whole)) = load()? else { return Ok(true) };
    while let Some((path, part)) = load()? {
        whole.merge(part, path)?;
    }
    let is_part = |path: &Path| args.parts.iter().any(|part| same_file(part, path));
    if let Some(path) = args.state.as_deref().filter(|path| path.is_file() && !is_part(path)) {
        check_replaced(path, &whole)?;
    }
    drop(phase);
    let phase = Phase::begin("writing", args.quiet);
    write(args, &whole)?;
    drop(phase);
    if !args.quiet {
        let (samples, parts) = (whole.film.samples(), args.parts.len());
        let relative_error = whole.film.relative_error();
        let error = relative_error.map_or(String::new(), |e| format!(", relative error {e:.5}"));
        crate::process::tell(format_args!("{samples} samples per pixel from {parts} states{error}\n"));
        if let Some(e) = relative_error {
            crate::process::tell(format_args!("{}", whole.film.sample_shares(e)));
        }
    }
    Ok(true)
}

/// A state that is none of the parts gives way to one that holds all of its samples, as of an earlier merge, and to no other.
fn check_replaced(path: &Path, whole: &State) -> Result<(), CliError> {
    let there = State::load(path)?;
    let same = whole.head.origin.admit(&there.head.origin, path).is_ok();
    if same && whole.film.covers(&there.film) {
        return Ok(());
    }
    let path = path.display();
    Err(CliError::Usage(format!(
        "{path}: holds samples of none of the parts; merge it too, remove it, or name another file"
    )))
}

fn write(args: &MergeArgs, whole: &State) -> Result<(), CliError> {
    if let Some(path) = &args.state {
        State::save(&whole.head, &whole.film, Path::new(path))?;
    }
    let head = &whole.head;
    let facts = Facts {
        scene: head.scene.clone(),
        render_seconds: head.render_seconds,
        seed: head.origin.seed,
        sampler: head.origin.sampler,
        stopped_by: head.stopped_by,
        shares_points: head.origin.shares_points,
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    render::thread_pool(threads)?.install(|| args.images.write(&whole.film, &facts))
}
