//! The protocol with servers, and what becomes of markers that images cannot show.

use std::sync::Arc;
use std::time::Duration;

use nalgebra::Point3;
use rcs_messages::std_msgs::Header;
use rcs_messages::visualization_msgs::{
    InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerInit, InteractiveMarkerPose, InteractiveMarkerUpdate,
    Marker,
};
use rcs_messages::AnyMessage;
use rcs_rviz_config::InteractiveMarkersSettings;
use rcs_transforms::{Time, TransformTree};

use super::{create, InteractiveMarkersDisplay};
use crate::framework::display::Display;
use crate::framework::test_world::{TestWorld, STL};
use crate::{Level, StatusCause, Statuses};

/// A display with the world around it. The frame `map` is fixed.
struct Bench {
    display: InteractiveMarkersDisplay,
    world: TestWorld,
}

impl Bench {
    fn with(settings: &InteractiveMarkersSettings) -> Self {
        Self { display: create(3, settings), world: TestWorld::at(Time::from_secs_nanos(100, 0)) }
    }

    fn new() -> Self {
        Self::with(&InteractiveMarkersSettings { update_topic: "/im/update".into(), ..Default::default() })
    }

    /// Sends a message, without an update.
    fn send(&mut self, message: &AnyMessage) {
        self.display.take(message, &self.world.get());
    }

    fn update(&mut self) -> bool {
        self.display.update(&self.world.get())
    }

    /// Begins with these markers.
    fn start(&mut self, markers: &[InteractiveMarker]) {
        self.send(&init("s", 1, markers));
        self.send(&keep_alive("s", 1));
        self.update();
    }

    fn publish(&mut self, message: &AnyMessage) {
        self.send(message);
        self.update();
    }

    fn wait(&mut self, time: Duration) -> bool {
        self.world.now = self.world.now.saturating_add(time);
        self.update()
    }

    fn frame(&mut self, child: &str, secs: u32, x: f64) {
        self.world.place(child, Time::from_secs_nanos(secs, 0), [x, 0.0, 0.0]);
    }

    fn places(&self) -> Vec<[f64; 3]> {
        let origin = |matrix: &nalgebra::Matrix4<f64>| matrix.transform_point(&Point3::origin());
        self.display.drawables().iter().map(|drawable| origin(&drawable.fixed_from_object).into()).collect()
    }

    fn status(&self, name: &str) -> Option<(Level, String)> {
        let found = self.display.statuses().iter().find(|(known, _)| *known == name);
        found.map(|(_, status)| (status.level, status.text.clone()))
    }

    fn text(&self, name: &str) -> String {
        self.status(name).map_or_else(String::new, |(_, text)| text)
    }
}

fn header(frame: &str, secs: u32) -> Header {
    Header { frame_id: frame.into(), stamp: rcs_messages::Time { sec: secs, nsec: 0 }, ..Header::default() }
}

/// A marker whose only control is a ring, so that it is one drawable at its own place.
fn ring(name: &str, header: Header, x: f64) -> InteractiveMarker {
    let control =
        InteractiveMarkerControl { interaction_mode: InteractiveMarkerControl::ROTATE_AXIS, ..Default::default() };
    let mut marker = InteractiveMarker { header, name: name.into(), controls: vec![control], ..Default::default() };
    marker.pose.position.x = x;
    marker
}

fn init(server: &str, sequence: u64, markers: &[InteractiveMarker]) -> AnyMessage {
    AnyMessage::InteractiveMarkerInit(Arc::new(InteractiveMarkerInit {
        server_id: server.into(),
        seq_num: sequence,
        markers: markers.to_vec(),
    }))
}

fn update(server: &str, sequence: u64, change: impl FnOnce(&mut InteractiveMarkerUpdate)) -> AnyMessage {
    let mut update = InteractiveMarkerUpdate {
        server_id: server.into(),
        seq_num: sequence,
        type_: InteractiveMarkerUpdate::UPDATE,
        ..Default::default()
    };
    change(&mut update);
    AnyMessage::InteractiveMarkerUpdate(Arc::new(update))
}

fn keep_alive(server: &str, sequence: u64) -> AnyMessage {
    update(server, sequence, |update| update.type_ = InteractiveMarkerUpdate::KEEP_ALIVE)
}

fn pose(name: &str, header: Header, x: f64) -> InteractiveMarkerPose {
    let mut pose = InteractiveMarkerPose { header, name: name.into(), ..Default::default() };
    pose.pose.position.x = x;
    pose
}

#[test]
fn markers_are_shown_from_the_first_update_with_a_matching_number() {
    let mut bench = Bench::new();
    assert_eq!(bench.text("General"), "Waiting for messages.");
    bench.publish(&init("s", 5, &[ring("a", header("map", 0), 1.0)]));
    assert_eq!(bench.text("s"), "Initialization: Waiting for first update/keep-alive message.");
    assert!(bench.places().is_empty());
    // What the list of all markers has already is left out; what follows it is applied.
    bench.send(&update("s", 5, |update| update.erases = vec!["a".into()]));
    bench.publish(&update("s", 6, |update| update.markers = vec![ring("b", header("map", 0), 2.0)]));
    assert_eq!(bench.places(), [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    assert_eq!((bench.text("s"), bench.text("General")), ("OK".into(), "Receiving messages.".into()));
    assert_eq!(bench.text("a"), "Locked to frame map");
    bench.publish(&update("s", 7, |update| {
        update.poses = vec![pose("b", header("map", 0), 3.0)];
        update.erases = vec!["a".into()];
    }));
    assert_eq!(bench.places(), [[3.0, 0.0, 0.0]]);
    assert_eq!(bench.status("a"), None);
    assert!(!bench.update(), "nothing new");
}

#[test]
fn a_list_from_before_the_first_update_is_not_enough() {
    let mut bench = Bench::new();
    bench.send(&init("s", 3, &[ring("a", header("map", 0), 1.0)]));
    bench.publish(&keep_alive("s", 4));
    assert!(bench.places().is_empty());
    bench.publish(&init("s", 4, &[ring("a", header("map", 0), 2.0)]));
    assert_eq!(bench.places(), [[2.0, 0.0, 0.0]]);
}

#[test]
fn after_a_lost_update_the_last_list_is_used_again_a_second_later() {
    let mut bench = Bench::new();
    bench.start(&[ring("a", header("map", 0), 1.0)]);
    bench.send(&init("s", 3, &[ring("a", header("map", 0), 7.0)]));
    bench.publish(&update("s", 3, |_| {}));
    assert!(bench.places().is_empty());
    let expected = "Sequence number of update is out of order. Expected: 2 Received: 3";
    assert_eq!(bench.status("s"), Some((Level::Error, expected.into())));
    assert_eq!(bench.status("a"), None);
    let next = bench.display.next_change().unwrap();
    assert!(bench.world.now < next && next.secs_since(bench.world.now) < 1.1, "{next:?}");
    bench.wait(Duration::from_millis(900));
    bench.publish(&keep_alive("s", 3));
    assert!(bench.places().is_empty());
    bench.wait(Duration::from_millis(200));
    bench.update();
    assert_eq!(bench.places(), [[7.0, 0.0, 0.0]]);
    // A keep-alive of another number than the last update's is a loss as well.
    bench.publish(&keep_alive("s", 4));
    assert!(bench.places().is_empty());
}

#[test]
fn a_silent_server_gets_a_warning_and_its_markers_are_kept() {
    let mut bench = Bench::new();
    bench.start(&[ring("a", header("map", 0), 1.0)]);
    bench.wait(Duration::from_millis(1900));
    assert_eq!(bench.status("s").unwrap().0, Level::Ok);
    for seconds in ["2", "3", "4"] {
        let next = bench.display.next_change().unwrap();
        assert!(next > bench.world.now);
        let still = !bench.wait(next.saturating_since(bench.world.now));
        assert!(still);
        assert_eq!(bench.status("s"), Some((Level::Warn, format!("No update received for {seconds} seconds."))));
    }
    bench.publish(&keep_alive("s", 1));
    assert_eq!(bench.status("s"), Some((Level::Ok, "OK".into())));
    assert_eq!(bench.places().len(), 1);
}

#[test]
fn servers_of_one_topic_are_independent() {
    let mut bench = Bench::new();
    bench.start(&[ring("a", header("map", 0), 1.0)]);
    bench.send(&init("t", 40, &[ring("a", header("map", 0), 2.0)]));
    bench.publish(&keep_alive("t", 40));
    assert_eq!(bench.places(), [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    bench.publish(&update("s", 9, |_| {}));
    assert_eq!(bench.places(), [[2.0, 0.0, 0.0]]);
    bench.publish(&init("", 1, &[]));
    assert_eq!(bench.status("General"), Some((Level::Error, "Received message with empty server_id!".into())));
}

#[test]
fn a_marker_without_a_stamp_follows_its_frame_and_one_with_a_stamp_stays() {
    let mut bench = Bench::new();
    bench.frame("cart", 10, 10.0);
    bench.frame("cart", 12, 12.0);
    bench.start(&[ring("a", header("cart", 0), 1.0), ring("b", header("cart", 11), 1.0)]);
    assert_eq!(bench.places(), [[13.0, 0.0, 0.0], [12.0, 0.0, 0.0]]);
    assert_eq!(bench.text("b"), "Position is fixed.");
    bench.frame("cart", 14, 20.0);
    assert!(bench.update());
    assert_eq!(bench.places(), [[21.0, 0.0, 0.0], [12.0, 0.0, 0.0]]);
    // A pose without a stamp lets the other follow, too.
    bench.publish(&update("s", 2, |update| update.poses = vec![pose("b", header("cart", 0), 5.0)]));
    assert_eq!(bench.places(), [[21.0, 0.0, 0.0], [25.0, 0.0, 0.0]]);
}

#[test]
fn a_list_waits_for_its_frames_and_an_update_for_its_time() {
    let mut bench = Bench::new();
    bench.start(&[ring("a", header("cart", 0), 1.0)]);
    let (level, text) = bench.status("s").unwrap();
    assert_eq!(level, Level::Warn);
    assert!(text.starts_with("Cannot get tf info for init message with sequence number 1. Error: "), "{text}");
    bench.frame("cart", 10, 10.0);
    bench.update();
    assert_eq!(bench.places().len(), 1);
    bench.send(&update("s", 2, |update| update.markers = vec![ring("b", header("cart", 12), 0.0)]));
    bench.publish(&update("s", 3, |update| update.erases = vec!["a".into()]));
    assert_eq!(bench.places().len(), 1, "the frame is not known yet at that time, and updates keep their order");
    bench.frame("cart", 14, 14.0);
    bench.update();
    assert_eq!(bench.places(), [[12.0, 0.0, 0.0]]);
    bench.publish(&update("s", 4, |update| update.markers = vec![ring("c", header("cart", 5), 0.0)]));
    assert!(bench.text("s").starts_with("Resetting due to tf error: the stamp is too old"), "{}", bench.text("s"));
    assert!(bench.places().is_empty());
}

#[test]
fn the_status_of_a_marker_whose_frame_is_lost_is_about_a_frame() {
    let mut bench = Bench::new();
    bench.frame("robot", 1, 1.0);
    bench.start(&[ring("a", header("robot", 0), 1.0)]);
    assert_eq!(bench.status("a").unwrap().0, Level::Ok);
    bench.world.tree = TransformTree::new();
    bench.update();
    let status = bench.display.statuses().get("a").unwrap();
    assert_eq!((status.level, status.cause), (Level::Error, StatusCause::Frame));
}

#[test]
fn what_is_not_finite_is_refused_by_name() {
    let mut bench = Bench::new();
    let mut bad = ring("bad", header("map", 0), 1.0);
    bad.controls[0].orientation.x = f64::NAN;
    bench.start(&[bad, ring("a", header("map", 0), f64::INFINITY), ring("good", header("map", 0), 2.0)]);
    assert_eq!(bench.places(), [[2.0, 0.0, 0.0]]);
    for name in ["bad", "a"] {
        assert_eq!(bench.status(name), Some((Level::Error, "Marker contains invalid floats!".into())));
    }
    let mut twisted = pose("good", header("map", 0), 4.0);
    twisted.pose.orientation.w = 2.0;
    bench.publish(&update("s", 2, |update| update.poses = vec![twisted, pose("good", header("map", 0), 5.0)]));
    assert_eq!(bench.places(), [[2.0, 0.0, 0.0]], "rviz passes over the poses after a bad one");
    assert_eq!(bench.status("good").unwrap().0, Level::Error);
}

#[test]
fn a_pose_for_an_unknown_marker_stops_the_display_until_a_reset() {
    let mut bench = Bench::new();
    bench.start(&[ring("a", header("map", 0), 1.0)]);
    bench.publish(&update("s", 2, |update| update.poses = vec![pose("b", header("map", 0), 1.0)]));
    assert!(bench.places().is_empty());
    assert!(bench.text("b").starts_with("Pose received for non-existing marker"), "{}", bench.text("b"));
    bench.publish(&keep_alive("s", 2));
    assert_eq!(bench.status("s"), None);
    bench.display.reset();
    bench.publish(&keep_alive("s", 1));
    assert_eq!(bench.places(), [[1.0, 0.0, 0.0]]);
}

#[test]
fn the_markers_of_a_server_that_is_gone_are_removed_and_those_of_others_come_back() {
    let mut bench = Bench::new();
    bench.start(&[ring("a", header("map", 0), 1.0)]);
    bench.send(&init("t", 40, &[ring("b", header("map", 0), 2.0)]));
    bench.publish(&keep_alive("t", 40));
    bench.display.publisher_left("/im/update_full");
    assert_eq!(bench.places().len(), 2, "only the topic of updates counts");
    bench.display.publisher_left("/im/update");
    assert!(bench.update());
    assert!(bench.places().is_empty());
    assert_eq!(bench.status("General"), Some((Level::Error, "Server is offline. Resetting.".into())));
    bench.publish(&keep_alive("t", 40));
    assert_eq!(bench.places(), [[2.0, 0.0, 0.0]]);
}

#[test]
fn the_topics_are_those_of_the_servers_namespace() {
    let topics = |topic: &str| {
        let settings = InteractiveMarkersSettings { update_topic: topic.into(), ..Default::default() };
        let bench = Bench::with(&settings);
        let topics: Vec<String> = bench.display.topics().into_iter().map(|request| request.topic).collect();
        (topics, bench.text(Statuses::TOPIC))
    };
    let expected = vec!["/im/update".to_owned(), "/im/update_full".to_owned()];
    assert_eq!(topics("/im/update"), (expected.clone(), String::new()));
    assert_eq!(topics("/im/update_full"), (expected, String::new()));
    assert_eq!(topics(""), (vec![], String::new()));
    assert_eq!(topics("/im/feedback"), (vec![], "Invalid topic name: /im/feedback".to_owned()));
}

#[test]
fn a_mesh_of_a_control_appears_when_it_is_loaded() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.stl"), STL).unwrap();
    let mut bench = Bench::new();
    let gate = bench.world.load_behind_gate(folder.path());
    let with_mesh = |name: &str, url: &str| {
        let mesh = Marker { type_: Marker::MESH_RESOURCE.into(), mesh_resource: url.into(), ..Marker::default() };
        let mut marker = ring(name, header("map", 0), 1.0);
        marker.controls[0].markers = vec![mesh];
        marker
    };
    let url = format!("file://{}/a.stl", folder.path().display());
    bench.start(&[with_mesh("a", &url), with_mesh("b", "http://x/y.stl"), ring("c", header("map", 0), 3.0)]);
    assert_eq!(bench.places(), [[3.0, 0.0, 0.0]]);
    assert_eq!(bench.status("a"), Some((Level::Ok, format!("loading [{url}]"))));
    let version = bench.world.version();
    gate.open();
    bench.world.wait_for_version(version + 2);
    assert!(bench.update());
    assert_eq!(bench.places(), [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    assert_eq!(bench.text("a"), "Locked to frame map");
    let (level, text) = bench.status("b").unwrap();
    assert!(level == Level::Error && text.contains("could not load"), "{text}");
    assert!(!bench.update(), "nothing new");
}
