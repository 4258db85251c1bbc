//! The statuses of rviz's display tree, for the log, `/diagnostics` and `camera_stream check --live`.
//!
//! A [`StatusEntry`] is an entry of that tree: the global status, a display or a camera, each with its statuses.

use std::borrow::Cow;

use rcs_camera::{deviations, Advice, CameraModel};
use rcs_displays::{CameraView, Level, Statuses};
use rcs_files::projector::fields_of;
use rcs_messages::{stamp_nanos, MessageKind};
use rcs_ros::{Publications, RosNode};
use rcs_scene::DisplayId;
use rcs_transforms::{Time, TransformTree};

use crate::scene::camera_pose::{self, CameraProblem};
use crate::scene::SceneState;

/// Name of the status of a topic's publishers. rviz has none: it does not report a topic of another type.
pub(crate) const PUBLISHER: &str = "Publisher";
/// Beginning of its text, in rviz's words, while nobody publishes any topic of a display that has received nothing.
pub(crate) const NO_PUBLISHERS: &str = "No publishers on";
/// Name of the status of the fixed frame.
pub(crate) const FIXED_FRAME: &str = "Fixed Frame";

/// Kind of an entry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum EntryKind {
    /// The whole scene.
    Global,
    /// A display.
    #[default]
    Display,
    /// A CameraPub display.
    Camera,
}

/// The global status, a display or a camera, with its statuses.
#[derive(Clone, Debug, Default)]
pub(crate) struct StatusEntry<'a> {
    pub(crate) kind: EntryKind,
    pub(crate) display: Option<DisplayId>,
    /// The names of the groups around it and its own, as a text.
    pub(crate) path: String,
    /// Such as `rviz/Grid`; empty for the whole scene.
    pub(crate) class: String,
    /// The topic of a display's data or a camera's images, by its name in the config. Empty without one.
    pub(crate) topic: String,
    /// The subscribed topics, by their names in the config, and their types.
    pub(crate) subscriptions: Vec<(String, MessageKind)>,
    /// `true` if a message was received on any of them.
    pub(crate) has_received: bool,
    /// Number of messages received, of a display with topics.
    pub(crate) received: Option<u64>,
    /// Age of the data shown in milliseconds, where it is known.
    pub(crate) age_ms: Option<f64>,
    pub(crate) statuses: Cow<'a, Statuses>,
    /// Further figures and properties: name and value.
    pub(crate) values: Vec<(&'static str, String)>,
}

impl StatusEntry<'_> {
    /// The level of the worst of its statuses.
    pub(crate) fn level(&self) -> Level {
        self.statuses.level()
    }
}

pub(crate) fn path_text(path: &[String]) -> String {
    path.join(" / ")
}

/// Age of data in milliseconds, negative for a stamp in the future. `None` for stamp zero, or before the first
/// `/clock`.
pub(crate) fn age_ms(stamp: Time, now: Time) -> Option<f64> {
    (!stamp.is_zero() && !now.is_zero()).then(|| now.secs_since(stamp) * 1e3)
}

/// The global status and the displays, in the config's order. `now` is ROS time, for the age of the data shown.
pub(crate) fn scene(state: &SceneState, now: Time) -> Vec<StatusEntry<'_>> {
    let of_display = state.reports().map(|report| StatusEntry {
        kind: EntryKind::Display,
        display: Some(report.id),
        path: path_text(&report.listed.path),
        class: report.listed.class.clone(),
        topic: report.listed.topic.clone().unwrap_or_default(),
        subscriptions: report.topics.iter().map(|request| (request.topic.clone(), request.kind)).collect(),
        has_received: report.received > 0,
        received: (!report.topics.is_empty()).then_some(report.received),
        age_ms: report.shown.and_then(|shown| age_ms(shown.stamp, now)),
        statuses: report.statuses,
        values: Vec::new(),
    });
    let (transforms, fixed_frame) = state.frames();
    std::iter::once(global(transforms, fixed_frame)).chain(of_display).collect()
}

/// rviz's "Global Status".
fn global(transforms: &TransformTree, fixed_frame: &str) -> StatusEntry<'static> {
    let mut statuses = Statuses::default();
    if transforms.frame_exists(fixed_frame) {
        statuses.set(Level::Ok, FIXED_FRAME, "OK");
    } else if transforms.frames().next().is_none() {
        statuses.set(Level::Warn, FIXED_FRAME, "No TF data");
    } else {
        statuses.set(Level::Error, FIXED_FRAME, format!("Unknown frame {fixed_frame}"));
    }
    StatusEntry {
        kind: EntryKind::Global,
        path: "Global Status".to_owned(),
        statuses: Cow::Owned(statuses),
        values: vec![("fixed frame", fixed_frame.to_owned())],
        ..StatusEntry::default()
    }
}

/// The program's arguments against deviations of a projection.
const ADVICE: Advice = Advice { exact: "--projection exact follows P", undistort: "--undistort allows for it" };

/// The deviations of a camera's projection from its CameraInfo, each as a phrase.
pub(crate) fn deviations_of(state: &SceneState, view: &CameraView, model: CameraModel) -> Vec<String> {
    let info = state.camera_info(view);
    let no_lens = state.lenses().problem(&view.settings.camera_info_topic).filter(|_| model.undistort);
    info.map(|info| deviations(&fields_of(info), model, no_lens, ADVICE)).unwrap_or_default()
}

/// A camera, with the statuses that rviz's CameraPub has.
pub(crate) fn camera(state: &SceneState, view: &CameraView, model: CameraModel) -> StatusEntry<'static> {
    let settings = &view.settings;
    let mut statuses = Statuses::default();
    if settings.image_topic.is_empty() {
        statuses.set(Level::Error, "Output Topic", "No topic set");
    } else {
        statuses.set(Level::Ok, "Output Topic", "Topic set");
    }
    let mut values = Vec::new();
    if settings.camera_info_topic.is_empty() {
        statuses.set(Level::Error, "Camera Info", "No topic set");
    } else {
        values.push(("camera info topic", settings.camera_info_topic.clone()));
        match camera_pose::camera(state, view, model) {
            Ok(_) => {
                let deviations = deviations_of(state, view, model);
                if deviations.is_empty() {
                    statuses.set(Level::Ok, "Camera Info", "OK");
                } else {
                    statuses.set(Level::Warn, "Camera Info", deviations.join("; "));
                }
            }
            Err(problem @ CameraProblem::NoCameraInfo { .. }) => {
                statuses.set(Level::Warn, "Camera Info", problem.to_string());
            }
            Err(problem @ CameraProblem::BadCameraInfo { .. }) => {
                statuses.set(Level::Error, "Camera Info", problem.to_string());
            }
            Err(CameraProblem::NoTransform { error, .. }) => {
                statuses.set(Level::Ok, "Camera Info", "OK");
                statuses.set(Level::Error, Statuses::TRANSFORM, error.to_string());
            }
        }
    }
    let info = state.camera_info(view);
    if let Some(info) = info {
        values.push(("size", format!("{}x{}", info.width, info.height)));
        values.push(("frame", info.header.frame_id.clone()));
    }
    values.push(("encoding", settings.image_encoding.name().to_owned()));
    StatusEntry {
        kind: EntryKind::Camera,
        path: path_text(&view.path),
        class: "rviz_camera_stream/CameraPub".to_owned(),
        topic: settings.image_topic.clone(),
        subscriptions: vec![(settings.camera_info_topic.clone(), MessageKind::CameraInfo)],
        has_received: info.is_some(),
        statuses: Cow::Owned(statuses),
        values,
        ..StatusEntry::default()
    }
}

/// Adds a warning if nothing was received and nobody publishes any of the topics, and an error if one of them is
/// published with another type. `full_name` resolves the config's names.
fn add_publishers(
    entry: &mut StatusEntry<'_>,
    publications: &Publications,
    full_name: impl Fn(&str) -> Option<String>,
) {
    let subscribed = entry.subscriptions.iter().filter(|(topic, _)| !topic.is_empty());
    let known: Vec<_> = subscribed.filter_map(|(topic, kind)| Some((full_name(topic)?, kind.ros_type()))).collect();
    for (topic, wanted) in &known {
        let Some(publication) = publications.get(topic) else { continue };
        if !publication.has_type(wanted) {
            let (found, nodes) = (&publication.ros_type, publication.nodes.join(", "));
            let text = format!("[{topic}] is published as {found} by {nodes}, not as {wanted}");
            entry.statuses.to_mut().set(Level::Error, PUBLISHER, text);
            return;
        }
    }
    // A display may subscribe to several topics of which one is enough, so it is warned about only if all are silent.
    let nobody = known.iter().all(|(topic, _)| publications.get(topic).is_none());
    if let (Some((topic, _)), false, true) = (known.first(), entry.has_received, nobody) {
        let text = format!("{NO_PUBLISHERS} [{topic}].  Topic may not exist.");
        entry.statuses.to_mut().set(Level::Warn, PUBLISHER, text);
    }
}

/// Adds a warning for a topic whose publisher's node does not answer, in roscpp's words. The node itself does not: it
/// logs one line for each such node, however many displays subscribe to it.
pub(crate) fn add_unreachable_publishers(entries: &mut [StatusEntry<'_>], ros: &RosNode) {
    for entry in entries.iter_mut().filter(|entry| entry.statuses.get(PUBLISHER).is_none()) {
        let topics = entry.subscriptions.iter().filter_map(|(topic, _)| ros.resolve(topic).ok());
        let dead = topics.flat_map(|topic| {
            let nodes = ros.unreachable_publishers(&topic).into_iter();
            nodes.map(move |node| {
                format!("Failed to contact publisher [{}] for topic [{topic}]: {}", node.node, node.reason)
            })
        });
        let dead: Vec<String> = dead.collect();
        if !dead.is_empty() {
            entry.statuses.to_mut().set(Level::Warn, PUBLISHER, dead.join("; "));
        }
    }
}

/// Adds statuses from the ROS graph: the topics' publishers, and a simulation that does not publish its time.
pub(crate) fn add_ros_graph(entries: &mut [StatusEntry<'_>], ros: &RosNode) {
    if let Some(publications) = ros.publications() {
        for entry in entries.iter_mut() {
            add_publishers(entry, &publications, |name| ros.resolve(name).ok());
        }
    }
    let global = entries.iter_mut().find(|entry| entry.kind == EntryKind::Global);
    if let (Some(global), true, 0) = (global, ros.is_simulated(), stamp_nanos(ros.now())) {
        let text = "/use_sim_time is set and no /clock was received";
        global.statuses.to_mut().set(Level::Warn, "Time", text);
    }
}

#[cfg(test)]
mod tests {
    use rcs_ros::Publication;
    use rcs_transforms::RawTransform;

    use super::*;

    #[test]
    fn a_missing_fixed_frame_is_reported_in_rvizs_words() {
        let mut transforms = TransformTree::new();
        let status_of = |transforms: &TransformTree| {
            let global = global(transforms, "map");
            let status = global.statuses.get(FIXED_FRAME).unwrap();
            (status.level, status.text.clone())
        };
        assert_eq!(status_of(&transforms), (Level::Warn, "No TF data".to_owned()));
        for (parent, expected) in [("world", (Level::Error, "Unknown frame map")), ("map", (Level::Ok, "OK"))] {
            let (stamp, translation, rotation_xyzw) = (Time::ZERO, [0.0; 3], [0.0, 0.0, 0.0, 1.0]);
            let transform = RawTransform { parent, child: "arm", stamp, translation, rotation_xyzw };
            transforms.insert(&transform, true, "/a").unwrap();
            assert_eq!(status_of(&transforms), (expected.0, expected.1.to_owned()));
        }
    }

    #[test]
    fn ages_are_negative_for_future_stamps_and_unknown_without_stamp_or_time() {
        let at = |secs| Time::from_secs_nanos(secs, 0);
        assert_eq!(age_ms(at(102), at(100)), Some(-2000.0));
        assert_eq!(age_ms(at(99), at(100)), Some(1000.0));
        assert_eq!([age_ms(Time::ZERO, at(100)), age_ms(at(99), Time::ZERO)], [None; 2]);
    }

    #[test]
    fn a_topic_without_publisher_or_of_another_type_is_reported() {
        let entry = |has_received| StatusEntry {
            subscriptions: vec![
                ("m".to_owned(), MessageKind::Marker),
                ("m_array".to_owned(), MessageKind::MarkerArray),
            ],
            has_received,
            ..StatusEntry::default()
        };
        let published = |list: &[(&str, &str)]| {
            let publication =
                |ros_type: &str| Publication { nodes: vec!["/a".to_owned()], ros_type: ros_type.to_owned() };
            list.iter().map(|(topic, ros_type)| ((*topic).to_owned(), publication(ros_type))).collect::<Publications>()
        };
        let status_of = |has_received, list: &[(&str, &str)]| {
            let mut entry = entry(has_received);
            add_publishers(&mut entry, &published(list), |name| Some(format!("/ns/{name}")));
            entry.statuses.get(PUBLISHER).map(|status| (status.level, status.text.clone()))
        };
        let nobody = (Level::Warn, "No publishers on [/ns/m].  Topic may not exist.".to_owned());
        assert_eq!(status_of(false, &[("/m", "visualization_msgs/Marker")]), Some(nobody));
        assert_eq!(status_of(true, &[]), None);
        assert_eq!(status_of(false, &[("/ns/m", "visualization_msgs/Marker")]), None);
        assert_eq!(status_of(false, &[("/ns/m_array", "visualization_msgs/MarkerArray")]), None);
        assert_eq!(status_of(false, &[("/ns/m", "*")]), None);
        let (level, text) = status_of(true, &[("/ns/m", "sensor_msgs/Joy")]).unwrap();
        assert_eq!((level, text.contains("[/ns/m]") && text.contains("sensor_msgs/Joy by /a")), (Level::Error, true));
    }
}
