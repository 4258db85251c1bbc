//! Publishes the node's status on `/diagnostics`, where ROS's monitors (rqt_robot_monitor, diagnostic_aggregator)
//! expect it.

use rcs_messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use rcs_messages::std_msgs::Header;
use rcs_messages::Time;

use crate::publisher::Publisher;
use crate::{NodeError, RosNode};

/// The topic, before remapping.
const TOPIC: &str = "/diagnostics";
/// For slow subscribers the oldest are dropped.
const QUEUE_SIZE: usize = 4;

/// Publishes on `/diagnostics` until it is dropped.
pub struct DiagnosticsPublisher {
    publisher: Publisher<DiagnosticArray>,
    next_seq: u32,
}

impl RosNode {
    /// Publishes on `/diagnostics`.
    ///
    /// # Errors
    /// [`NodeError::Name`], if it is remapped to no name.
    pub fn diagnostics_publisher(&self) -> Result<DiagnosticsPublisher, NodeError> {
        let publisher = Publisher::unobserved(self.network(), &self.resolve(TOPIC)?, QUEUE_SIZE, false);
        Ok(DiagnosticsPublisher { publisher, next_seq: 0 })
    }
}

impl DiagnosticsPublisher {
    /// Sends the status at `stamp`. Never waits.
    ///
    /// # Errors
    /// `InvalidInput` for a message of more than 4 GB.
    pub fn publish(&mut self, status: Vec<DiagnosticStatus>, stamp: Time) -> std::io::Result<()> {
        let header = Header { seq: self.next_seq, stamp, frame_id: String::new() };
        self.next_seq = self.next_seq.wrapping_add(1);
        self.publisher.send(&DiagnosticArray { header, status })
    }
}
