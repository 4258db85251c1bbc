//! Pointers from C as references, after all of them that can be checked was checked.

use std::borrow::Cow;
use std::ffi::{c_char, CStr};
use std::ops::Range;

use crate::fault::{Fault, RcsResult};

fn check<T>(pointer: *const T, name: &str) -> Result<(), Fault> {
    if pointer.is_null() {
        return Err(Fault::null(name));
    }
    if !pointer.is_aligned() {
        return Err(Fault::new(RcsResult::BadValue, format_args!("{name} is not aligned for what it points to")));
    }
    Ok(())
}

/// What a pointer points to.
///
/// # Safety
/// One that is not NULL points to a `T` that nothing changes for `'a`.
pub(crate) unsafe fn shared<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Fault> {
    check(pointer, name)?;
    // SAFETY: not NULL, aligned, and valid as the caller promises.
    Ok(unsafe { &*pointer })
}

/// What a pointer points to, to be changed.
///
/// # Safety
/// One that is not NULL points to a `T` that nothing else uses for `'a`.
pub(crate) unsafe fn exclusive<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Fault> {
    check(pointer, name)?;
    // SAFETY: not NULL, aligned, and not used otherwise as the caller promises.
    Ok(unsafe { &mut *pointer })
}

/// Whether a value can be written through a pointer.
pub(crate) fn writable<T>(pointer: *mut T, name: &str) -> Result<(), Fault> {
    check(pointer, name)
}

/// Writes through a pointer that [`writable`] has checked; NULL is left alone.
///
/// # Safety
/// One that is not NULL points to room for a `T`.
pub(crate) unsafe fn write<T: Copy>(pointer: *mut T, value: T) {
    if !pointer.is_null() {
        // SAFETY: there is room as the caller promises; the write needs no alignment.
        unsafe { pointer.write_unaligned(value) }
    }
}

/// How many bytes so many values have, if there can be as many at an address.
fn bytes_of<T>(pointer: *const T, count: usize, name: &str) -> Result<usize, Fault> {
    let bytes = count.checked_mul(size_of::<T>()).filter(|bytes| isize::try_from(*bytes).is_ok());
    let bytes = bytes.filter(|bytes| pointer.addr().checked_add(*bytes).is_some());
    bytes.ok_or_else(|| {
        Fault::new(RcsResult::BadLength, format_args!("{name}: {count} values are more than a memory holds"))
    })
}

/// `count` values from a pointer on. None of them may be behind any pointer, NULL included.
///
/// # Safety
/// There are as many, and nothing changes them for `'a`.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, name)?;
    bytes_of(pointer, count, name)?;
    // SAFETY: not NULL, aligned, at most isize::MAX bytes, and valid as the caller promises.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// `count` values from a pointer on, to be changed. None of them may be behind any pointer, NULL included.
///
/// # Safety
/// There are as many, and nothing else uses them for `'a`.
pub(crate) unsafe fn slice_mut<'a, T>(pointer: *mut T, count: usize, name: &str) -> Result<&'a mut [T], Fault> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(pointer, name)?;
    bytes_of(pointer, count, name)?;
    // SAFETY: not NULL, aligned, at most isize::MAX bytes, and not used otherwise as the caller promises.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// Checks that a buffer that is written shares no byte with one that is read.
pub(crate) fn apart<T, U>(read: (*const T, usize), written: (*mut U, usize)) -> Result<(), Fault> {
    let read = addresses(read.0, read.1, "the source")?;
    let written = addresses(written.0, written.1, "the destination")?;
    if read.start < written.end && written.start < read.end {
        return Err(Fault::new(RcsResult::BadValue, "the buffer that is written overlaps the one that is read"));
    }
    Ok(())
}

fn addresses<T>(pointer: *const T, count: usize, name: &str) -> Result<Range<usize>, Fault> {
    let bytes = bytes_of(pointer, count, name)?;
    Ok(pointer.addr()..pointer.addr() + bytes)
}

/// A text that ends with a NUL; what is not UTF-8 in it becomes U+FFFD.
///
/// # Safety
/// One that is not NULL points to such a text, which nothing changes for `'a`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<Cow<'a, str>, Fault> {
    check(pointer, name)?;
    // SAFETY: not NULL, and ends with a NUL as the caller promises.
    Ok(unsafe { CStr::from_ptr(pointer) }.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_null_askew_or_too_long_is_never_read() {
        let values = [1.0, 2.0_f64];
        let askew = values.as_ptr().wrapping_byte_add(1);
        let result = |fault: Fault| fault.result;
        // SAFETY: each is refused before it is read.
        unsafe {
            assert_eq!(shared::<f64>(std::ptr::null(), "x").map_err(result), Err(RcsResult::NullPointer));
            assert_eq!(shared(askew, "x").map_err(result), Err(RcsResult::BadValue));
            assert_eq!(slice::<f64>(std::ptr::null(), 1, "x").map_err(result), Err(RcsResult::NullPointer));
            assert_eq!(slice(askew, 1, "x").map_err(result), Err(RcsResult::BadValue));
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
