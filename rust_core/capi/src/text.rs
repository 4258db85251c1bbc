//! Texts in buffers of C.

use std::ffi::c_char;

use crate::fault::Fault;
use crate::pointers;

/// Writes the part of a text that fits `length` bytes with a NUL, cut at the end of a character; a NUL inside becomes a
/// space. Returns the whole text's length. `buffer` may be NULL if `length` is 0.
///
/// # Safety
/// `buffer` has room for `length` bytes, which nothing else uses meanwhile.
pub(crate) unsafe fn write_text(text: &str, buffer: *mut c_char, length: usize) -> Result<usize, Fault> {
    // The claimed length may be larger than the buffer.
    let used = length.min(text.len() + 1);
    // SAFETY: a part of what the caller promises.
    let buffer = unsafe { pointers::slice_mut(buffer.cast::<u8>(), used, "buffer") }?;
    if let Some(room) = buffer.len().checked_sub(1) {
        let end = (0..=room).rev().find(|end| text.is_char_boundary(*end)).unwrap_or_default();
        for (to, byte) in buffer.iter_mut().zip(text.bytes().take(end).chain([0])) {
            *to = byte;
        }
        buffer.iter_mut().take(end).filter(|byte| **byte == 0).for_each(|byte| *byte = b' ');
    }
    Ok(text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str, length: usize) -> (usize, Vec<u8>) {
        let mut buffer = vec![b'#'; 12];
        // SAFETY: there is room for more than that.
        let needed = unsafe { write_text(text, buffer.as_mut_ptr().cast(), length) }.unwrap();
        (needed, buffer)
    }

    #[test]
    fn a_text_is_cut_where_a_character_ends() {
        assert_eq!(written("fx ≠ fy", 12), (9, "fx ≠ fy\0##".into()));
        assert_eq!(written("fx ≠ fy", 7), (9, "fx ≠\0#####".into()));
        for length in [4, 5, 6] {
            assert_eq!(written("fx ≠ fy", length), (9, "fx \0########".into()), "{length}");
        }
        assert_eq!(written("fx ≠ fy", 1), (9, "\0###########".into()));
        assert_eq!(written("fx ≠ fy", 0), (9, "############".into()));
        assert_eq!(written("a\0b", 12), (3, "a b\0########".into()));
    }

    #[test]
    fn lengths_and_pointers_may_be_nothing() {
        // SAFETY: nothing is written.
        unsafe {
            assert_eq!(write_text("abc", std::ptr::null_mut(), 0), Ok(3));
            assert!(write_text("abc", std::ptr::null_mut(), 5).is_err());
        }
        let mut buffer = [b'#'; 4];
        // SAFETY: only four bytes are written, though the length claims more.
        unsafe { assert_eq!(write_text("abc", buffer.as_mut_ptr().cast(), usize::MAX), Ok(3)) };
        assert_eq!(&buffer, b"abc\0");
    }
}
