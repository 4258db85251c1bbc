//! A node's status: once a second on `/diagnostics`, changes also in the log.

use std::fmt::Display;
use std::time::{Duration, Instant};

use rcs_messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use rcs_ros::{NodeError, Publisher, RosNode};

/// Publishing period of an unchanged status.
const PERIOD: Duration = Duration::from_secs(1);
const HARDWARE_ID: &str = "rviz_camera_stream";

/// Level of a status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The node works.
    Ok,
    /// An input is missing, or the target is out of reach.
    Warn,
    /// An input is invalid.
    Error,
}

/// A node's one status.
pub struct NodeStatus {
    publisher: Publisher<DiagnosticArray>,
    name: String,
    current: Option<(Level, String)>,
    values: Vec<(&'static str, String)>,
    published: Option<Instant>,
}

impl NodeStatus {
    /// Advertises the topic; the status is called `NODE: what`.
    ///
    /// # Errors
    /// [`NodeError::Name`], if the topic is remapped to no name.
    pub fn start(node: &RosNode, what: &str) -> Result<Self, NodeError> {
        let publisher = node.diagnostics_publisher()?;
        let name = format!("{}: {what}", node.name().trim_start_matches('/'));
        Ok(Self { publisher, name, current: None, values: Vec::new(), published: None })
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
        let values = self.values.iter().map(|(key, value)| KeyValue { key: (*key).to_owned(), value: value.clone() });
        let status = DiagnosticStatus {
            level: match level {
                Level::Ok => DiagnosticStatus::OK,
                Level::Warn => DiagnosticStatus::WARN,
                Level::Error => DiagnosticStatus::ERROR,
            },
            name: self.name.clone(),
            message: message.clone(),
            hardware_id: HARDWARE_ID.to_owned(),
            values: values.collect(),
        };
        self.publisher.send(DiagnosticArray { status: vec![status], ..DiagnosticArray::default() })
    }
}
