//! Tests of stale data.

use std::collections::HashSet;
use std::sync::Arc;

use rcs_messages::nav_msgs::Path;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{geometry_msgs, AnyMessage};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::Publishing;

use super::*;

mod every_class;

const CONFIG: &str = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz/Grid, Name: grid, Enabled: true}
  - {Class: rviz/Path, Name: path, Enabled: true, Topic: /path}
  - {Class: rviz/Path, Name: plan, Enabled: true, Topic: /plan}
  - {Class: rviz/Axes, Name: axes, Enabled: true, Reference Frame: arm}
  - {Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true, Image Topic: /image, Camera Info Topic: /info,
     Visibility: {Value: true, axes: false}}
";

/// A scene, a clock, and the topics with publishers.
struct Bench {
    scene: SceneState,
    freshness: Freshness,
    start: Instant,
    secs: f64,
    connected: HashSet<&'static str>,
    latched: HashSet<&'static str>,
}

impl Bench {
    /// At 100 s, with a limit of a second.
    fn new() -> Self {
        Self::with(AgeLimits::general(Duration::from_secs(1)))
    }

    fn with(limits: AgeLimits) -> Self {
        Self::of(CONFIG, limits)
    }

    fn of(config: &str, limits: AgeLimits) -> Self {
        let config = rcs_rviz_config::parse(config, "test").unwrap();
        let mut scene = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])));
        let info = CameraInfo { width: 64, height: 48, ..CameraInfo::default() };
        let mut bench = Self {
            freshness: Freshness::new(limits).unwrap(),
            start: Instant::now(),
            secs: 100.0,
            connected: HashSet::new(),
            latched: HashSet::from(["/info"]),
            scene: {
                scene.update(Time::ZERO);
                scene
            },
        };
        bench.take("/info", &AnyMessage::CameraInfo(Arc::new(info)));
        bench
    }

    fn now(&self) -> Now {
        let steady = self.start + Duration::from_secs_f64(self.secs - 100.0);
        Now { ros: Time::from_secs_f64(self.secs), steady, resumed: None }
    }

    fn take(&mut self, topic: &str, message: &AnyMessage) {
        let now = self.now();
        self.scene.take_received(topic, message, Some(now.steady), now.ros);
        self.scene.update(now.ros);
    }

    /// A path of this stamp in this frame.
    fn send(&mut self, topic: &str, stamp_secs: u32, frame: &str) {
        let mut path = Path::default();
        path.header.frame_id = frame.to_owned();
        path.header.stamp.sec = stamp_secs;
        path.poses.resize_with(2, geometry_msgs::PoseStamped::default);
        path.poses[1].pose.position.x = 1.0;
        self.take(topic, &AnyMessage::Path(Arc::new(path)));
    }

    /// Places the arm.
    fn place(&mut self, stamp_secs: u32, x: f64, is_static: bool) {
        self.place_in(["map", "arm"], stamp_secs, x, is_static);
    }

    /// Places a frame in its parent.
    fn place_in(&mut self, [parent, child]: [&str; 2], stamp_secs: u32, x: f64, is_static: bool) {
        let mut transform = geometry_msgs::TransformStamped::default();
        (transform.header.frame_id, transform.child_frame_id) = (parent.to_owned(), child.to_owned());
        transform.header.stamp.sec = stamp_secs;
        (transform.transform.translation.x, transform.transform.rotation.w) = (x, 1.0);
        self.scene.take_transforms(&TFMessage { transforms: vec![transform] }, is_static, "/a");
        let now = self.now();
        if !is_static {
            self.freshness.note_transforms(now.steady);
        }
        self.scene.update(now.ros);
    }

    fn wait(&mut self, secs: f64) -> Assessment {
        self.secs += secs;
        let (connected, latched, now) = (&self.connected, &self.latched, self.now());
        let source = |topic: &str, _: MessageKind| {
            let is_latched = latched.contains(topic);
            let is_connected = is_latched || connected.contains(topic);
            let publishing = Publishing { is_connected, is_latched };
            Some(TopicSource { topic: topic.to_owned(), publishing })
        };
        self.freshness.assess(&self.scene, source, now)
    }

    /// What the camera shows after some seconds: the hidden displays, and why it is black.
    fn shown(&mut self, secs: f64) -> (Vec<DisplayId>, Option<String>) {
        let assessment = self.wait(secs);
        let shown = assessment.of_camera(&self.scene.cameras()[0]);
        let why = [shown.camera, shown.displays].into_iter().find_map(|condition| match condition {
            Condition::Dark(why) => Some(why),
            Condition::Until(_) | Condition::Always => None,
        });
        (shown.hidden, why)
    }
}

const NOTHING_HIDDEN: (Vec<DisplayId>, Option<String>) = (Vec::new(), None);

#[test]
fn a_display_whose_data_are_too_old_is_hidden_and_without_any_other_the_image_is_black() {
    let mut bench = Bench::new();
    assert_eq!(bench.shown(5.0), NOTHING_HIDDEN, "a grid has no data");
    bench.send("/path", 105, "map");
    bench.send("/plan", 105, "map");
    assert_eq!(bench.shown(0.9), NOTHING_HIDDEN);
    bench.send("/plan", 105, "map");
    assert_eq!(bench.shown(0.2), (vec![1, 2], Some(why("path", "/path") + "; " + &why("plan", "/plan"))), "by stamps");
    bench.send("/plan", 106, "map");
    assert_eq!(bench.shown(0.5), (vec![1], None), "the other is current");
    bench.send("/path", 106, "map");
    assert_eq!(bench.shown(0.1), NOTHING_HIDDEN, "it is back at once");
}

fn why(display: &str, topic: &str) -> String {
    format!("{display}: no data on {topic} of the last 1 s")
}

#[test]
fn data_without_a_stamp_or_of_the_future_age_from_when_they_were_received() {
    for stamp_secs in [0, 4000] {
        let mut bench = Bench::new();
        bench.send("/path", stamp_secs, "map");
        assert_eq!(bench.shown(0.9), NOTHING_HIDDEN);
        assert_eq!(bench.shown(0.2), (vec![1], Some(why("path", "/path"))));
    }
}

#[test]
fn what_a_latching_publisher_sent_does_not_age_while_it_is_connected() {
    let mut bench = Bench::new();
    bench.latched.insert("/path");
    bench.send("/path", 50, "map");
    assert_eq!(bench.shown(1000.0), NOTHING_HIDDEN);
    bench.latched.remove("/path");
    assert_eq!(bench.shown(0.9), NOTHING_HIDDEN, "it ages from then on");
    assert_eq!(bench.shown(0.2), (vec![1], Some(why("path", "/path"))));
    bench.latched.insert("/path");
    assert_eq!(bench.shown(0.0), NOTHING_HIDDEN);
}

#[test]
fn a_topic_may_have_a_limit_of_its_own() {
    let mut limits = AgeLimits::general(Duration::from_secs(1));
    let set = |limits: &mut AgeLimits, text: &str| {
        limits.set(text.parse().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
    };
    set(&mut limits, "/path=never");
    set(&mut limits, "/plan=held");
    let mut bench = Bench::with(limits.clone());
    bench.send("/path", 100, "map");
    bench.send("/plan", 100, "map");
    bench.connected.insert("/plan");
    assert_eq!(bench.shown(60.0), NOTHING_HIDDEN);
    bench.connected.clear();
    assert_eq!(bench.shown(0.1), (vec![2], None));
    set(&mut limits, "/path=5");
    let mut bench = Bench::with(limits);
    bench.latched.insert("/path");
    bench.send("/path", 100, "map");
    assert_eq!(bench.shown(4.9), NOTHING_HIDDEN);
    assert_eq!(bench.shown(0.2).0, [1], "latched or not");
}

#[test]
fn a_message_that_waits_for_its_frame_does_not_make_a_display_current() {
    let mut bench = Bench::new();
    bench.send("/path", 100, "map");
    for _ in 0..30 {
        bench.secs += 0.1;
        bench.send("/path", bench.secs as u32, "nowhere");
    }
    assert_eq!(bench.shown(0.0).0, [1]);
}

#[test]
fn a_cameras_frame_and_camera_info_age_and_static_frames_do_not() {
    let mut bench = Bench::new();
    let info = CameraInfo {
        header: rcs_messages::std_msgs::Header { frame_id: "arm".to_owned(), ..Default::default() },
        ..CameraInfo::default()
    };
    bench.take("/info", &AnyMessage::CameraInfo(Arc::new(info.clone())));
    bench.place(100, 1.0, false);
    assert_eq!(bench.shown(0.9), NOTHING_HIDDEN);
    let old = Some("arm: no transform of the last 1 s".to_owned());
    assert_eq!(bench.shown(0.2), (Vec::new(), old.clone()));
    bench.place(101, 1.0, false);
    assert_eq!(bench.shown(0.1), NOTHING_HIDDEN);
    // Of the future: it ages by the computer's clock.
    bench.place(4000, 1.0, false);
    assert_eq!(bench.shown(0.0), NOTHING_HIDDEN);
    assert_eq!(bench.shown(1.1), (Vec::new(), old));
    let mut bench = Bench::new();
    bench.take("/info", &AnyMessage::CameraInfo(Arc::new(info)));
    bench.place(1, 1.0, true);
    assert_eq!(bench.shown(1000.0), NOTHING_HIDDEN);
    bench.latched.clear();
    assert_eq!(bench.shown(1.1), (Vec::new(), Some(why("CameraInfo", "/info"))), "its publisher is gone");
}

#[test]
fn a_display_that_follows_a_frame_is_as_old_as_the_frame() {
    let mut bench = Bench::new();
    bench.place(100, 1.0, false);
    let is_stale = |assessment: &Assessment| {
        assessment.displays.iter().any(|display| display.path == "axes" && matches!(display.state, AgeState::Stale(_)))
    };
    assert!(!is_stale(&bench.wait(0.9)));
    assert!(is_stale(&bench.wait(0.2)));
    assert_eq!(bench.shown(0.0), NOTHING_HIDDEN, "a camera that does not show it does not mind");
}

#[test]
fn frames_themselves_are_as_old_as_the_last_transforms_that_moved() {
    let config = CONFIG.replace("rviz/Axes, Name: axes", "rviz/TF, Name: axes").replace("axes: false", "axes: true");
    let mut bench = Bench::of(&config, AgeLimits::general(Duration::from_secs(1)));
    bench.place(100, 1.0, false);
    bench.freshness.note_transforms(bench.now().steady);
    assert_eq!(bench.shown(0.9), NOTHING_HIDDEN);
    let why = "transforms: no transform of the last 1 s".to_owned();
    assert_eq!(bench.shown(0.2), (vec![3], Some(why)));
    bench.freshness.note_transforms(bench.now().steady);
    assert_eq!(bench.shown(0.9), NOTHING_HIDDEN);
}

#[test]
fn it_is_known_when_the_next_thing_becomes_stale() {
    let mut bench = Bench::new();
    assert_eq!(bench.wait(1.0).next_change(), None);
    bench.send("/path", 101, "map");
    let now = bench.now().steady;
    assert_eq!(bench.wait(0.25).next_change(), Some(now + Duration::from_secs(1)));
    assert_eq!(bench.wait(1.0).next_change(), None, "it is stale already");
}
