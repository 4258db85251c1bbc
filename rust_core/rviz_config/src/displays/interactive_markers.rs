//! `rviz/InteractiveMarkers`: the handles of `visualization_msgs/InteractiveMarkerUpdate`.

use crate::displays::{DisplayConfig, DisplaySettings};
use crate::node::{Content, Node};
use crate::section::Section;

/// The mouse tool with which rviz shows all controls.
const INTERACT: &str = "rviz/Interact";

/// The properties of an InteractiveMarkers display.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InteractiveMarkersSettings {
    /// Topic of `visualization_msgs/InteractiveMarkerUpdate`, ending in `/update`; empty when none is chosen.
    pub update_topic: String,
    /// Whether each marker's description is written above it.
    pub show_descriptions: bool,
    /// Whether each marker's axes are drawn.
    pub show_axes: bool,
    /// Whether controls may be translucent. If not, all that is not invisible is opaque.
    pub enable_transparency: bool,
    /// Not a property of the display: whether rviz starts with its Interact tool, which is the first of the file's
    /// tools or none. With another tool rviz hides the controls that are not always visible.
    pub interaction_enabled: bool,
}

impl Default for InteractiveMarkersSettings {
    fn default() -> Self {
        InteractiveMarkersSettings {
            update_topic: String::new(),
            show_descriptions: true,
            show_axes: false,
            enable_transparency: true,
            interaction_enabled: true,
        }
    }
}

impl InteractiveMarkersSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = InteractiveMarkersSettings::default();
        section.text("Update Topic", &mut settings.update_topic);
        section.bool("Show Descriptions", &mut settings.show_descriptions);
        section.bool("Show Axes", &mut settings.show_axes);
        // Lines that show what a control does while it is dragged.
        section.skip(&["Show Visual Aids"]);
        section.bool("Enable Transparency", &mut settings.enable_transparency);
        settings
    }

    /// The namespace of the interactive marker server: the topic up to its first `/update`. `None` where the topic has
    /// none, which rviz refuses.
    pub fn namespace(&self) -> Option<&str> {
        self.update_topic.split_once("/update").map(|(namespace, _)| namespace)
    }
}

/// Sets in the displays with which tool of the list under `Tools` rviz starts.
pub(crate) fn apply_tools(displays: &mut [DisplayConfig], tools: Option<&Node>) {
    let class_of = |tool: &Node| match tool.get("Class").map(|class| &class.content) {
        Some(Content::Scalar(class)) => Some(class.clone()),
        _ => None,
    };
    let class = match tools.map(|tools| &tools.content) {
        Some(Content::List(items)) => items.iter().find_map(|tool| class_of(tool)),
        _ => None,
    };
    set_interaction(displays, class.as_deref() == Some(INTERACT));
}

fn set_interaction(displays: &mut [DisplayConfig], enabled: bool) {
    for display in displays {
        match &mut display.settings {
            DisplaySettings::InteractiveMarkers(settings) => settings.interaction_enabled = enabled,
            DisplaySettings::Group(group) => set_interaction(&mut group.displays, enabled),
            _ => {}
        }
    }
}
