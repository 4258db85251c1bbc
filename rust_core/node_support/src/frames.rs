//! Transforms as they come, and the frame tree of a small node.

use std::time::Duration;

use rcs_displays::time_from_stamp;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{quaternion_xyzw, translation_xyz};
use rcs_ros::{NodeEvent, RosNode};
use rcs_transforms::{RawTransform, Time, TransformTree};

/// The longest wait, after which a node looks whether it is to end.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// The transforms of a message, unchecked.
pub fn raw_transforms(message: &TFMessage) -> impl Iterator<Item = RawTransform<'_>> {
    message.transforms.iter().map(|stamped| RawTransform {
        parent: &stamped.header.frame_id,
        child: &stamped.child_frame_id,
        stamp: time_from_stamp(stamped.header.stamp),
        translation: translation_xyz(&stamped.transform.translation),
        rotation_xyzw: quaternion_xyzw(&stamped.transform.rotation),
    })
}

/// Puts the transforms of a message into a tree. What the tree refuses is logged.
pub fn insert_transforms(tree: &mut TransformTree, message: &TFMessage, is_static: bool, authority: &str) {
    for transform in raw_transforms(message) {
        if let Err(error) = tree.insert(&transform, is_static, authority) {
            log::warn!("{error}");
        }
    }
}

/// Takes all events of the node that came within `timeout`, or within a tenth of a second if that is less: transforms
/// go into the tree, which forgets what moved when a simulation's time goes back; all others are handed on.
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

/// The node's time as the tree has it.
pub fn now(node: &RosNode) -> Time {
    time_from_stamp(node.now())
}
