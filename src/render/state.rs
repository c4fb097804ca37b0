//! State files: a film's sums and what they belong to, so that a render can go on later or be merged from parts.
//!
//! The bytes: `OCTOLUXS`, form of the file (u32), length of the head (u32), the head (JSON), its XXH64, the sums
//! ([`Film::encode`]), their XXH64. Both checksums are looked at before what they cover is believed.

use super::StoppedBy;
use crate::film::beside::{is_stream, write_durably};
use crate::film::checksum::{Checksum, Summed};
use crate::film::codec::FilmShape;
use crate::film::{Film, FilmChannels, FilmError};
use crate::kernel::Counters;
use crate::sampling::SamplerKind;
use crate::scene::Roulette;
use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"OCTOLUXS";
/// Raised when the bytes change their meaning.
const FORM: u32 = 2;
/// The head is some hundred bytes and a file name.
const LONGEST_HEAD: u32 = 1 << 16;
/// Bytes around head and sums.
const FRAME: u64 = 8 + 4 + 4 + 8 + 8;

/// What a film's samples were computed from. Films of equal origin merge; others are of different images.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Origin {
    pub version: String,
    /// [`Scene::fingerprint`](crate::scene::Scene::fingerprint), in hexadecimal.
    pub fingerprint: String,
    pub seed: u64,
    pub sampler: SamplerKind,
    pub width: u32,
    pub height: u32,
    pub aovs: bool,
    /// Are posterior variances among them?
    #[serde(default)]
    pub posterior: bool,
    /// See [`Integrator::shares_points`](crate::scene::Integrator::shares_points).
    #[serde(default)]
    pub shares_points: bool,
    /// Are paths from the lights among them?
    #[serde(default)]
    pub light_paths: bool,
    /// Do they bring light that light samples find, too? States that do not say are of a time when all did.
    #[serde(default = "everywhere")]
    pub light_paths_everywhere: bool,
    /// Do pixels share paths?
    #[serde(default)]
    pub path_reuse: bool,
    /// See [`Roulette`], as the command line has it; states that do not say are of a time when there was but one.
    #[serde(default = "usual_roulette")]
    pub roulette: String,
    /// [`SAMPLING`] of the build that began it; states that do not say are of a time before there was a number.
    #[serde(default)]
    pub sampling: u32,
}

/// Raised by a change that gives samples of the same scene, options and seed other values: a state goes on only where its samples
/// would be made again. (1: two triangles of a lamp are sampled as one, along slopes.
/// 2: the pixels that share paths stand in another order; images of normals soften by themselves.
/// 3: pixels of a block share the scrambling of their Sobol' points.
/// 4: finds of dark first vertices are shared as often as their neighbours need.)
pub const SAMPLING: u32 = 4;

fn everywhere() -> bool {
    true
}

fn usual_roulette() -> String {
    Roulette::USUAL.to_string()
}

/// The first lines of a state file.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Head {
    #[serde(flatten)]
    pub origin: Origin,
    /// The scene's path, for people.
    pub scene: String,
    pub tile: u32,
    /// Samples that every pixel has.
    pub samples: u64,
    pub stopped_by: StoppedBy,
    pub render_seconds: f64,
    pub rays: Counters,
}

/// A film and its history.
#[derive(Clone, Debug)]
pub struct State {
    pub head: Head,
    pub film: Film,
}

/// A state cannot be used. One line: the file, what is wrong, what to do.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    #[error("{}: {why}", path.display())]
    Unreadable { path: PathBuf, why: String },
    #[error("{}: is of another {what} ({theirs}, here {ours}); {mend}", path.display())]
    Foreign { path: PathBuf, what: &'static str, theirs: String, ours: String, mend: String },
    #[error("{}: {why}", path.display())]
    Merge { path: PathBuf, why: crate::film::MergeError },
}

/// What of an origin is compared, as a person reads it.
type Fact = fn(&Origin) -> String;

impl Origin {
    /// Refuses a state whose origin differs from this one.
    ///
    /// # Errors
    /// What differs first.
    pub fn admit(&self, theirs: &Origin, path: &Path) -> Result<(), StateError> {
        let size = |origin: &Origin| format!("{}x{}", origin.width, origin.height);
        let aovs = |origin: &Origin| if origin.aovs { "with --aovs" } else { "without --aovs" }.to_string();
        let seed = |origin: &Origin| origin.seed.to_string();
        let version = |origin: &Origin| origin.version.clone();
        let scene = |origin: &Origin| origin.fingerprint.clone();
        let sampler = |origin: &Origin| origin.sampler.name().to_string();
        let light_paths = |origin: &Origin| match (origin.light_paths, origin.light_paths_everywhere) {
            (false, _) => "off".to_string(),
            (true, false) => "auto".to_string(),
            (true, true) => "on".to_string(),
        };
        let path_reuse = |origin: &Origin| if origin.path_reuse { "auto" } else { "off" }.to_string();
        let roulette = |origin: &Origin| origin.roulette.clone();
        let sampling = |origin: &Origin| origin.sampling.to_string();
        let facts: [(_, Fact, String); 10] = [
            ("version of octolux", version, "go on with the one that began it".to_string()),
            ("way of making samples", sampling, "go on with the build of octolux that began it".to_string()),
            ("size", size, format!("give --size {}", size(theirs))),
            ("seed", seed, format!("give --seed {}", theirs.seed)),
            ("sampler", sampler, format!("give --sampler {}", theirs.sampler.name())),
            ("way of light paths", light_paths, format!("give --light-paths {}", light_paths(theirs))),
            ("way of path reuse", path_reuse, format!("give --path-reuse {}", path_reuse(theirs))),
            ("roulette", roulette, format!("give --roulette {}", theirs.roulette)),
            ("set of channels", aovs, "give --aovs to all or to none".to_string()),
            ("scene", scene, "it goes on only with the scene, meshes and images as they were".to_string()),
        ];
        match facts.into_iter().find(|(_, fact, _)| fact(self) != fact(theirs)) {
            None => Ok(()),
            Some((what, fact, mend)) => {
                Err(StateError::Foreign { path: path.to_owned(), what, theirs: fact(theirs), ours: fact(self), mend })
            }
        }
    }
}

impl State {
    /// Writes head and film to `path`: beside it, synced to the disk, then renamed.
    ///
    /// # Errors
    /// The file cannot be written; the one before is then still there.
    pub fn save(head: &Head, film: &Film, path: &Path) -> Result<(), FilmError> {
        write_durably(path, |file| {
            let text = serde_json::to_vec(head).map_err(std::io::Error::from)?;
            let mut sum = Checksum::default();
            sum.update(&text);
            file.write_all(MAGIC)?;
            file.write_all(&FORM.to_le_bytes())?;
            file.write_all(&(text.len() as u32).to_le_bytes())?;
            file.write_all(&text)?;
            file.write_all(&sum.value().to_le_bytes())?;
            let mut summed = Summed::new(file);
            film.encode(&mut summed)?;
            let value = summed.sum.value();
            summed.write_all(&value.to_le_bytes())
        })
    }

    /// Reads a state file.
    ///
    /// # Errors
    /// No such file, not a state file, one of another form, a damaged one.
    pub fn load(path: &Path) -> Result<State, StateError> {
        read(path).map_err(|why| StateError::Unreadable { path: path.to_owned(), why })
    }

    /// Takes over the samples of another state, read from `path`.
    ///
    /// # Errors
    /// It is of another origin, or its samples overlap or do not fit.
    pub fn merge(&mut self, other: State, path: &Path) -> Result<(), StateError> {
        self.head.origin.admit(&other.head.origin, path)?;
        self.film.merge(other.film).map_err(|why| StateError::Merge { path: path.to_owned(), why })?;
        self.head.samples = self.film.samples();
        self.head.render_seconds += other.head.render_seconds;
        self.head.rays.add(&other.head.rays);
        self.head.stopped_by = self.head.stopped_by.with(other.head.stopped_by);
        Ok(())
    }
}

fn read(path: &Path) -> Result<State, String> {
    let unreadable = |error: std::io::Error| format!("cannot read: {error}; check the path and its permissions");
    if is_stream(path) {
        return Err("is not a regular file; name a state file".to_owned());
    }
    let file = File::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut input = BufReader::with_capacity(1 << 20, file);
    let magic: [u8; 8] = array(&mut input).unwrap_or_default();
    if &magic != MAGIC {
        return Err("is not a state file; name one that `render --state` wrote".to_owned());
    }
    let form = u32::from_le_bytes(array(&mut input)?);
    if form != FORM {
        return Err(format!(
            "is a state file of form {form}, this version reads form {FORM}; use the version that wrote it"
        ));
    }
    let head_length = u32::from_le_bytes(array(&mut input)?);
    let sums_length = length.checked_sub(FRAME + u64::from(head_length));
    let Some(sums_length) = sums_length.filter(|_| head_length <= LONGEST_HEAD) else {
        return Err(DAMAGED.to_owned());
    };
    let mut text = vec![0; head_length as usize];
    input.read_exact(&mut text).map_err(unreadable)?;
    let mut sum = Checksum::default();
    sum.update(&text);
    if u64::from_le_bytes(array(&mut input)?) != sum.value() {
        return Err(DAMAGED.to_owned());
    }
    let head: Head = serde_json::from_slice(&text).map_err(|_| DAMAGED.to_owned())?;
    let channels = FilmChannels::of(head.origin.aovs, head.origin.posterior);
    let shape = FilmShape { width: head.origin.width, height: head.origin.height, tile: head.tile, channels };
    let mut summed = Summed::new(&mut input);
    let film = Film::decode(shape, &mut summed, sums_length).map_err(|why| format!("{why}; {USE_ANOTHER}"))?;
    let sum = summed.sum.value();
    if u64::from_le_bytes(array(&mut input)?) != sum {
        return Err(DAMAGED.to_owned());
    }
    Ok(State { head, film })
}

const DAMAGED: &str = "is damaged or cut short; use an earlier copy, or render anew";
const USE_ANOTHER: &str = "use an earlier copy, or render anew";

fn array<const N: usize>(input: &mut impl Read) -> Result<[u8; N], String> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes).map_err(|_| DAMAGED.to_owned())?;
    Ok(bytes)
}
