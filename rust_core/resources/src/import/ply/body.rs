//! The rows after a PLY file's header.

use super::header::PlyEncoding;
use crate::{
    import::{lenient_float::leading_f32, scalar::ScalarType},
    MeshFault,
};

/// The rows that are not read yet.
pub(super) enum Body<'a> {
    /// A row is a line of words.
    Text {
        /// The rest of the current row.
        line: &'a [u8],
        /// The line number, from 1.
        number: usize,
        /// The lines after it.
        rest: &'a [u8],
    },
    /// Rows follow each other without gaps.
    Binary {
        /// The bytes that are not read yet.
        rest: &'a [u8],
        is_big_endian: bool,
    },
}

impl<'a> Body<'a> {
    /// The rows of a file from its line `first_line` on.
    pub(super) fn new(encoding: PlyEncoding, rest: &'a [u8], first_line: usize) -> Self {
        match encoding {
            PlyEncoding::Text => Self::Text { line: &[], number: first_line - 1, rest },
            PlyEncoding::LittleEndian => Self::Binary { rest, is_big_endian: false },
            PlyEncoding::BigEndian => Self::Binary { rest, is_big_endian: true },
        }
    }

    /// Skips the rest of the current line, and goes on to the next line that is not empty.
    pub(super) fn begin_row(&mut self) -> Result<(), MeshFault> {
        let Self::Text { line, number, rest } = self else { return Ok(()) };
        loop {
            if rest.is_empty() {
                return Err(MeshFault::Malformed("the file ends too early".to_owned()));
            }
            let end = rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |end| end + 1);
            (*line, *rest) = rest.split_at(end);
            *number += 1;
            *line = line.trim_ascii();
            if !line.is_empty() {
                return Ok(());
            }
        }
    }

    /// The next value of the row.
    pub(super) fn value(&mut self, kind: ScalarType) -> Result<f64, MeshFault> {
        match self {
            Self::Text { line, number, .. } => {
                let bad = |what: String| MeshFault::Line { line: *number, what };
                let text = line.trim_ascii_start();
                let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
                let (word, after) = text.split_at(end);
                *line = after;
                if word.is_empty() {
                    return Err(bad("it ends too early".to_owned()));
                }
                let word = String::from_utf8_lossy(word);
                let value = word.parse().ok().or_else(|| leading_f32(&word).map(f64::from));
                value.ok_or_else(|| bad(format!("{word:?} is not a number")))
            }
            Self::Binary { rest, is_big_endian } => {
                let value = binary_value(kind, rest, *is_big_endian);
                value.ok_or_else(|| MeshFault::Malformed("the file ends too early".to_owned()))
            }
        }
    }
}

/// Takes a value from the beginning of `rest`.
fn binary_value(kind: ScalarType, rest: &mut &[u8], is_big_endian: bool) -> Option<f64> {
    let (bytes, after) = rest.split_at_checked(kind.size_bytes())?;
    *rest = after;
    if !is_big_endian {
        return kind.value(bytes);
    }
    let mut reversed = [0; 8];
    let reversed = reversed.get_mut(..bytes.len())?;
    reversed.copy_from_slice(bytes);
    reversed.reverse();
    kind.value(reversed)
}
