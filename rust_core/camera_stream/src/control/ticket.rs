//! The last check of an image before it leaves: whether a blackout came since it was begun.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::Arc;

/// Counts the blackouts of a camera: even while it may be lit, odd while it is black.
#[derive(Debug, Default)]
pub(super) struct Gate(Arc<AtomicU64>);

/// The ticket of one image, which is void from the next blackout on, also after that has ended: the image is old then.
#[derive(Clone, Debug)]
pub(crate) struct LightTicket {
    gate: Arc<AtomicU64>,
    number: u64,
}

impl Gate {
    pub(super) fn set(&mut self, is_black: bool) {
        let number = self.0.load(Ordering::Acquire);
        if is_odd(number) != is_black {
            self.0.store(number + 1, Ordering::Release);
        }
    }

    pub(super) fn ticket(&self) -> LightTicket {
        LightTicket { gate: Arc::clone(&self.0), number: self.0.load(Ordering::Acquire) }
    }
}

impl LightTicket {
    /// `true` if the image may be lit.
    pub(crate) fn is_valid(&self) -> bool {
        !is_odd(self.number) && self.gate.load(Ordering::Acquire) == self.number
    }
}

fn is_odd(number: u64) -> bool {
    number % 2 == 1
}
