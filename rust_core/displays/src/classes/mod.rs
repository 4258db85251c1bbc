//! One file or folder for each rviz display class, with a function `create` that makes a display of the class.
//!
//! The modules and [`create`], which goes by the settings, come from the rows of
//! [`display_classes`](rcs_rviz_config::display_classes).

use rcs_rviz_config::{display_classes, DisplaySettings};
use rcs_scene::DisplayId;

use crate::framework::display::Display;
use crate::framework::not_drawn::NotDrawnDisplay;

macro_rules! create_by_settings {
    ($(
        $variant:ident $class:literal $declare:tt $module:ident::$settings:ident::$read:ident [$($topic:ident)?] $role:ident $(($display:ident))?;
    )*) => {
        $($(pub(crate) mod $display;)?)*

        /// Makes a display. `None` for what is no display in the scene: groups and cameras.
        pub(crate) fn create(id: DisplayId, settings: &DisplaySettings) -> Option<Box<dyn Display>> {
            match settings {
                $($(DisplaySettings::$variant(settings) => Some(Box::new($display::create(id, settings))),)?)*
                DisplaySettings::Unknown { .. } => Some(Box::new(NotDrawnDisplay::unknown_class())),
                _ => None,
            }
        }
    };
}

display_classes!(create_by_settings);
