//! Answers from a running ROS and the desktop: frames, links, topics and how often they are published, monitors.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use rcs_files::projector::ProjectorFile;
use rcs_messages::MessageKind;
use rcs_node_support::frames::take_events;
use rcs_robot::Robot;
use rcs_ros::{NodeError, NodeEvent, RosNode, TopicSubscription};
use rcs_transforms::TransformTree;
use rcs_window::{MonitorChoice, MonitorInfo};

use crate::display_type::{self, DisplayType};
use crate::scene_names::{IMAGE_TOPIC, LENS_FRAME};

/// Time to receive transforms and the robot's description.
const LOOK_TIMEOUT: Duration = Duration::from_millis(1500);
/// Longest time to measure rates: two messages of a topic that comes every two seconds.
const RATE_TIMEOUT: Duration = Duration::from_secs(5);
/// Messages after which a topic's rate is known.
const ENOUGH_MESSAGES: usize = 5;
/// Parameter with the robot's description.
const ROBOT_DESCRIPTION: &str = "robot_description";

/// Everything found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    /// Frames of TF.
    pub(crate) frames: BTreeSet<String>,
    /// Links of the robot's description.
    pub(crate) links: BTreeSet<String>,
    /// Frame that the folder's calibrated projector is placed in.
    pub(crate) mount: Option<String>,
    /// Published topics and their types.
    pub(crate) topics: BTreeMap<String, String>,
    /// Monitors of this computer.
    pub(crate) monitors: Vec<MonitorInfo>,
    /// `true` if a ROS master answers.
    pub(crate) has_master: bool,
}

/// How a topic is published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rate {
    /// Its publisher latches, and has sent one message at most.
    Latched,
    /// Longest time between two messages.
    Every(Duration),
}

/// The node that looks, or `None` without a master.
pub(crate) fn connect() -> Option<RosNode> {
    let name = format!("rviz_camera_stream_setup_{}", std::process::id());
    match RosNode::connect_now(&name, &|| false) {
        Ok(node) => Some(node),
        Err(NodeError::NoMaster { .. }) => None,
        Err(error) => {
            log::warn!("cannot ask the ROS master: {error}; going on without it");
            None
        }
    }
}

impl Found {
    /// Asks the master, listens to TF for a moment, and lists the monitors.
    pub(crate) fn look(node: Option<&RosNode>) -> Self {
        let monitors = rcs_window::list_monitors().unwrap_or_else(|error| {
            log::debug!("no monitors: {error}");
            Vec::new()
        });
        let Some(node) = node else { return Self { monitors, ..Self::default() } };
        let (frames, links) = listen(node);
        let publications = node.query_publications().unwrap_or_default();
        let topics = publications.iter().map(|(topic, publication)| (topic.clone(), publication.ros_type.clone()));
        Self { frames, links, topics: topics.collect(), monitors, has_master: true, mount: None }
    }

    /// Adds the frames of the folder's calibrated projector.
    pub(crate) fn add_projector(&mut self, file: &ProjectorFile) {
        let lens = file.frames.iter().find(|frame| frame.child == file.camera_info.header.frame_id);
        self.mount = lens.map(|frame| frame.parent.clone());
        self.frames.extend(file.frames.iter().flat_map(|frame| [frame.parent.clone(), frame.child.clone()]));
    }

    /// Names of the frames and links that a projector can be mounted on.
    pub(crate) fn frame_names(&self) -> BTreeSet<&str> {
        self.frames.iter().chain(&self.links).map(String::as_str).collect()
    }

    /// The first of these frames that exists.
    pub(crate) fn first_frame(&self, names: &[&str]) -> Option<String> {
        let known = self.frame_names();
        names.iter().find(|name| known.contains(*name)).map(|name| (*name).to_owned())
    }

    /// The monitor of that name or number; for `auto`, the last that is not the primary.
    pub(crate) fn monitor(&self, name: &str) -> Option<&MonitorInfo> {
        let Ok(choice) = name.parse::<MonitorChoice>();
        choice.resolve(&self.monitors).ok().and_then(|index| self.monitors.get(index))
    }

    /// Topics that have a display, with it.
    pub(crate) fn displayable(&self) -> impl Iterator<Item = (&str, &'static DisplayType)> {
        self.topics.iter().filter_map(|(topic, ros_type)| Some((topic.as_str(), display_type::find(ros_type).ok()?)))
    }

    /// Colour and depth images of a camera, the best guess by their names.
    pub(crate) fn camera_images(&self) -> [Option<&str>; 2] {
        let images: Vec<&str> = self
            .topics
            .iter()
            .filter(|(topic, ros_type)| *ros_type == "sensor_msgs/Image" && !topic.starts_with(IMAGE_TOPIC))
            .map(|(topic, _)| topic.as_str())
            .collect();
        let best = |wanted: &[&str], is_usable: &dyn Fn(&str) -> bool| {
            let count = |topic: &str| wanted.iter().filter(|word| topic.contains(*word)).count();
            let usable = images.iter().filter(|topic| is_usable(topic) && count(topic) > 0);
            usable.max_by_key(|topic| (count(topic), std::cmp::Reverse(topic.len()))).copied()
        };
        let is_depth = |topic: &str| topic.contains("depth");
        [
            best(&["rgb", "color", "image_raw", "image_rect_color"], &|topic| !is_depth(topic)),
            best(&["depth", "registered", "aligned", "image"], &is_depth),
        ]
    }

    /// `true` if the topic lies beside a camera's images, so that it shows what that camera sees.
    pub(crate) fn is_of_sensor(&self, topic: &str) -> bool {
        let namespace = |topic: &str| topic.trim_start_matches('/').split('/').next().map(str::to_owned);
        let own = namespace(topic);
        self.topics.iter().any(|(other, ros_type)| {
            matches!(&**ros_type, "sensor_msgs/CameraInfo" | "sensor_msgs/Image") && namespace(other) == own
        })
    }
}

/// Frames of TF and links of the robot's description, as far as they arrive within a moment.
fn listen(node: &RosNode) -> (BTreeSet<String>, BTreeSet<String>) {
    let (mut tree, mut links) = (TransformTree::new(), BTreeSet::new());
    if let Err(error) = node.subscribe_transforms() {
        log::warn!("cannot subscribe to /tf: {error}");
    }
    node.follow_parameters(vec![ROBOT_DESCRIPTION.to_owned()]);
    let started = Instant::now();
    while started.elapsed() < LOOK_TIMEOUT {
        take_events(node, LOOK_TIMEOUT.saturating_sub(started.elapsed()), &mut tree, |event| {
            if let NodeEvent::Parameter { text: Some(text), .. } = event {
                match Robot::parse(&text) {
                    Ok(robot) => links = robot.links.into_keys().collect(),
                    Err(error) => log::warn!("{ROBOT_DESCRIPTION}: {error}"),
                }
            }
        });
    }
    (tree.frames().filter(|frame| *frame != LENS_FRAME).map(str::to_owned).collect(), links)
}

/// How these topics are published, as far as that shows within some seconds.
pub(crate) fn measure(node: &RosNode, topics: &[(&str, &DisplayType)]) -> BTreeMap<String, Rate> {
    let mut received: BTreeMap<String, Vec<Instant>> = BTreeMap::new();
    let subscribe = |(topic, display): &(&str, &DisplayType)| {
        let kind = MessageKind::from_ros_type(display.ros_type)?;
        node.subscribe(topic, kind, ENOUGH_MESSAGES).map_err(|error| log::warn!("{topic}: {error}")).ok()
    };
    let subscriptions: Vec<TopicSubscription> = topics.iter().filter_map(subscribe).collect();
    let started = Instant::now();
    while started.elapsed() < RATE_TIMEOUT {
        let count = |subscription: &TopicSubscription| received.get(&**subscription.topic()).map_or(0, Vec::len);
        // A publisher that latches may send a stream all the same.
        if subscriptions.iter().all(|subscription| count(subscription) >= ENOUGH_MESSAGES) {
            break;
        }
        for event in node.events().wait(Duration::from_millis(100)) {
            if let NodeEvent::Message { topic, received: at, .. } = event {
                received.entry(topic.to_string()).or_default().push(at);
            }
        }
    }
    let rate = |subscription: &TopicSubscription| {
        let topic = subscription.topic().to_string();
        let times = received.get(&topic).map(Vec::as_slice).unwrap_or_default();
        let gaps = times.iter().zip(times.iter().skip(1)).map(|(first, next)| next.saturating_duration_since(*first));
        match gaps.max() {
            Some(longest) => Some((topic, Rate::Every(longest))),
            None => subscription.publishing().is_latched.then_some((topic, Rate::Latched)),
        }
    };
    subscriptions.iter().filter_map(rate).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A robot with a camera, detections and a second monitor.
    pub(crate) fn robot() -> Found {
        let topics = [
            ("/camera/color/camera_info", "sensor_msgs/CameraInfo"),
            ("/camera/color/image_raw", "sensor_msgs/Image"),
            ("/camera/depth/image_raw", "sensor_msgs/Image"),
            ("/camera/aligned_depth_to_color/image_raw", "sensor_msgs/Image"),
            ("/camera/depth/points", "sensor_msgs/PointCloud2"),
            ("/detections", "visualization_msgs/MarkerArray"),
            ("/objects", "sensor_msgs/PointCloud2"),
            ("/scan", "sensor_msgs/LaserScan"),
            ("/tf", "tf2_msgs/TFMessage"),
        ];
        let monitor = |name: &str, is_primary, size_px| MonitorInfo {
            name: name.to_owned(),
            is_primary,
            size_px,
            ..MonitorInfo::default()
        };
        Found {
            frames: ["odom", "base_link", "head_link"].map(str::to_owned).into(),
            links: ["base_link", "projector_mount"].map(str::to_owned).into(),
            topics: topics.iter().map(|(topic, name)| ((*topic).to_owned(), (*name).to_owned())).collect(),
            monitors: vec![monitor("eDP-1", true, (1920, 1080)), monitor("HDMI-1", false, (1280, 800))],
            has_master: true,
            mount: None,
        }
    }

    #[test]
    fn a_cameras_images_are_guessed_by_their_names() {
        let expected = [Some("/camera/color/image_raw"), Some("/camera/aligned_depth_to_color/image_raw")];
        assert_eq!(robot().camera_images(), expected);
        assert_eq!(Found::default().camera_images(), [None, None]);
    }

    #[test]
    fn a_cameras_own_cloud_is_told_from_results() {
        let found = robot();
        assert!(found.is_of_sensor("/camera/depth/points") && !found.is_of_sensor("/objects"));
    }
}
