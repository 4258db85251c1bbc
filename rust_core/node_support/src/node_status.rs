//! A node's status: once a second on `/diagnostics`, changes also in the log.

use std::fmt::Display;
use std::time::{Duration, Instant};

pub use rcs_displays::Level;
use rcs_messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use rcs_ros::{NodeError, Publisher, RosNode};

/// Publishing period of an unchanged status.
const PERIOD: Duration = Duration::from_secs(1);
const HARDWARE_ID: &str = "rviz_camera_stream";

/// A status on `/diagnostics` of a part of a node, with its key-value pairs.
pub fn diagnostic_status<'v>(
    node: &str,
    part: &str,
    (level, message): (Level, &str),
    values: impl IntoIterator<Item = (&'v str, String)>,
) -> DiagnosticStatus {
    DiagnosticStatus {
        level: match level {
            Level::Ok => DiagnosticStatus::OK,
            Level::Warn => DiagnosticStatus::WARN,
            Level::Error => DiagnosticStatus::ERROR,
        },
        name: format!("{}: {part}", node.trim_start_matches('/')),
        message: message.to_owned(),
        hardware_id: HARDWARE_ID.to_owned(),
        values: values.into_iter().map(|(key, value)| KeyValue { key: key.to_owned(), value }).collect(),
    }
}

/// A node's one status.
pub struct NodeStatus {
    publisher: Publisher<DiagnosticArray>,
    node: String,
    part: &'static str,
    current: Option<(Level, String)>,
    values: Vec<(&'static str, String)>,
    published: Option<Instant>,
}

impl NodeStatus {
    /// Advertises the topic; the status is called `NODE: part`.
    ///
    /// # Errors
    /// [`NodeError::Name`], if the topic is remapped to no name.
    pub fn start(node: &RosNode, part: &'static str) -> Result<Self, NodeError> {
        let publisher = node.diagnostics_publisher()?;
        let node = node.name().to_owned();
        Ok(Self { publisher, node, part, current: None, values: Vec::new(), published: None })
    }

    /// Sets the status. A change of level or message is logged with `detail`, for numbers that change often.
    pub fn set(&mut self, level: Level, message: &str, detail: &str) {
        if self.current.as_ref().is_some_and(|(known, text)| *known == level && text == message) {
            return;
        }
        let line = if detail.is_empty() { message.to_owned() } else { format!("{message} ({detail})") };
        match level {
            Level::Ok => log::info!("{line}"),
            Level::Warn => log::warn!("{line}"),
            Level::Error => log::error!("{line}"),
        }
        self.current = Some((level, message.to_owned()));
        self.published = None;
    }

    /// Sets a key-value pair of the status.
    pub fn value(&mut self, key: &'static str, value: &dyn Display) {
        let value = value.to_string();
        match self.values.iter_mut().find(|(known, _)| *known == key) {
            Some((_, known)) => *known = value,
            None => self.values.push((key, value)),
        }
    }

    /// Publishes the status if it has changed or a second has passed.
    ///
    /// # Errors
    /// See [`Publisher::send`].
    pub fn publish_if_due(&mut self) -> std::io::Result<()> {
        let Some((level, message)) = &self.current else { return Ok(()) };
        if self.published.is_some_and(|published| published.elapsed() < PERIOD) {
            return Ok(());
        }
        self.published = Some(Instant::now());
        let values = self.values.iter().map(|(key, value)| (*key, value.clone()));
        let status = diagnostic_status(&self.node, self.part, (*level, message), values);
        self.publisher.send(DiagnosticArray { status: vec![status], ..DiagnosticArray::default() })
    }
}
