//! State files: the checksum against published values, and files that are not what they say.

use super::add;
use octolux::film::checksum::Checksum;
use octolux::film::{Film, FilmChannels};
use octolux::kernel::Counters;
use octolux::render::StoppedBy;
use octolux::render::state::{Head, Origin, State};
use proptest::prelude::*;
use std::path::Path;

fn xxh64(parts: &[&[u8]]) -> u64 {
    let mut sum = Checksum::default();
    parts.iter().for_each(|part| sum.update(part));
    sum.value()
}

/// Values of the reference implementation (Python's `xxhash` 3).
#[test]
fn the_checksum_is_xxh64() {
    let long: Vec<u8> = (0..1000u32).map(|i| (i * i % 251) as u8).collect();
    for (bytes, expected) in [
        (&b""[..], 0xef46_db37_51d8_e999),
        (b"a", 0xd24e_c4f1_a98c_6e5b),
        (b"abc", 0x44bc_2cf5_ad77_0999),
        (&long[..32], LONG_32),
        (&long[..45], LONG_45),
        (&long, LONG_1000),
    ] {
        assert_eq!(xxh64(&[bytes]), expected, "{} bytes", bytes.len());
        for cut in 0..bytes.len().min(70) {
            assert_eq!(xxh64(&[&bytes[..cut], &bytes[cut..]]), expected, "cut at {cut}");
        }
    }
}

const LONG_32: u64 = 0xabe9_8b51_16e5_ed4d;
const LONG_45: u64 = 0xaad1_e24c_6fe9_c24c;
const LONG_1000: u64 = 0x2d5f_4044_a731_ebd7;

fn head(film: &Film) -> Head {
    let origin = Origin {
        version: "0".into(),
        fingerprint: "f".into(),
        seed: 7,
        sampler: octolux::sampling::SamplerKind::Sobol,
        width: film.width(),
        height: film.height(),
        aovs: film.channels().has_aovs(),
        posterior: film.channels().has_posterior(),
        shares_points: false,
        light_paths: false,
        light_paths_everywhere: true,
        path_reuse: false,
        roulette: "2,0.25".into(),
        sampling: octolux::render::state::SAMPLING,
    };
    Head {
        origin,
        scene: "s".into(),
        tile: film.tile_side(),
        samples: film.samples(),
        stopped_by: StoppedBy::Time,
        render_seconds: 1.5,
        rays: Counters::default(),
    }
}

/// 200 samples from block 3 on: three nodes and an unfinished block.
fn film(channels: FilmChannels) -> Film {
    let mut film = Film::new(7, 5, 3, channels, 3);
    film.tiles_mut().iter_mut().for_each(|tile| add(tile, 192, 200));
    film
}

#[test]
fn a_state_comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.state");
    for channels in [FilmChannels::Colour, FilmChannels::ColourAndAovs, FilmChannels::ColourAovsAndPosterior] {
        let film = film(channels);
        State::save(&head(&film), &film, &path).unwrap();
        let back = State::load(&path).unwrap();
        assert_eq!(back.film, film);
        assert_eq!((back.head.origin.seed, back.head.stopped_by), (7, StoppedBy::Time));
        assert!(film.encoded_bytes() >= std::fs::metadata(&path).unwrap().len() - 1000);
    }
}

fn refusal(path: &Path) -> String {
    let said = State::load(path).expect_err("it was spoilt").to_string();
    assert!(said.contains("a.state") && !said.contains('\n'), "{said}");
    said
}

#[test]
fn a_spoilt_file_is_refused_wherever_it_is_spoilt() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.state");
    let film = film(FilmChannels::Colour);
    State::save(&head(&film), &film, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for at in (0..bytes.len()).step_by(7).chain(0..40).chain(bytes.len() - 12..bytes.len()) {
        let mut spoilt = bytes.clone();
        spoilt[at] ^= 0x10;
        std::fs::write(&path, &spoilt).unwrap();
        refusal(&path);
        std::fs::write(&path, &bytes[..at]).unwrap();
        refusal(&path);
    }
    std::fs::write(&path, [&bytes[..], b"x"].concat()).unwrap();
    refusal(&path);
    std::fs::write(&path, b"v 0 0 0\n").unwrap();
    assert!(refusal(&path).contains("not a state file"));
}

/// Checksums can be right and the claims absurd: nothing of that size is allocated.
#[test]
fn a_small_file_cannot_ask_for_much_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.state");
    let film = film(FilmChannels::Colour);
    for (width, height, tile) in [(65_536, 65_536, 1), (65_536, 65_536, 512), (u32::MAX, u32::MAX, 0), (6, 5, 3)] {
        let mut head = head(&film);
        (head.origin.width, head.origin.height, head.tile) = (width, height, tile);
        State::save(&head, &film, &path).unwrap();
        refusal(&path);
    }
}

type Change = fn(&mut Origin);

#[test]
fn another_version_is_refused_and_so_is_another_scene() {
    let origin = head(&film(FilmChannels::Colour)).origin;
    let path = Path::new("a.state");
    assert!(origin.admit(&origin, path).is_ok());
    let changes: [(&str, Change); 7] = [
        ("version", |o| o.version = "9".into()),
        ("way of making samples", |o| o.sampling = 0),
        ("scene", |o| o.fingerprint = "e".into()),
        ("seed", |o| o.seed = 8),
        ("sampler", |o| o.sampler = octolux::sampling::SamplerKind::Independent),
        ("size", |o| o.width += 1),
        ("channels", |o| o.aovs = true),
    ];
    for (what, change) in changes {
        let mut other = origin.clone();
        change(&mut other);
        let said = origin.admit(&other, path).expect_err(what).to_string();
        assert!(said.contains(what), "{said}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Behind the checksums: sums that read as a film are written again to the same bytes, others are refused.
    #[test]
    fn no_mutation_of_the_sums_panics(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        truncate in any::<bool>(),
        aovs in any::<bool>(),
    ) {
        let film = film(if aovs { FilmChannels::ColourAndAovs } else { FilmChannels::Colour });
        let mut bytes = Vec::new();
        film.encode(&mut bytes).expect("memory");
        for (at, value) in edits {
            let at = at.index(2 * bytes.len());
            let at = if at < bytes.len() { at } else { at % 64 };
            bytes[at] = value;
        }
        if truncate {
            bytes.truncate(cut.index(bytes.len()));
        }
        match Film::decode(film.shape(), &mut &*bytes, bytes.len() as u64) {
            Ok(mut back) => {
                let mut again = Vec::new();
                back.encode(&mut again).expect("memory");
                prop_assert_eq!(again, bytes);
                let _ = back.merge(film);
            }
            Err(error) => prop_assert!(!error.is_empty() && !error.contains(char::is_control), "{error:?}"),
        }
    }
}
