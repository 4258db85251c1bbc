//! The thread that looks for unused memory.

use std::io;
use std::sync::mpsc::{sync_channel, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::Instant;

use crate::allocator;
use crate::policy::{Policy, PERIOD};

/// Gives unused memory back until it is dropped, on a thread named `memory`.
#[derive(Debug)]
pub struct Keeper {
    /// Nothing is sent; the thread ends when this is gone.
    _end: SyncSender<()>,
}

impl Keeper {
    /// Starts the thread, best before anything large was freed. Before each look it calls `free_pools`, for what the
    /// program itself keeps for later.
    ///
    /// # Errors
    /// The system's, where there is no thread left.
    pub fn start(mut free_pools: impl FnMut() + Send + 'static) -> io::Result<Self> {
        let (end, is_ended) = sync_channel(0);
        allocator::fix_sizes();
        let keeping = move || {
            let at_start = allocator::anonymous_bytes().unwrap_or_default();
            let mut policy = Policy::new(at_start.saturating_sub(allocator::bytes_in_use()));
            while is_ended.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                free_pools();
                look(&mut policy);
            }
        };
        thread::Builder::new().name("memory".to_owned()).spawn(keeping)?;
        Ok(Self { _end: end })
    }
}

fn look(policy: &mut Policy) {
    let Some(before) = allocator::anonymous_bytes() else { return };
    if !policy.look(before, allocator::bytes_in_use) {
        return;
    }
    let begun = Instant::now();
    allocator::give_back();
    let took_ms = begun.elapsed().as_secs_f64() * 1e3;
    let Some(after) = allocator::anonymous_bytes() else { return };
    policy.given_back(after.saturating_sub(allocator::bytes_in_use()));
    let [before_mb, after_mb] = [before, after].map(|bytes| bytes >> 20);
    log::debug!("Gave unused memory back to the system: {before_mb} MB -> {after_mb} MB (took {took_ms:.1} ms)");
}
