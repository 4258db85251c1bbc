//! `rviz/Marker` and `rviz/MarkerArray`: the same display, subscribing to another kind of message.
//!
//! A Marker display draws the markers of its topic and also the arrays of the topic's name with `_array` after it. A
//! MarkerArray display draws only the arrays of its topic.

use std::collections::BTreeMap;

use crate::node::Content;
use crate::qt_value;
use crate::report::ENTRY;
use crate::section::Section;

properties! {
    /// The properties of a Marker or MarkerArray display; the defaults are a Marker's.
    pub struct MarkerSettings {
        /// Topic of `visualization_msgs/Marker` or `visualization_msgs/MarkerArray`.
        topic: String = "visualization_marker".to_owned() => text("Marker Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 100 => count("Queue Size", 0);
        /// The namespaces in the config; `true` for those that are drawn.
        namespaces: BTreeMap<String, bool> = BTreeMap::new();
    }
    then read_namespaces;
}

impl MarkerSettings {
    /// The defaults of a MarkerArray display.
    pub fn array_default() -> Self {
        MarkerSettings { topic: "visualization_marker_array".to_owned(), ..MarkerSettings::default() }
    }

    /// `true` if the markers of `namespace` are drawn: unless the config switches it off.
    pub fn shows_namespace(&self, namespace: &str) -> bool {
        self.namespaces.get(namespace).copied().unwrap_or(true)
    }

    /// Reads the properties of a MarkerArray display.
    pub(crate) fn read_array(section: &mut Section<'_>) -> Self {
        let mut settings = Self::array_default();
        section.properties(&mut settings);
        settings
    }

    fn read_namespaces(&mut self, section: &mut Section<'_>) {
        let mut namespaces = section.child("Namespaces");
        namespaces.record(ENTRY, || true.to_string());
        for (namespace, node) in namespaces.all() {
            // Only a scalar has a value, and rviz takes no value for false.
            let shown = match &node.content {
                Content::Scalar(text) => qt_value::to_bool(text).0,
                Content::Null | Content::List(_) | Content::Map(_) => false,
            };
            self.namespaces.insert(namespace.to_owned(), shown);
        }
    }
}
