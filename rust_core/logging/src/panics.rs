//! Logs panics: on `/rosout` and in the file as well, each cause once a second at most.

use std::any::Any;
use std::backtrace::Backtrace;
use std::cell::Cell;

thread_local! {
    /// `true` while this thread may hold a lock of the console.
    static IS_LOGGING: Cell<bool> = const { Cell::new(false) };
}

/// Runs code that locks the console. A panic in it is printed, because logging it would deadlock.
pub(crate) fn while_logging<T>(run: impl FnOnce() -> T) -> T {
    let before = IS_LOGGING.replace(true);
    let result = run();
    IS_LOGGING.set(before);
    result
}

/// Logs panics as errors from now on; with `RUST_BACKTRACE`, a backtrace follows on standard error.
pub(crate) fn log_all() {
    let report = std::panic::take_hook();
    let is_traced = std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0");
    std::panic::set_hook(Box::new(move |info| {
        if IS_LOGGING.get() {
            report(info);
        } else {
            let thread = std::thread::current();
            let place = info.location().map(ToString::to_string).unwrap_or_default();
            log::error!("thread {} panicked at {place}: {}", thread.name().unwrap_or("?"), text(info.payload()));
            if is_traced {
                crate::print_error(&format!("stack backtrace:\n{}", Backtrace::force_capture()));
            }
        }
    }));
}

/// Message of a panic.
fn text(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
