//! Atomic writing: a file is written under another name and renamed, so that it appears whole or not at all and a
//! failure leaves the previous file. A replacement is on the disk before the rename, in case of a power failure.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes or replaces a file with `write`. Permissions and links are kept, pipes and devices are written to directly.
/// The folder must exist. `io_error` wraps the system's errors.
///
/// # Errors
/// Those of `write`, and the system's.
pub fn write_atomically<E>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
    io_error: impl Fn(io::Error) -> E,
) -> Result<(), E> {
    // A link whose target does not exist yet is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let known = fs::metadata(&target).ok();
    if known.as_ref().is_some_and(|known| !known.is_file()) {
        let mut file = BufWriter::new(File::options().write(true).open(&target).map_err(&io_error)?);
        write(&mut file)?;
        return file.flush().map_err(&io_error);
    }
    let unfinished = unfinished_name(&target);
    let written = (|| {
        let file = File::create(&unfinished).map_err(&io_error)?;
        if let Some(known) = known {
            file.set_permissions(known.permissions()).map_err(&io_error)?;
        }
        let mut file = BufWriter::new(file);
        write(&mut file)?;
        file.flush().map_err(&io_error)?;
        replace(&unfinished, &target).map_err(&io_error)
    })();
    if written.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&unfinished);
    }
    written
}

/// Checks that [`write_atomically`] could write a file now, or that files could be written into a folder.
///
/// # Errors
/// The system's.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let trial = match fs::metadata(&target) {
        Ok(known) if known.is_dir() => unfinished_name(&target.join("trial")),
        // A pipe or a device.
        Ok(known) if !known.is_file() => return Ok(()),
        _ => unfinished_name(&target),
    };
    File::create(&trial)?;
    fs::remove_file(&trial)
}

/// Renames a finished file, which is on the disk before it replaces another.
///
/// # Errors
/// The system's.
pub fn replace(finished: &Path, target: &Path) -> io::Result<()> {
    if fs::symlink_metadata(target).is_ok() {
        File::open(finished)?.sync_all()?;
    }
    fs::rename(finished, target)
}

/// Name of an unfinished file: hidden, in the same folder, unique for the process.
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

    fn write(path: &Path, text: &str) -> io::Result<()> {
        write_atomically(path, |file| file.write_all(text.as_bytes()), |error| error)
    }

    #[test]
    fn a_link_and_permissions_stay() {
        use std::os::unix::fs::{symlink, PermissionsExt};

        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        write(&file, "first").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
        symlink("file", &link).unwrap();
        write(&link, "second").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "second");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    }

    #[test]
    fn a_pipe_is_written_to_and_a_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe).unwrap()
        });
        write(&pipe, "text").unwrap();
        assert_eq!(reader.join().unwrap(), "text");
        assert!(!fs::metadata(&pipe).unwrap().is_file(), "it is a pipe still");
        assert!(write(folder.path(), "text").is_err());
    }
}
