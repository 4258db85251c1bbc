//! The thread that returns unused memory to the system.

use std::io;
use std::sync::mpsc::{sync_channel, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::Instant;

use crate::allocator;
use crate::policy::{TrimPolicy, PERIOD};

/// Returns unused memory to the system until it is dropped, on a thread named `memory`.
#[derive(Debug)]
pub struct MemoryTrimmer {
    /// Nothing is sent; the thread ends when this is gone.
    _end: SyncSender<()>,
}

impl MemoryTrimmer {
    /// Starts the thread, best before anything large was freed. Each check calls `free_pools` first, for the program's
    /// own buffers.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(mut free_pools: impl FnMut() + Send + 'static) -> io::Result<Self> {
        let (end, is_ended) = sync_channel(0);
        allocator::fix_thresholds();
        let trimming = move || {
            let at_start = allocator::anonymous_bytes().unwrap_or_default();
            let mut policy = TrimPolicy::new(at_start.saturating_sub(allocator::bytes_in_use()));
            while is_ended.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                free_pools();
                check(&mut policy);
            }
        };
        thread::Builder::new().name("memory".to_owned()).spawn(trimming)?;
        Ok(Self { _end: end })
    }
}

fn check(policy: &mut TrimPolicy) {
    let Some(before) = allocator::anonymous_bytes() else { return };
    if !policy.is_due(before, allocator::bytes_in_use) {
        return;
    }
    let begun = Instant::now();
    allocator::trim();
    let took_ms = begun.elapsed().as_secs_f64() * 1e3;
    let Some(after) = allocator::anonymous_bytes() else { return };
    policy.trimmed(after.saturating_sub(allocator::bytes_in_use()));
    let [before_mb, after_mb] = [before, after].map(|bytes| bytes >> 20);
    log::debug!("returned unused memory to the system: {before_mb} MB -> {after_mb} MB (took {took_ms:.1} ms)");
}
