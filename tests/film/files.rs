//! A good file is never replaced by half a one.

use super::rendered;
use octolux::film::beside::write_beside;
use octolux::film::exr_write::write_rows;
use octolux::film::{FilmChannels, FilmError, VarianceValidity, write_exr, write_png};
use std::fs;
use std::io::Write;
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_write_that_fails_half_way_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    fs::write(&path, "good").unwrap();
    let result = write_beside(&path, |file| {
        file.write_all(&[7; 100_000]).unwrap();
        assert_eq!(names(folder.path()).len(), 2, "written beside, in the same folder");
        Err("the disk is\nfull")
    });
    let message = result.unwrap_err().to_string();
    assert_eq!(message, format!("{}: cannot write: the disk is full; make room, or write elsewhere", path.display()));
    assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(folder.path())), ("good", vec!["image.exr".into()]));

    write_beside(&path, |file| file.write_all(b"better")).unwrap();
    assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(folder.path()).len()), ("better", 1));
}

#[test]
fn a_row_that_panics_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    fs::write(&path, "good").unwrap();
    let panicked = std::panic::catch_unwind(|| {
        write_rows(&path, (4, 200), &["R", "G", "B"], &[], |y, _| assert!(y < 150, "an expected panic of this test"))
    });
    assert!(panicked.is_err());
    assert_eq!(fs::read_to_string(&path).unwrap(), "good");
}

#[test]
fn images_that_cannot_be_written_are_one_line_errors_with_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let film = rendered((2, 2), 2, FilmChannels::Colour, 2, 2);
    fs::create_dir(folder.path().join("folder.exr")).unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    for place in ["folder.exr", "missing/image.exr", "file/image.exr", "folder.exr/..", ""] {
        let path = folder.path().join(place);
        let exr = write_exr(&film, &path, &[], VarianceValidity::Independent);
        for error in [exr.unwrap_err(), write_png(&film, &path, 0.0).unwrap_err()] {
            assert!(matches!(error, FilmError::Write { .. }));
            let message = error.to_string();
            assert!(message.starts_with(&path.display().to_string()) && !message.contains('\n'), "{message}");
        }
    }
    assert_eq!(names(folder.path()), ["file", "folder.exr"]);
    assert!(names(&folder.path().join("folder.exr")).is_empty());
}

#[test]
fn bad_attribute_names_and_empty_images_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let film = rendered((2, 2), 2, FilmChannels::Colour, 2, 2);
    for name in [String::new(), "x".repeat(256), "a\0b".into()] {
        assert!(write_exr(&film, &path, &[(name, 1.0f32.into())], VarianceValidity::Independent).is_err());
    }
    let empty = octolux::film::Film::new(0, 0, 8, FilmChannels::Colour, 0);
    assert!(write_exr(&empty, &path, &[], VarianceValidity::Independent).is_err());
    assert!(write_png(&empty, &path, 0.0).is_err());
    assert!(write_rows(&path, (1, 1), &["R", "R"], &[], |_, _| ()).is_err());
    assert!(names(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_are_not_replaced() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real.bin"), folder.path().join("link.bin"));
    fs::write(&real, "old").unwrap();
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real.bin", &link).unwrap();
    write_beside(&link, |file| file.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(&real).unwrap(), "new");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);

    let null = Path::new("/dev/null");
    write_beside(null, |file| file.write_all(b"gone")).unwrap();
    assert!(fs::metadata(null).unwrap().file_type().is_char_device());
    let full = Path::new("/dev/full");
    if full.exists() {
        assert!(write_beside(full, |file| file.write_all(b"no room")).is_err());
    }
}
