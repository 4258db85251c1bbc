//! Callback of a window when an image is on the screen.

use std::fmt::Debug;

/// Hears when a picture is on the screen.
pub trait OnScreen: Debug + Send + Sync {
    /// The display server has completed the picture in the window, or has it where it does not report that. Called on
    /// the window's thread, once, and never for a picture that a newer one has replaced before.
    fn shown(&self);
}
