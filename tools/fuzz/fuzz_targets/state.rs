#![no_main]
//! Any bytes as the sums of a state file, behind its checksums: width, height, tile and channels in a byte each, then the sums.
//! What is read is written again to the same bytes, and merges or is refused.

use octolux::film::codec::FilmShape;
use octolux::film::{Film, FilmChannels};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((&[width, height, tile, aovs], sums)) = data.split_first_chunk::<4>() else { return };
    let channels = if aovs & 1 == 0 { FilmChannels::Colour } else { FilmChannels::ColourAndAovs };
    let shape = FilmShape { width: width.into(), height: height.into(), tile: tile.into(), channels };
    match Film::decode(shape, &mut &*sums, sums.len() as u64) {
        Ok(mut film) => {
            let mut again = Vec::new();
            film.encode(&mut again).expect("memory");
            assert_eq!(again, sums);
            let _ = film.relative_error();
            let _ = film.merge(film.clone());
        }
        Err(error) => assert!(!error.contains('\n'), "{error}"),
    }
});
