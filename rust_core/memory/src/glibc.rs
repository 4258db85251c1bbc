//! glibc's allocator: bytes in use, and returning free memory to the system.
//!
//! It has an arena for the first thread and others for further ones (mallopt(3), malloc_trim(3)). A free chunk at an
//! arena's end goes back by itself once it is large enough; free chunks before that only by `malloc_trim`.

use std::fs::File;
use std::io::Read;

/// A free chunk of this size at an arena's end goes back at once. [`trim`] leaves smaller ones of threads' arenas.
const TRIM_THRESHOLD_BYTES: libc::c_int = 4 << 20;
/// Allocations of this size and more are mappings of their own, which go back when they are freed.
const MMAP_THRESHOLD_BYTES: libc::c_int = 4 << 20;

/// Fixes the two thresholds. By itself glibc raises them to what was freed at some time, up to 32 and 64 MB.
pub(crate) fn fix_thresholds() {
    for (parameter, bytes) in
        [(libc::M_TRIM_THRESHOLD, TRIM_THRESHOLD_BYTES), (libc::M_MMAP_THRESHOLD, MMAP_THRESHOLD_BYTES)]
    {
        // SAFETY: it takes no pointer, and both parameters may be set at any time; a value that it does not take is
        // ignored.
        let _is_set = unsafe { libc::mallopt(parameter, bytes) };
    }
}

/// Returns all whole free pages to the system. Each arena is locked for some milliseconds where a hundred megabytes are
/// free.
pub(crate) fn trim() {
    // SAFETY: the function takes no pointer, may be called from any thread, and gives back only what is not allocated.
    // That all of the program's allocations are the C library's or keep to its rules holds for any program.
    let _is_any = unsafe { libc::malloc_trim(0) };
}

/// Allocated bytes. Each arena is locked while its free chunks are counted: some milliseconds for 100,000.
pub(crate) fn bytes_in_use() -> u64 {
    // SAFETY: the function takes no pointer and may be called from any thread; it locks each arena while it counts.
    // `mallinfo2`, whose numbers have 64 bits, came with glibc 2.33 only.
    let counts = unsafe { libc::mallinfo() };
    in_use(&counts)
}

/// Bytes in arenas and in mappings. The counters wrap at 4 GB each, with which more seems unused than is; the policy
/// copes with finding nothing to return.
fn in_use(counts: &libc::mallinfo) -> u64 {
    u64::from(counts.uordblks.cast_unsigned()) + u64::from(counts.hblkhd.cast_unsigned())
}

/// Resident bytes that belong to no file: allocated, free and not the allocator's, such as stacks. `None` if unknown.
pub(crate) fn anonymous_bytes() -> Option<u64> {
    let mut text = [0; 256];
    let len = File::open("/proc/self/statm").and_then(|mut file| file.read(&mut text)).ok()?;
    let pages = anonymous_pages(text.get(..len)?)?;
    // SAFETY: it takes no pointer, and any number is allowed.
    let page_bytes = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    Some(pages * u64::try_from(page_bytes).ok()?)
}

/// Anonymous pages by `/proc/self/statm` (proc_pid_statm(5)): `size resident shared …`.
fn anonymous_pages(statm: &[u8]) -> Option<u64> {
    let mut numbers = statm.split(|byte| *byte == b' ').map(|digits| std::str::from_utf8(digits).ok()?.parse().ok());
    let (_size, resident, shared): (u64, u64, u64) = (numbers.next()??, numbers.next()??, numbers.next()??);
    Some(resident.saturating_sub(shared))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unused_bytes() -> u64 {
        anonymous_bytes().unwrap().saturating_sub(bytes_in_use())
    }

    #[test]
    fn what_is_resident_and_no_files_is_anonymous() {
        assert_eq!(anonymous_pages(b"4000 700 300 50 0 900 0\n"), Some(400));
        assert_eq!(anonymous_pages(b"4000 300 700 50 0 900 0\n"), Some(0));
        for bad in ["", "4000", "4000 700", "4000 x 300 1", "a b c d"] {
            assert_eq!(anonymous_pages(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn three_gigabytes_are_not_negative() {
        // SAFETY: it consists of integers, for which zeros are values.
        let mut counts: libc::mallinfo = unsafe { std::mem::zeroed() };
        counts.uordblks = 3_000_000_000_u32.cast_signed();
        counts.hblkhd = 1_000_000_000;
        assert_eq!(in_use(&counts), 4_000_000_000);
    }

    /// Freed chunks below one in use, which glibc does not return by itself.
    #[test]
    fn what_was_freed_is_found_and_given_back() {
        const CHUNK: usize = 1000;
        const COUNT: usize = 100_000;
        let before = unused_bytes();
        let mut pieces: Vec<Box<[u8; CHUNK]>> = (0..COUNT).map(|_| Box::new([1; CHUNK])).collect();
        let with = unused_bytes();
        // Other tests of this process allocate little.
        assert!(with < before + (10 << 20), "{before} {with}: what is used is not unused");
        let last = pieces.pop();
        drop(pieces);
        let freed = unused_bytes();
        assert!(freed > with + (80 << 20), "{with} {freed}");
        trim();
        let after = unused_bytes();
        println!("unused: {before} bytes, {with} with all, {freed} freed, {after} given back");
        assert!(after < before + (10 << 20), "{freed} {after}");
        assert!(last.is_some());
    }
}
