//! Files that a user names, by an option, a parameter or in another file: regular files within a limit of bytes.
//!
//! They are opened without blocking, and their kind is that of the opened descriptor. A FIFO without a writer would
//! hold the program up beyond a signal, and a device would fill the memory.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Error, ErrorKind, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::OFlags;

/// Folders of the descriptors that a shell opened for the program, as for `<(…)`.
const DESCRIPTORS: [&str; 2] = ["/dev/fd", "/proc/self/fd"];

/// Opens a regular file of any size, with its length in bytes.
///
/// # Errors
/// The system's, and a file that is not regular.
pub fn open(path: &Path) -> io::Result<(File, u64)> {
    // Before it is opened as well: opening a device may do something.
    check_kind(&path.metadata()?)?;
    let flags = (OFlags::NONBLOCK | OFlags::NOCTTY).bits().cast_signed();
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
    let metadata = file.metadata()?;
    check_kind(&metadata)?;
    Ok((file, metadata.len()))
}

/// Opens a regular file of at most `max_bytes` bytes.
///
/// # Errors
/// As [`open`], and [`ErrorKind::FileTooLarge`].
pub fn open_limited(path: &Path, max_bytes: u64) -> io::Result<File> {
    let (file, len) = open(path)?;
    if len > max_bytes {
        return Err(too_large(max_bytes));
    }
    Ok(file)
}

/// Reads a regular file of at most `max_bytes` bytes.
///
/// # Errors
/// As [`open_limited`].
pub fn read(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let (file, len) = open(path)?;
    read_up_to(file, len, max_bytes)?.ok_or_else(|| too_large(max_bytes))
}

/// Reads a file as [`read`] does, or a pipe that the shell opened: `<(…)`. It can be read once.
///
/// # Errors
/// As [`read`].
pub fn read_once(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    if DESCRIPTORS.iter().any(|folder| path.starts_with(folder)) {
        return read_up_to(File::open(path)?, 0, max_bytes)?.ok_or_else(|| too_large(max_bytes));
    }
    read(path, max_bytes)
}

/// Reads a text file of at most `max_bytes` bytes, in any encoding that [`rcs_text::decode`] knows.
///
/// # Errors
/// As [`read`].
pub fn read_text(path: &Path, max_bytes: u64) -> io::Result<String> {
    Ok(rcs_text::decode(&read(path, max_bytes)?).into_owned())
}

/// The contents of an open file of about `len` bytes; `None` for more than `max_bytes`.
///
/// # Errors
/// The system's.
pub fn read_up_to(file: File, len: u64, max_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    if len > max_bytes {
        return Ok(None);
    }
    let mut bytes = Vec::with_capacity(usize::try_from(len).unwrap_or(0));
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= max_bytes).then_some(bytes))
}

/// The kind of a file that is not regular.
pub fn other_kind(metadata: &Metadata) -> Option<&'static str> {
    match metadata.file_type() {
        kind if kind.is_file() => None,
        kind if kind.is_dir() => Some("a folder"),
        kind if kind.is_fifo() => Some("a FIFO"),
        kind if kind.is_socket() => Some("a socket"),
        _ => Some("a device"),
    }
}

fn check_kind(metadata: &Metadata) -> io::Result<()> {
    match other_kind(metadata) {
        Some(kind) => Err(Error::other(format!("it is {kind}, only regular files are read"))),
        None => Ok(()),
    }
}

fn too_large(max_bytes: u64) -> Error {
    let limit = if max_bytes < 1 << 30 { format!("{} MB", max_bytes >> 20) } else { format!("{} GB", max_bytes >> 30) };
    Error::new(ErrorKind::FileTooLarge, format!("larger than {limit}"))
}

#[cfg(test)]
mod tests {
    use std::io::{Seek, Write};
    use std::process::Command;

    use super::*;

    #[test]
    fn a_file_that_grows_while_it_is_read_is_not_read_past_the_limit() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[7; 1000]).unwrap();
        let open = || {
            let mut file = file.try_clone().unwrap();
            file.rewind().unwrap();
            file
        };
        // It had 10 bytes when it was opened.
        assert_eq!(read_up_to(open(), 10, 1000).unwrap().unwrap().len(), 1000);
        assert_eq!(read_up_to(open(), 10, 999).unwrap(), None);
    }

    #[test]
    fn only_regular_files_within_the_limit_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "text").unwrap();
        std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
        assert_eq!(read(&at("link"), 4).unwrap(), b"text");
        // Files with a hole: read, they would fill the memory.
        File::create(at("sparse")).unwrap().set_len(40 << 30).unwrap();
        assert!(Command::new("mkfifo").arg(at("fifo")).status().unwrap().success());
        for (path, refusal) in [
            (at("sparse"), "larger than 8 MB"),
            (at("fifo"), "it is a FIFO, only regular files are read"),
            (folder.path().to_owned(), "it is a folder, only regular files are read"),
            ("/dev/zero".into(), "it is a device, only regular files are read"),
        ] {
            for error in [
                read(&path, 8 << 20).unwrap_err(),
                read_once(&path, 8 << 20).unwrap_err(),
                open_limited(&path, 8 << 20).unwrap_err(),
            ] {
                assert_eq!(error.to_string(), refusal);
            }
            assert_eq!(open(&path).is_ok(), path == at("sparse"));
        }
        assert_eq!(open_limited(&at("sparse"), 4 << 30).unwrap_err().to_string(), "larger than 4 GB");
    }

    #[test]
    fn a_pipe_of_the_shell_is_read_once_and_within_the_limit() {
        let read = |max_bytes| {
            let (reader, mut writer) = std::io::pipe().unwrap();
            writer.write_all(b"text").unwrap();
            drop(writer);
            let path = format!("/dev/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&reader));
            assert!(super::read(path.as_ref(), 4).unwrap_err().to_string().starts_with("it is a FIFO"));
            read_once(path.as_ref(), max_bytes)
        };
        assert_eq!(read(4).unwrap(), b"text");
        assert_eq!(read(3).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }

    #[test]
    fn a_text_may_have_any_encoding() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "text").unwrap();
        assert_eq!(read_text(&path, 4).unwrap(), "text");
        std::fs::write(&path, b"\xff\xfe\xe9\0").unwrap();
        assert_eq!(read_text(&path, 4).unwrap(), "é");
    }
}
