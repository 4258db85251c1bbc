//! A file that is read in pieces within its length.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;

use crate::error::BagError;

/// Longest piece read at once: more than any chunk has.
const MAX_PIECE_LEN: u64 = 2 << 30;

/// A file whose announced lengths are checked against its own before memory is allocated.
#[derive(Debug)]
pub(crate) struct BoundedFile {
    pub(crate) path: PathBuf,
    pub(crate) len: u64,
    file: File,
}

impl BoundedFile {
    pub(crate) fn open(path: PathBuf) -> Result<Self, BagError> {
        match rcs_user_files::open(&path) {
            Ok((file, len)) => Ok(Self { path, len, file }),
            Err(error) => Err(BagError::new(&path, error)),
        }
    }

    /// Reads `len` bytes at an offset.
    pub(crate) fn read(&self, at: u64, len: u64) -> io::Result<Vec<u8>> {
        let past_end = || io::Error::new(io::ErrorKind::UnexpectedEof, "reaches past the end of the file");
        at.checked_add(len).filter(|end| *end <= self.len).ok_or_else(past_end)?;
        let too_long = || io::Error::new(io::ErrorKind::InvalidData, "record too long");
        let piece_len = usize::try_from(len).ok().filter(|_| len <= MAX_PIECE_LEN).ok_or_else(too_long)?;
        let mut bytes = vec![0; piece_len];
        self.file.read_exact_at(&mut bytes, at)?;
        Ok(bytes)
    }

    pub(crate) fn damaged(&self, at: u64, reason: &dyn std::fmt::Display) -> BagError {
        BagError::new(&self.path, format_args!("damaged at byte {at}: {reason}"))
    }
}
