//! Statuses of stale displays and dark cameras.

use rcs_displays::Level;

use crate::safety::{FramePolicy, Safety, STALE};
use crate::scene::status_tree::{EntryKind, StatusEntry};

/// Adds a warning to stale displays, and an error to the scene if rules name cameras that do not exist.
pub(crate) fn add(entries: &mut [StatusEntry<'_>], safety: &Safety) {
    for entry in entries {
        if let (EntryKind::Global, Some(why)) = (entry.kind, safety.unmatched()) {
            entry.statuses.to_mut().set(Level::Error, "Cameras", format!("all cameras are dark: {why}"));
        }
        let hidden = entry.display.zip(safety.assessment());
        if let Some(why) = hidden.and_then(|(id, assessment)| assessment.why_hidden(id, &entry.path)) {
            entry.statuses.to_mut().set(Level::Warn, STALE, format!("not drawn: {why}"));
        }
    }
}

/// Adds a camera's reason for a blackout.
pub(crate) fn add_dark(entry: &mut StatusEntry<'_>, policy: &FramePolicy) {
    if let Some(dark) = &policy.dark_reason {
        let level = if dark.cause.is_error() { Level::Error } else { Level::Warn };
        entry.statuses.to_mut().set(level, dark.cause.status(), format!("the picture is black: {dark}"));
    }
}
