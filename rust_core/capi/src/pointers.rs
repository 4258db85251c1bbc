//! Checks pointers from C and converts them to slices and texts.

use std::borrow::Cow;
use std::ffi::{c_char, CStr};
use std::ops::Range;

use crate::fault::{Fault, RcsResult};

/// A reference from C, where NULL is `None`.
pub(crate) fn required<T>(pointer: Option<T>, name: &str) -> Result<T, Fault> {
    pointer.ok_or_else(|| Fault::null(name))
}

/// Checks a pointer to `count` values, which fit the address space, and returns their size in bytes.
fn check<T>(pointer: *const T, count: usize, name: &str) -> Result<usize, Fault> {
    if pointer.is_null() {
        return Err(Fault::null(name));
    }
    if !pointer.is_aligned() {
        return Err(Fault::new(RcsResult::BadValue, format_args!("{name} is not aligned for what it points to")));
    }
    bytes_of(pointer, count, name)
}

/// Size in bytes of `count` values at an address, if they fit the address space.
fn bytes_of<T>(pointer: *const T, count: usize, name: &str) -> Result<usize, Fault> {
    let bytes = count.checked_mul(size_of::<T>()).filter(|bytes| isize::try_from(*bytes).is_ok());
    let bytes = bytes.filter(|bytes| pointer.addr().checked_add(*bytes).is_some());
    bytes.ok_or_else(|| Fault::new(RcsResult::BadLength, format_args!("{name}: {count} values do not fit memory")))
}

/// `count` values from a pointer on. Any pointer is valid for 0 values, also NULL.
///
/// # Safety
/// There are `count` values, and nothing changes them for `'a`.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, count, name)?;
    // SAFETY: not NULL, aligned, at most isize::MAX bytes, and valid as the caller promises.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// `count` values from a pointer on, to be changed. Any pointer is valid for 0 values, also NULL.
///
/// # Safety
/// There are `count` values, and nothing else uses them for `'a`.
pub(crate) unsafe fn slice_mut<'a, T>(pointer: *mut T, count: usize, name: &str) -> Result<&'a mut [T], Fault> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(pointer, count, name)?;
    // SAFETY: not NULL, aligned, at most isize::MAX bytes, and not used otherwise as the caller promises.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// Checks that a written buffer does not overlap a read one.
pub(crate) fn apart<T, U>(read: (*const T, usize), written: (*mut U, usize)) -> Result<(), Fault> {
    let read = addresses(read.0, read.1, "the source")?;
    let written = addresses(written.0, written.1, "the destination")?;
    if read.start < written.end && written.start < read.end {
        return Err(Fault::new(RcsResult::BadValue, "the destination overlaps the source"));
    }
    Ok(())
}

fn addresses<T>(pointer: *const T, count: usize, name: &str) -> Result<Range<usize>, Fault> {
    let bytes = bytes_of(pointer, count, name)?;
    Ok(pointer.addr()..pointer.addr() + bytes)
}

/// A text that ends with a NUL; invalid UTF-8 becomes U+FFFD.
///
/// # Safety
/// A pointer that is not NULL points to such a text, which nothing changes for `'a`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<Cow<'a, str>, Fault> {
    check(pointer, 1, name)?;
    // SAFETY: not NULL, and ends with a NUL as the caller promises.
    Ok(unsafe { CStr::from_ptr(pointer) }.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_unaligned_and_too_long_are_refused_unread() {
        let values = [1.0, 2.0_f64];
        let unaligned = values.as_ptr().wrapping_byte_add(1);
        let result = |fault: Fault| fault.result;
        // SAFETY: each is refused before it is read.
        unsafe {
            assert_eq!(slice::<f64>(std::ptr::null(), 1, "x").map_err(result), Err(RcsResult::NullPointer));
            assert_eq!(slice(unaligned, 1, "x").map_err(result), Err(RcsResult::BadValue));
            for count in [usize::MAX, usize::MAX / 8 + 2, isize::MAX as usize / 8 + 1] {
                assert_eq!(slice(values.as_ptr(), count, "x").map_err(result), Err(RcsResult::BadLength), "{count}");
            }
        }
        // SAFETY: nothing is read, or what is there.
        unsafe {
            assert_eq!(slice::<f64>(std::ptr::null(), 0, "x"), Ok(&[][..]));
            assert_eq!(slice(values.as_ptr(), 2, "x"), Ok(&values[..]));
        }
    }

    #[test]
    fn overlapping_buffers_are_found() {
        let mut bytes = [0_u8; 20];
        let first = bytes.as_mut_ptr();
        let at = |offset: usize| first.wrapping_add(offset);
        assert!(apart((at(0), 10), (at(10), 10)).is_ok() && apart((at(10), 10), (at(0), 10)).is_ok());
        for (read, written) in [((0, 11), (10, 10)), ((5, 2), (0, 20)), ((0, 20), (5, 2)), ((3, 3), (3, 3))] {
            let fault = apart((at(read.0), read.1), (at(written.0), written.1)).unwrap_err();
            assert_eq!(fault.result, RcsResult::BadValue);
        }
    }

    #[test]
    fn texts_are_read_whatever_their_bytes_are() {
        // SAFETY: the texts end with a NUL.
        unsafe {
            assert_eq!(text(c"plumb_bob".as_ptr(), "x").unwrap(), "plumb_bob");
            assert_eq!(text(c"a\xffb".as_ptr(), "x").unwrap(), "a\u{fffd}b");
            assert_eq!(text(std::ptr::null(), "x").unwrap_err().text, "x is NULL");
        }
    }
}
