//! Callback of a window when an image is on the screen.

use std::fmt::Debug;

/// Hears when an image is on the screen.
pub trait OnScreen: Debug + Send + Sync {
    /// The display server has completed the image in the window, or has it where it does not report that. Called on
    /// the window's thread, once, and never for an image that a newer one has replaced before.
    fn shown(&self);
}
