//! A display that adds nothing to the scene, with a status that gives the reason.

use rcs_scene::Drawable;

use crate::framework::display::Display;
use crate::{Level, Statuses, World};

/// A display that shows nothing.
#[derive(Debug)]
pub(crate) struct NotDrawnDisplay {
    statuses: Statuses,
}

impl NotDrawnDisplay {
    /// A display that rviz shows in a panel of its window.
    pub(crate) fn window_only() -> Self {
        Self::with_status(Level::Ok, "Seen in rviz's window only.")
    }

    /// A display of a class that is not known; rviz lists it in red.
    pub(crate) fn unknown_class() -> Self {
        Self::with_status(Level::Error, "The class required for this display could not be loaded.")
    }

    fn with_status(level: Level, text: &str) -> Self {
        let mut statuses = Statuses::default();
        statuses.set(level, Statuses::CLASS, text);
        Self { statuses }
    }
}

impl Display for NotDrawnDisplay {
    fn update(&mut self, _world: &World<'_>) -> bool {
        false
    }

    fn drawables(&self) -> &[Drawable] {
        &[]
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
