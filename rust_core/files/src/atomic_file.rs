//! Files that appear whole or not at all: each is written beside its place under another name and renamed, so that a
//! script may wait for it to exist, and a failure leaves the file of before.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes one file with `write`, replacing one that is there. The folder must exist. `io_error` wraps the system's
/// errors.
///
/// # Errors
/// Those of `write`, and the system's.
pub fn write_atomically<E>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
    io_error: impl Fn(io::Error) -> E,
) -> Result<(), E> {
    let unfinished = unfinished_name(path);
    let written = (|| {
        let mut file = BufWriter::new(File::create(&unfinished).map_err(&io_error)?);
        write(&mut file)?;
        file.flush().map_err(&io_error)?;
        fs::rename(&unfinished, path).map_err(&io_error)
    })();
    if written.is_err() {
        // What is left of a failed attempt is of no use, and the error that matters is already at hand.
        let _ = fs::remove_file(&unfinished);
    }
    written
}

/// The name of a file until it is whole: hidden, in the same folder, one for each process.
fn unfinished_name(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_file_of_before_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let write = |text: &'static str, then: io::Result<()>| {
            let write = |file: &mut BufWriter<File>| file.write_all(text.as_bytes()).and(then);
            write_atomically(&path, write, |error| error)
        };
        write("first", Ok(())).unwrap();
        write("half of the sec", Err(io::ErrorKind::StorageFull.into())).unwrap_err();
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        write("second", Ok(())).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "second");
    }
}
