//! Publishes the node's status on `/diagnostics`, where ROS's monitors (rqt_robot_monitor, diagnostic_aggregator)
//! expect it.

use rcs_messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use rcs_messages::std_msgs::Header;
use rcs_messages::{Serialized, Time};

use crate::image_topic::{advertise, send_error, PublishError};
use crate::listeners::tune_listeners;

/// The topic, before remapping.
const TOPIC: &str = "/diagnostics";
/// For slow subscribers the oldest are dropped.
const QUEUE_SIZE: usize = 4;

/// Publishes on `/diagnostics` until it is dropped.
pub struct DiagnosticsPublisher {
    publisher: rosrust::Publisher<Serialized<DiagnosticArray>>,
    next_seq: u32,
}

impl DiagnosticsPublisher {
    /// Publishes on the running rosrust node.
    ///
    /// # Errors
    /// [`PublishError`] if the topic cannot be published.
    pub fn new() -> Result<Self, PublishError> {
        let publisher = advertise(TOPIC, QUEUE_SIZE)?;
        tune_listeners();
        Ok(Self { publisher, next_seq: 0 })
    }

    /// Sends the status at `stamp`. Never waits.
    ///
    /// # Errors
    /// [`PublishError`] if the message cannot be sent.
    pub fn publish(&mut self, status: Vec<DiagnosticStatus>, stamp: Time) -> Result<(), PublishError> {
        let header = Header { seq: self.next_seq, stamp, frame_id: String::new() };
        self.next_seq = self.next_seq.wrapping_add(1);
        // Serialised here: of a message whose type it knows, rosrust replaces a sequence number of zero by its own.
        let message = Serialized::new(rcs_messages::encode(&DiagnosticArray { header, status }));
        self.publisher.send(message).map_err(|error| send_error(TOPIC, &error))
    }
}
