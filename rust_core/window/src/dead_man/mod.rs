//! The dead-man's switch of a window: a projector becomes black even if the process that shows its images hangs or is
//! killed.
//!
//! A thread cannot watch its own process: a stopped one keeps its window on the screen, and a killed one uncovers the
//! desktop. So a small child process, the same executable with [`CHILD_ARGUMENT`], opens a black full-screen window
//! before the process opens its own above it. A pipe leads to the child; the window's thread writes a byte into it at
//! least four times per light limit. If the pipe is silent for that limit, or closes without the byte
//! [`END`](crate::switch_pipe::END), the child opens a second black window in front of all others, and closes it when
//! bytes come again.
//!
//! A child whose process has died keeps the monitor black until Escape is pressed, the display server ends, or the
//! child of a new process covers the monitor ([`hand_over`]).

mod child;
mod hand_over;
mod switch;

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

use crate::OnScreen;

pub(crate) use switch::DeadManSwitch;

/// First argument of the child process.
const CHILD_ARGUMENT: &str = "__black-window";
/// Byte of a process that is alive.
const ALIVE: u8 = b'.';
/// The child's line for an open window.
const OPEN: &str = "open";

/// Runs the black window if this process was started for that; `None` otherwise. To be called first in `main` by each
/// program that opens a window with [`WindowRole::Guarded`].
pub fn run_black_window() -> Option<ExitCode> {
    let mut arguments = std::env::args().skip(1);
    (arguments.next()? == CHILD_ARGUMENT).then(|| child::main(arguments))
}

/// The role of a window on its monitor.
#[derive(Debug, Clone, Default)]
pub enum WindowRole {
    /// Shows images.
    #[default]
    Plain,
    /// Shows images, with a dead-man's switch.
    Guarded,
    /// Black, in the switch's child process.
    Black(BlackWindow),
}

/// A black window of the child process.
#[derive(Debug, Clone)]
pub struct BlackWindow {
    /// `true` to stay in front of all other windows.
    is_in_front: bool,
    /// `true` once the process has died.
    is_orphaned: Arc<AtomicBool>,
    shown: Arc<Shown>,
}

/// Whether a window is on the screen.
#[derive(Debug, Default)]
struct Shown(AtomicBool);

impl OnScreen for Shown {
    fn shown(&self) {
        self.0.store(true, Ordering::Release);
    }
}

impl WindowRole {
    /// `true` for a window of the child process.
    pub(crate) fn is_black(&self) -> bool {
        matches!(self, Self::Black(_))
    }

    /// `true` for a window that stays in front of all others.
    pub(crate) fn is_in_front(&self) -> bool {
        matches!(self, Self::Black(black) if black.is_in_front)
    }

    /// `true` if the window takes the keyboard and can be closed by its user. A black window must not uncover the last
    /// image of a process that hangs.
    pub(crate) fn takes_keyboard(&self) -> bool {
        match self {
            Self::Plain | Self::Guarded => true,
            Self::Black(black) => black.is_orphaned.load(Ordering::Acquire),
        }
    }

    /// Hears when the window is on the screen for the first time. To be passed with each image until then: a display
    /// server may drop one for the next.
    pub(crate) fn listener(&self) -> Option<Arc<dyn OnScreen>> {
        match self {
            Self::Black(black) if !black.shown.0.load(Ordering::Acquire) => Some(Arc::clone(&black.shown) as _),
            _ => None,
        }
    }
}
