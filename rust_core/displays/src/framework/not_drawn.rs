//! A display without drawables, with a status that gives the reason.

use rcs_scene::Drawable;

use crate::framework::display::Display;
use crate::{Level, Statuses, World};

#[derive(Debug)]
pub(crate) struct NotDrawnDisplay {
    statuses: Statuses,
}

impl NotDrawnDisplay {
    pub(crate) fn window_only() -> Self {
        Self::with_status(Level::Ok, "Seen in rviz's window only.")
    }

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
