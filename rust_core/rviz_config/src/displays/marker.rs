//! `rviz/Marker` and `rviz/MarkerArray`: the same display, subscribing to another kind of message.
//!
//! A Marker display shows the markers of its topic and also the arrays of the topic's name with `_array` after it. A
//! MarkerArray display shows only the arrays of its topic.

use std::collections::BTreeMap;

use crate::node::Content;
use crate::qt_value;
use crate::section::{Section, ENTRY};

/// The properties of a Marker or MarkerArray display.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerSettings {
    /// Topic of `visualization_msgs/Marker` or `visualization_msgs/MarkerArray`.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// The namespaces that the config names, and whether each is shown.
    pub namespaces: BTreeMap<String, bool>,
}

impl Default for MarkerSettings {
    /// The defaults of a Marker display.
    fn default() -> Self {
        MarkerSettings { topic: "visualization_marker".to_owned(), queue_size: 100, namespaces: BTreeMap::new() }
    }
}

impl MarkerSettings {
    /// The defaults of a MarkerArray display.
    pub fn array_default() -> Self {
        MarkerSettings { topic: "visualization_marker_array".to_owned(), ..MarkerSettings::default() }
    }

    /// Whether the markers of `namespace` are shown: yes, unless the config switches it off.
    pub fn shows_namespace(&self, namespace: &str) -> bool {
        self.namespaces.get(namespace).copied().unwrap_or(true)
    }

    /// Reads the properties of a Marker display.
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::default())
    }

    /// Reads the properties of a MarkerArray display.
    pub(crate) fn read_array(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::array_default())
    }

    fn read_over(section: &mut Section<'_>, defaults: MarkerSettings) -> Self {
        let mut settings = defaults;
        section.text("Marker Topic", &mut settings.topic);
        section.count("Queue Size", 0, &mut settings.queue_size);
        let mut namespaces = section.child("Namespaces");
        namespaces.record(ENTRY, || true.to_string());
        for (namespace, node, _) in namespaces.all() {
            // What is no scalar has no value, and rviz takes no value for false.
            let shown = match &node.content {
                Content::Scalar(text) => qt_value::to_bool(text).0,
                Content::Null | Content::List(_) | Content::Map(_) => false,
            };
            settings.namespaces.insert(namespace.to_owned(), shown);
        }
        settings
    }
}
