//! `rviz/InteractiveMarkers`: the handles of `visualization_msgs/InteractiveMarkerUpdate`.

properties! {
    /// The properties of an InteractiveMarkers display.
    pub struct InteractiveMarkersSettings {
        /// Topic of `visualization_msgs/InteractiveMarkerUpdate`, ending in `/update`; empty when none is chosen.
        update_topic: String = String::new() => text("Update Topic");
        /// `true` if each marker's description is written above it.
        show_descriptions: bool = true => bool("Show Descriptions");
        /// `true` if each marker's axes are drawn.
        show_axes: bool = false => bool("Show Axes");
        /// `true` if controls may be translucent; else all that is not invisible is opaque.
        enable_transparency: bool = true => bool("Enable Transparency");
        /// Not a property of the display: `true` if rviz starts with its Interact tool, the first of the file's tools.
        /// With another tool rviz hides the controls that are not always visible.
        interaction_enabled: bool = true;
    }
    // Lines that show what a control does while it is dragged.
    skip ["Show Visual Aids"];
}

impl InteractiveMarkersSettings {
    /// The namespace of the interactive marker server: the topic up to its first `/update`. `None` where the topic has
    /// none, which rviz refuses.
    pub fn namespace(&self) -> Option<&str> {
        self.update_topic.split_once("/update").map(|(namespace, _)| namespace)
    }
}
