//! The boundary to C: panics become errors, and errors are stored for [`rcs_last_error`].

use std::any::Any;
use std::cell::RefCell;
use std::ffi::c_char;
use std::panic::{catch_unwind, AssertUnwindSafe};

use crate::fault::{Fault, RcsResult};
use crate::pointers::required;
use crate::text::write_text;

thread_local! {
    static LAST_ERROR: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Writes the error of the last failed call on this thread: one line in UTF-8. `buffer` gets at most `length` bytes,
/// including the NUL, cut at the end of a character; it may be NULL if `length` is 0. Returns the length of the whole
/// text without its NUL, as `snprintf` does: 0 if no call has failed yet. Successful calls keep the text.
///
/// # Safety
/// `buffer` has room for `length` bytes.
#[no_mangle]
pub unsafe extern "C" fn rcs_last_error(buffer: *mut c_char, length: usize) -> usize {
    let text = LAST_ERROR.try_with(|text| text.try_borrow().map(|text| text.clone()).unwrap_or_default());
    // SAFETY: as the caller promises.
    value(0, || unsafe { write_text(&text.unwrap_or_default(), buffer, length) })
}

/// Runs a call that returns a result code.
pub(crate) fn result(call: impl FnOnce() -> Result<(), Fault>) -> RcsResult {
    match caught(call) {
        Ok(()) => RcsResult::Ok,
        Err(fault) => {
            let result = fault.result;
            keep(fault.text);
            result
        }
    }
}

/// Runs a call that returns a value, `otherwise` on failure.
pub(crate) fn value<T>(otherwise: T, call: impl FnOnce() -> Result<T, Fault>) -> T {
    match caught(call) {
        Ok(value) => value,
        Err(fault) => {
            keep(fault.text);
            otherwise
        }
    }
}

/// Runs a call with a camera, which returns `otherwise` for NULL.
pub(crate) fn with<C, T>(camera: Option<&mut C>, otherwise: T, call: impl FnOnce(&mut C) -> T) -> T {
    value(otherwise, || Ok(call(required(camera, "camera")?)))
}

/// Converts a panic to a fault. Partial changes of the call remain, which is memory-safe: no handle has unsafe parts.
fn caught<T>(call: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|payload| {
        let text = message(&*payload).to_owned();
        // The payload's destructor may panic, too.
        std::mem::forget(payload);
        Err(Fault::new(RcsResult::Panic, format_args!("a bug of rviz_camera_stream, please report it: {text}")))
    })
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

fn keep(text: String) {
    // Fails only in an ending thread, which makes no more calls.
    let kept = LAST_ERROR.try_with(|last| last.try_borrow_mut().map(|mut last| *last = text).is_ok());
    debug_assert_ne!(kept, Ok(false), "nothing borrows it while a call runs");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last_error() -> String {
        let mut buffer = [1_u8; 200];
        // SAFETY: the buffer has that length.
        let length = unsafe { rcs_last_error(buffer.as_mut_ptr().cast(), buffer.len()) };
        assert_eq!(buffer[length], 0);
        String::from_utf8(buffer[..length].to_vec()).unwrap()
    }

    #[test]
    fn a_panic_is_a_result_with_its_message() {
        struct Bomb;
        impl Drop for Bomb {
            fn drop(&mut self) {
                panic!("again");
            }
        }
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        assert_eq!(result(|| panic!("wrong by {}", 1)), RcsResult::Panic);
        let formatted = last_error();
        assert_eq!(value(7, || panic!("wrong")), 7);
        let plain = last_error();
        assert_eq!(result(|| std::panic::panic_any(Bomb)), RcsResult::Panic);
        let other = last_error();
        std::panic::set_hook(hook);
        assert!(formatted.ends_with("please report it: wrong by 1"), "{formatted}");
        assert!(plain.ends_with(": wrong") && other.ends_with(": no message"), "{plain} {other}");
    }

    #[test]
    fn each_thread_has_its_own_last_error_and_success_keeps_it() {
        assert_eq!(result(|| Err(Fault::null("a"))), RcsResult::NullPointer);
        assert_eq!(std::thread::spawn(last_error).join().unwrap(), "");
        assert_eq!(result(|| Ok(())), RcsResult::Ok);
        assert_eq!(last_error(), "a is NULL");
    }
}
