//! A display that is not drawn. It shows nothing and says so, as rviz lists a display in red whose class it could not
//! load.

use rcs_scene::Drawable;

use crate::framework::display::Display;
use crate::{Level, Statuses, World};

/// A display that shows nothing.
#[derive(Debug)]
pub(crate) struct NotDrawnDisplay {
    statuses: Statuses,
}

impl NotDrawnDisplay {
    /// A display that rviz shows in a panel of its window, and not in the scene.
    pub(crate) fn of_window() -> Self {
        let mut statuses = Statuses::default();
        statuses.set(Level::Ok, Statuses::CLASS, "Seen in rviz's window only.");
        Self { statuses }
    }

    /// A display of a class that is not known how to draw; `is_of_rviz` tells whether it is one of rviz's own classes.
    pub(crate) fn new(is_of_rviz: bool) -> Self {
        let mut statuses = Statuses::default();
        if is_of_rviz {
            statuses.set(Level::Warn, Statuses::CLASS, "This class is not drawn.");
        } else {
            statuses.set(Level::Error, Statuses::CLASS, "The class required for this display could not be loaded.");
        }
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
