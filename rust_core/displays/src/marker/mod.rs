//! `rviz/Marker` and `rviz/MarkerArray`.

use rcs_rviz_config::MarkerSettings;
use rcs_scene::{DisplayId, Drawable};

use crate::display::Display;
use crate::{Statuses, World};

/// A Marker or MarkerArray display.
#[derive(Debug)]
pub(crate) struct MarkerDisplay {
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

impl MarkerDisplay {
    pub(crate) fn single(_display: DisplayId, _settings: MarkerSettings) -> Self {
        Self { drawables: Vec::new(), statuses: Statuses::default() }
    }

    pub(crate) fn array(_display: DisplayId, _settings: MarkerSettings) -> Self {
        Self { drawables: Vec::new(), statuses: Statuses::default() }
    }
}

impl Display for MarkerDisplay {
    fn update(&mut self, _world: &World<'_>) -> bool {
        false
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
