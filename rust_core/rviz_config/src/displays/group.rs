//! `rviz/Group`: displays inside a display.

use crate::displays::{read_list, DisplayConfig};
use crate::section::Section;

/// What is in a group.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GroupSettings {
    /// The displays, in the file's order.
    pub displays: Vec<DisplayConfig>,
}

impl GroupSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let path = section.path().to_owned();
        GroupSettings { displays: read_list(section, &path) }
    }
}
