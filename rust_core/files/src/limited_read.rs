//! Reading files of a limited size, so that one named by mistake, such as a device, does not fill memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads a file or a pipe of at most `most_bytes` bytes.
///
/// # Errors
/// The system's; [`io::ErrorKind::FileTooLarge`] with the limit.
pub fn read_limited(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let too_large = || {
        let limit =
            if most_bytes < 1 << 30 { format!("{} MB", most_bytes >> 20) } else { format!("{} GB", most_bytes >> 30) };
        io::Error::new(io::ErrorKind::FileTooLarge, format!("larger than {limit}"))
    };
    let file = File::open(path)?;
    let len = file.metadata()?.len();
    if len > most_bytes {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(usize::try_from(len).unwrap_or_default());
    file.take(most_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        return Err(too_large());
    }
    Ok(bytes)
}

/// Reads a text file of at most `most_bytes` bytes.
///
/// # Errors
/// As [`read_limited`], and [`io::ErrorKind::InvalidData`] if it is not UTF-8.
pub fn read_limited_text(path: &Path, most_bytes: u64) -> io::Result<String> {
    let not_text = |_| io::Error::new(io::ErrorKind::InvalidData, "not UTF-8 text");
    String::from_utf8(read_limited(path, most_bytes)?).map_err(not_text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_beyond_the_limit_is_refused_before_it_is_read_and_an_endless_one_soon() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "text").unwrap();
        assert_eq!(read_limited_text(&path, 4).unwrap(), "text");
        // A file with a hole: read, it would fill the memory.
        File::create(&path).unwrap().set_len(40 << 30).unwrap();
        for (path, limit, said) in
            [(path.as_path(), 4 << 30, "larger than 4 GB"), (Path::new("/dev/zero"), 1 << 20, "larger than 1 MB")]
        {
            let error = read_limited(path, limit).unwrap_err();
            assert_eq!((error.kind(), error.to_string().as_str()), (io::ErrorKind::FileTooLarge, said));
        }
        std::fs::write(&path, b"\xff").unwrap();
        assert_eq!(read_limited_text(&path, 4).unwrap_err().to_string(), "not UTF-8 text");
    }
}
