//! Pipe from a window's process to the child that is its dead-man's switch.

use std::io;
use std::process::ChildStdin;

use rustix::fs::{fcntl_setfl, OFlags};
use rustix::io::{write, Errno};

/// Byte of a process that closes its window in order.
pub(crate) const END: u8 = b'q';

/// The pipe to the child. Never waits: a byte that does not fit is dropped.
#[derive(Debug)]
pub(crate) struct SwitchPipe(ChildStdin);

impl SwitchPipe {
    pub(crate) fn new(pipe: ChildStdin) -> io::Result<Self> {
        fcntl_setfl(&pipe, OFlags::NONBLOCK)?;
        Ok(Self(pipe))
    }

    /// Returns `false` if the child is gone.
    pub(crate) fn send(&self, byte: u8) -> bool {
        write(&self.0, &[byte]) != Err(Errno::PIPE)
    }

    /// Tells the child that the window closes in order.
    pub(crate) fn end(&self) {
        self.send(END);
    }
}
