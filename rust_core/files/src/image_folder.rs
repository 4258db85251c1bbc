//! Folders of a camera's images, in the order of their names.

use std::io;
use std::path::{Path, PathBuf};

use crate::FileError;

/// Extensions of image files that are read.
const EXTENSIONS: [&str; 9] = ["png", "jpg", "jpeg", "bmp", "tif", "tiff", "pgm", "ppm", "webp"];

/// Extensions of the image files that are read, for messages.
pub fn extensions() -> String {
    EXTENSIONS.map(|extension| format!(".{extension}")).join(", ")
}

/// The image files in a folder, in the natural order of their names. Hidden files, such as macOS's `._IMG.JPG`, are
/// none.
///
/// # Errors
/// [`FileError`] with the folder, if it cannot be read.
pub fn images(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let is_image = |path: &PathBuf| {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        extension.is_some_and(|extension| EXTENSIONS.contains(&&*extension)) && !path.is_dir()
    };
    Ok(entries(folder)?.into_iter().filter(is_image).collect())
}

/// The folders in a folder, in the natural order of their names, but for hidden ones.
///
/// # Errors
/// [`FileError`] with the folder, if it cannot be read.
pub fn subfolders(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    Ok(entries(folder)?.into_iter().filter(|path| path.is_dir()).collect())
}

/// Entries of a folder that are not hidden, in the natural order of their names.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let list = || std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>();
    let mut paths = list().map_err(|error| FileError::new(folder, error))?;
    paths.retain(|path| !name(path).starts_with('.'));
    paths.sort_by_cached_key(|path| natural_key(path));
    Ok(paths)
}

fn name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Orders names with their numbers by value: `frame2-cam0` comes before `frame10-cam0`, whether zeros lead or not. Each
/// part is a text and the number behind it, by its length and digits; the name itself decides between equal ones.
fn natural_key(path: &Path) -> (Vec<(String, usize, String)>, String) {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    let (mut parts, mut rest) = (Vec::new(), &*stem);
    while !rest.is_empty() {
        let (text, from_number) = rest.split_at(rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len()));
        let is_end = |c: char| !c.is_ascii_digit();
        let (number, next) = from_number.split_at(from_number.find(is_end).unwrap_or(from_number.len()));
        let digits = number.trim_start_matches('0');
        parts.push((text.to_owned(), digits.len(), digits.to_owned()));
        rest = next;
    }
    (parts, name(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with empty files and, for names with a slash, folders.
    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            match name.strip_suffix('/') {
                Some(name) => std::fs::create_dir(folder.path().join(name)).unwrap(),
                None => std::fs::write(folder.path().join(name), "").unwrap(),
            }
        }
        folder
    }

    fn names(paths: Result<Vec<PathBuf>, FileError>) -> Vec<String> {
        paths.unwrap().iter().map(|path| name(path)).collect()
    }

    #[test]
    fn names_are_in_natural_order() {
        for sorted in [
            ["frame2-cam0.png", "frame10-cam0.png", "frame10-cam1.png", "frame11-cam0.png"],
            ["IMG_0001.JPG", "IMG_2.JPG", "IMG_0010.JPG", "IMG_99999999999999999999999.JPG"],
            ["01.pgm", "2.webp", "10.PPM", "black.tiff"],
            ["a 01.png", "a 1.png", "a 1 1.png", "a 1 2.png"],
        ] {
            let shuffled = [sorted[2], sorted[0], sorted[3], sorted[1]];
            assert_eq!(names(images(folder(&shuffled).path())), sorted);
        }
        assert_eq!(names(subfolders(folder(&["pose10/", "pose9/", "pose1/"]).path())), ["pose1", "pose9", "pose10"]);
    }

    #[test]
    fn hidden_files_and_those_without_an_image_are_passed_over() {
        let mixed = folder(&["._IMG_1.JPG", ".thumbnails/", "IMG_1.JPG", "notes.txt", "p1/", "png", "x.png/", ".png"]);
        assert_eq!(names(images(mixed.path())), ["IMG_1.JPG"]);
        assert_eq!(names(subfolders(mixed.path())), ["p1", "x.png"]);
        let missing = images(&mixed.path().join("missing")).unwrap_err().to_string();
        assert!(missing.contains("missing: "), "{missing}");
        assert!(extensions().starts_with(".png, .jpg, ") && extensions().ends_with(".webp"), "{}", extensions());
    }
}
