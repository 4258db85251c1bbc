//! The master's answer about a topic on which nothing is received, and the topics that may be meant.

use std::time::Duration;

use rcs_messages::MessageKind;
use rcs_node_support::near::near;
use rcs_ros::{Publication, Publications, RosNode};
use rcs_scan::ScanCameraError;

/// The error for a topic, by its whole name, on which no message of a type was received.
pub(super) fn silent_topic(node: &RosNode, topic: &str, kind: MessageKind, waited: Duration) -> ScanCameraError {
    let types = match kind {
        MessageKind::Image | MessageKind::CompressedImage => &[MessageKind::Image, MessageKind::CompressedImage][..],
        _ => &[kind],
    };
    let types: Vec<&str> = types.iter().map(|kind| kind.ros_type()).collect();
    let (reason, known_topics) = match node.publications() {
        Some(publications) => look_up(&publications, topic, &types),
        None => ("the ROS master does not answer".to_owned(), Vec::new()),
    };
    ScanCameraError::Silent { topic: topic.to_owned(), waited, reason, known_topics }
}

/// The reason why a topic is silent, and all topics of these types.
fn look_up(publications: &Publications, topic: &str, types: &[&str]) -> (String, Vec<String>) {
    let is_meant = |publication: &Publication| types.iter().any(|ros_type| publication.has_type(ros_type));
    let mut known: Vec<(&str, &Publication)> =
        publications.iter().map(|(name, known)| (name.as_str(), known)).collect();
    known.retain(|(_, publication)| is_meant(publication));
    known.sort_by_key(|(name, _)| *name);
    let reason = match publications.get(topic) {
        Some(publication) if is_meant(publication) => {
            format!("{} publishes it and sends nothing: is the camera on?", publication.nodes.join(", "))
        }
        Some(Publication { nodes, ros_type }) => {
            format!("{} publishes it as {ros_type}, not as {}", nodes.join(", "), types.join(" or "))
        }
        None => match near(topic, known.iter().map(|(name, _)| *name)).first() {
            Some(near) => format!("nobody publishes it; did you mean {near}?"),
            None => "nobody publishes it: is the camera's driver running?".to_owned(),
        },
    };
    let line = |(name, Publication { nodes, ros_type }): &(&str, &Publication)| {
        format!("{name}  {ros_type}  {}", nodes.join(", "))
    };
    let heading = match known.is_empty() {
        true => format!("the master knows no topic of type {}", types.join(" or ")),
        false => format!("topics of type {} that the master knows:", types.join(" or ")),
    };
    let lines = known.iter().map(line).map(|line| format!("  {line}"));
    (reason, std::iter::once(heading).chain(lines).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silent_topic_is_told_from_one_that_nobody_publishes() {
        let publication =
            |node: &str, ros_type: &str| Publication { nodes: vec![node.to_owned()], ros_type: ros_type.to_owned() };
        let all: Publications = [
            ("/camera/rgb/image_raw", publication("/camera", "sensor_msgs/Image")),
            ("/camera/rgb/image_raw/compressed", publication("/camera", "sensor_msgs/CompressedImage")),
            ("/camera/points", publication("/camera", "sensor_msgs/PointCloud2")),
        ]
        .map(|(topic, publication)| (topic.to_owned(), publication))
        .into();
        let types = ["sensor_msgs/Image", "sensor_msgs/CompressedImage"];
        let (reason, lines) = look_up(&all, "/camera/rbg/image_raw", &types);
        assert_eq!(reason, "nobody publishes it; did you mean /camera/rgb/image_raw?");
        assert_eq!(
            lines,
            [
                "topics of type sensor_msgs/Image or sensor_msgs/CompressedImage that the master knows:",
                "  /camera/rgb/image_raw  sensor_msgs/Image  /camera",
                "  /camera/rgb/image_raw/compressed  sensor_msgs/CompressedImage  /camera",
            ]
        );
        let reason = |topic, types: &[&str]| look_up(&all, topic, types).0;
        assert_eq!(
            reason("/camera/rgb/image_raw", &types),
            "/camera publishes it and sends nothing: is the camera on?"
        );
        assert_eq!(
            reason("/camera/points", &types[..1]),
            "/camera publishes it as sensor_msgs/PointCloud2, not as sensor_msgs/Image"
        );
        assert_eq!(reason("/scan", &types), "nobody publishes it: is the camera's driver running?");
        let (_, lines) = look_up(&all, "/camera/info", &["sensor_msgs/CameraInfo"]);
        assert_eq!(lines, ["the master knows no topic of type sensor_msgs/CameraInfo"]);
    }
}
