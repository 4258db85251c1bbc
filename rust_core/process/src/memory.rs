//! Returning unused memory to the system.
//!
//! glibc gives threads heaps of their own, and returns little of what is freed there: of a scene of 100,000 markers it
//! keeps 100 MB for as long as the program runs. With one heap that is trimmed every ten seconds, all of it goes back,
//! and what the next cloud needs stays until then: 307,200 points at 10 Hz cost 20 page faults a cloud, with glibc's
//! own thresholds up to 500. Other C libraries are left alone.

use std::time::Duration;
use std::{io, thread};

/// Time between two trims. A megabyte that is needed again costs a quarter of a millisecond.
const PERIOD: Duration = Duration::from_secs(10);

/// Gives all threads one heap, which keeps what is freed until the next trim. To be called before other threads start.
///
/// Large blocks too: where those of 32 MB and more went back at once, 1.2 million points at 5 Hz cost 16 ms of CPU for
/// an image in place of 13, and came 20 ms later.
pub fn keep_one_heap() {
    #[cfg(target_env = "gnu")]
    for (parameter, value) in
        [(libc::M_ARENA_MAX, 1), (libc::M_MMAP_MAX, 0), (libc::M_TRIM_THRESHOLD, libc::c_int::MAX)]
    {
        // SAFETY: the function takes no pointer and ignores what it does not know.
        let _is_set = unsafe { libc::mallopt(parameter, value) };
    }
}

/// Returns all whole free pages to the system every ten seconds, on a thread named `memory`, until the process ends.
///
/// # Errors
/// The thread cannot be started.
pub fn trim_regularly() -> io::Result<()> {
    let trimming = || loop {
        thread::sleep(PERIOD);
        trim();
    };
    thread::Builder::new().name("memory".to_owned()).spawn(trimming).map(drop)
}

fn trim() {
    // SAFETY: the function takes no pointer, may be called from any thread, and returns only what is not allocated.
    #[cfg(target_env = "gnu")]
    let _is_any = unsafe { libc::malloc_trim(0) };
}
