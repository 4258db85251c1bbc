//! The node `projector` as others nudge it, by its services.

use std::time::Duration;

use rcs_messages::dynamic_reconfigure::{Config, Reconfigure};
use rcs_messages::std_srvs::{Trigger, TriggerReq, TriggerRes};
use rcs_ros::{NodeError, RosNode};

use crate::nudge::Nudge;

/// Time that each call may take.
const CALL_TIMEOUT: Duration = Duration::from_secs(2);

/// The node that publishes a CameraInfo, and its nudge.
#[derive(Clone, Debug, PartialEq)]
pub struct NudgedProjector {
    /// Whole name of the node.
    pub node: String,
    /// Values that apply.
    pub nudge: Nudge,
}

impl NudgedProjector {
    /// The node `projector` that publishes a CameraInfo on a topic, by its whole name; `None` if there is none.
    ///
    /// # Errors
    /// [`NodeError`]: it does not answer.
    pub fn find(ros: &RosNode, topic: &str) -> Result<Option<Self>, NodeError> {
        let publications = ros.publications().or_else(|| ros.query_publications()).unwrap_or_default();
        let nodes = publications.get(topic).map(|publication| publication.nodes.as_slice()).unwrap_or_default();
        for node in nodes {
            // Calls only those that have a dynamic_reconfigure server of their own.
            if publications.contains_key(&format!("{node}/parameter_updates")) {
                // A request without values returns those that apply.
                if let Some(nudge) = set(ros, node, &Config::default())? {
                    return Ok(Some(Self { node: node.clone(), nudge }));
                }
            }
        }
        Ok(None)
    }

    /// Sets the values. Returns those that apply then.
    ///
    /// # Errors
    /// [`NodeError`]: it does not answer.
    pub fn set(&self, ros: &RosNode, nudge: &Nudge) -> Result<Self, NodeError> {
        let nudge = set(ros, &self.node, &nudge.config())?.unwrap_or_default();
        Ok(Self { node: self.node.clone(), nudge })
    }

    /// Calls `save` or `revert`.
    ///
    /// # Errors
    /// [`NodeError`]: it does not answer.
    pub fn trigger(&self, ros: &RosNode, service: &str) -> Result<TriggerRes, NodeError> {
        ros.call::<Trigger>(&format!("{}/{service}", self.node), &TriggerReq {}, CALL_TIMEOUT)
    }
}

fn set(ros: &RosNode, node: &str, values: &Config) -> Result<Option<Nudge>, NodeError> {
    let values = ros.call::<Reconfigure>(&format!("{node}/set_parameters"), values, CALL_TIMEOUT)?;
    Ok(Nudge::of_config(&values))
}
