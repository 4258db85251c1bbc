//! Transforms of `/tf` in a node's transform tree.

use std::time::Duration;

use rcs_displays::{raw_transforms, time_from_stamp};
use rcs_messages::tf2_msgs::TFMessage;
use rcs_ros::{NodeEvent, RosNode};
use rcs_transforms::{Time, TransformTree};

/// Longest wait for events, so that a node polls for its shutdown.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Puts the transforms of a message into a tree. What the tree refuses is logged.
pub fn insert_transforms(tree: &mut TransformTree, message: &TFMessage, is_static: bool, authority: &str) {
    for transform in raw_transforms(message) {
        if let Err(error) = tree.insert(&transform, is_static, authority) {
            log::warn!("{error}");
        }
    }
}

/// Handles the node's events of the next `timeout`, or 0.1 s if that is less: transforms go into the tree, which is
/// cleared when simulated time jumps back; the others go to `take_other`.
pub fn take_events(node: &RosNode, timeout: Duration, tree: &mut TransformTree, mut take_other: impl FnMut(NodeEvent)) {
    for event in node.events().wait(timeout.min(LONGEST_WAIT)) {
        match event {
            NodeEvent::Transforms { message, is_static, authority, .. } => {
                insert_transforms(tree, &message, is_static, &authority);
            }
            NodeEvent::TimeJumpedBack { .. } => tree.clear(),
            other => take_other(other),
        }
    }
}

/// Current ROS time of the node.
pub fn now(node: &RosNode) -> Time {
    time_from_stamp(node.now())
}
