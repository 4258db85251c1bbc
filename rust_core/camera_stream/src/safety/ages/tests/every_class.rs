//! Every display class beside a frame that stops.

use rcs_messages::geometry_msgs::{
    AccelStamped, Point, Point32, PointStamped, PolygonStamped, PoseArray, PoseStamped, PoseWithCovarianceStamped,
    TwistStamped, WrenchStamped,
};
use rcs_messages::nav_msgs::{GridCells, Odometry};
use rcs_messages::sensor_msgs::{
    FluidPressure, Illuminance, JointState, LaserScan, PointCloud, PointField, Range, RelativeHumidity, Temperature,
};
use rcs_messages::std_msgs::Header;
use rcs_messages::visualization_msgs::{
    InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerInit, InteractiveMarkerUpdate, Marker, MarkerArray,
};
use rcs_messages::{Image, OccupancyGrid, PointCloud2};

use super::*;

/// A robot whose only link that is drawn, and whose only joint, is the arm.
const ROBOT: &str =
    "<robot name='r'><link name='base'/><link name='arm'><visual><geometry><box size='1 1 1'/></geometry>\
     </visual></link><joint name='j' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/>\
     <limit effort='1' velocity='1' lower='-1' upper='1'/></joint></robot>";

/// How a class places what it shows in the frame `arm`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Placing {
    /// Once, at its message's stamp.
    Once,
    /// At the latest transform, again and again.
    Follows,
    /// Every frame by itself.
    Singly,
}
use Placing::{Follows, Once, Singly};

/// The classes, with what else a config says. Those that place in two ways are there twice, with a note.
const CLASSES: [(&str, &str, Placing); 31] = [
    ("AccelStamped", "Topic: /t", Once),
    ("Axes", "Reference Frame: arm", Follows),
    ("DepthCloud", "Depth Map Topic: /t/image", Once),
    ("Effort", "Topic: /t, Robot Description: robot", Once),
    ("FluidPressure", "Topic: /t", Once),
    ("Grid", "Reference Frame: arm", Follows),
    ("GridCells", "Topic: /t", Once),
    ("Illuminance", "Topic: /t", Once),
    ("InteractiveMarkers", "Update Topic: /t/update", Follows),
    ("LaserScan", "Topic: /t", Once),
    ("Map", "Topic: /t", Follows),
    ("Marker", "Marker Topic: /t", Once),
    ("Marker", "Marker Topic: /t, Name: locked", Follows),
    ("MarkerArray", "Marker Topic: /t", Once),
    ("MarkerArray", "Marker Topic: /t, Name: locked", Follows),
    ("Odometry", "Topic: /t", Once),
    ("Path", "Topic: /t", Once),
    ("PointCloud", "Topic: /t", Once),
    ("PointCloud2", "Topic: /t", Once),
    ("PointStamped", "Topic: /t", Once),
    ("Polygon", "Topic: /t", Once),
    ("Pose", "Topic: /t", Once),
    ("PoseArray", "Topic: /t", Once),
    ("PoseWithCovariance", "Topic: /t", Once),
    ("Range", "Topic: /t", Once),
    ("RelativeHumidity", "Topic: /t", Once),
    ("RobotModel", "Robot Description: robot", Follows),
    ("TF", "Frame Timeout: 1000", Singly),
    ("Temperature", "Topic: /t", Once),
    ("TwistStamped", "Topic: /t", Once),
    ("WrenchStamped", "Topic: /t", Once),
];

fn header(secs: u32) -> Header {
    let stamp = rcs_messages::Time { sec: secs, nsec: 0 };
    Header { stamp, frame_id: "arm".to_owned(), ..Header::default() }
}

fn pose() -> geometry_msgs::Pose {
    let mut pose = geometry_msgs::Pose::default();
    pose.orientation.w = 1.0;
    pose
}

fn up() -> geometry_msgs::Vector3 {
    geometry_msgs::Vector3 { z: 1.0, ..Default::default() }
}

fn marker(secs: u32, frame_locked: bool) -> Marker {
    let scale = geometry_msgs::Vector3 { x: 1.0, y: 1.0, z: 1.0 };
    let mut marker =
        Marker { header: header(secs), type_: Marker::CUBE.into(), pose: pose(), scale, ..Marker::default() };
    (marker.color.a, marker.frame_locked) = (1.0, frame_locked);
    marker
}

fn cloud(secs: u32) -> PointCloud2 {
    let field = |(i, name): (u32, &str)| PointField { name: name.to_owned(), offset: i * 4, datatype: 7, count: 1 };
    let mut cloud = PointCloud2::default();
    cloud.header = header(secs);
    cloud.fields = (0..).zip(["x", "y", "z"]).map(field).collect();
    (cloud.height, cloud.width, cloud.point_step, cloud.row_step) = (1, 1, 12, 12);
    cloud.with_data(vec![0; 12])
}

fn depth_image(secs: u32) -> Vec<(&'static str, AnyMessage)> {
    let mut info = CameraInfo { header: header(secs), width: 2, height: 1, ..CameraInfo::default() };
    (info.K[0], info.K[4], info.K[8]) = (2.0, 2.0, 1.0);
    info.P = [2.0, 0.0, 0.5, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let pixels = [1.0_f32, 2.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let image = Image::new(header(secs), [2, 1], "32FC1", 8, Arc::new(pixels));
    vec![("/t/camera_info", AnyMessage::CameraInfo(Arc::new(info))), ("/t/image", AnyMessage::Image(Arc::new(image)))]
}

fn interactive_marker() -> Vec<(&'static str, AnyMessage)> {
    let mut control = InteractiveMarkerControl { always_visible: true, ..Default::default() };
    control.orientation.w = 1.0;
    let mut cube = marker(0, false);
    cube.header.frame_id.clear();
    control.markers = vec![cube];
    let marker = InteractiveMarker {
        header: header(0),
        name: "handle".to_owned(),
        pose: pose(),
        scale: 1.0,
        controls: vec![control],
        ..InteractiveMarker::default()
    };
    let init = InteractiveMarkerInit { server_id: "s".to_owned(), seq_num: 1, markers: vec![marker] };
    let update = InteractiveMarkerUpdate { server_id: "s".to_owned(), seq_num: 1, ..Default::default() };
    vec![
        ("/t/update_full", AnyMessage::InteractiveMarkerInit(Arc::new(init))),
        ("/t/update", AnyMessage::InteractiveMarkerUpdate(Arc::new(update))),
    ]
}

fn map(secs: u32) -> OccupancyGrid {
    let mut map = OccupancyGrid::default();
    map.header = header(secs);
    (map.info.width, map.info.height, map.info.resolution) = (1, 1, 1.0);
    map.info.origin = pose();
    map.with_data(vec![0])
}

fn odometry(secs: u32) -> Odometry {
    let mut odometry = Odometry { header: header(secs), ..Odometry::default() };
    odometry.pose.pose = pose();
    odometry
}

fn path(secs: u32) -> Path {
    let poses = vec![PoseStamped { header: header(secs), pose: pose() }; 2];
    Path { header: header(secs), poses }
}

fn polygon(secs: u32) -> PolygonStamped {
    let mut polygon = PolygonStamped { header: header(secs), ..PolygonStamped::default() };
    polygon.polygon.points = vec![Point32::default(), Point32 { x: 1.0, ..Point32::default() }];
    polygon
}

fn with_covariance(secs: u32) -> PoseWithCovarianceStamped {
    let mut stamped = PoseWithCovarianceStamped { header: header(secs), ..PoseWithCovarianceStamped::default() };
    stamped.pose.pose = pose();
    stamped
}

/// The messages by which a display of a class shows something in the frame `arm`; without a stamp for 0.
fn messages(class: &str, placing: Placing, secs: u32) -> Vec<(&'static str, AnyMessage)> {
    match class {
        "Axes" | "Grid" | "RobotModel" | "TF" => Vec::new(),
        "DepthCloud" => depth_image(secs),
        "InteractiveMarkers" => interactive_marker(),
        _ => vec![("/t", message(class, placing, secs))],
    }
}

#[expect(clippy::needless_update, reason = "some messages have no other fields")]
fn message(class: &str, placing: Placing, secs: u32) -> AnyMessage {
    use geometry_msgs::{Accel, Twist, Wrench};
    let (header, marker) = (header(secs), marker(secs, placing == Follows));
    macro_rules! any {
        ($kind:ident { $($fields:tt)* }) => {
            AnyMessage::$kind(Arc::new($kind { $($fields)*, ..$kind::default() }))
        };
    }
    match class {
        "AccelStamped" => any!(AccelStamped { header, accel: Accel { linear: up(), ..Accel::default() } }),
        "TwistStamped" => any!(TwistStamped { header, twist: Twist { linear: up(), ..Twist::default() } }),
        "WrenchStamped" => any!(WrenchStamped { header, wrench: Wrench { force: up(), ..Wrench::default() } }),
        "Effort" => any!(JointState { header, name: vec!["j".to_owned()], position: vec![0.0], effort: vec![1.0] }),
        "FluidPressure" => any!(FluidPressure { header, fluid_pressure: 1.0 }),
        "GridCells" => any!(GridCells { header, cell_width: 1.0, cell_height: 1.0, cells: vec![Point::default()] }),
        "Illuminance" => any!(Illuminance { header, illuminance: 1.0 }),
        "LaserScan" => any!(LaserScan { header, ranges: vec![1.0, 1.0], angle_increment: 0.1, range_max: 2.0 }),
        "Map" => AnyMessage::OccupancyGrid(Arc::new(map(secs))),
        "Marker" => AnyMessage::Marker(Arc::new(marker)),
        "MarkerArray" => AnyMessage::MarkerArray(Arc::new(MarkerArray { markers: vec![marker] })),
        "Odometry" => AnyMessage::Odometry(Arc::new(odometry(secs))),
        "Path" => AnyMessage::Path(Arc::new(path(secs))),
        "PointCloud" => any!(PointCloud { header, points: vec![Point32::default()] }),
        "PointCloud2" => AnyMessage::PointCloud2(Arc::new(cloud(secs))),
        "PointStamped" => any!(PointStamped { header }),
        "Polygon" => AnyMessage::PolygonStamped(Arc::new(polygon(secs))),
        "Pose" => AnyMessage::PoseStamped(Arc::new(PoseStamped { header, pose: pose() })),
        "PoseArray" => AnyMessage::PoseArray(Arc::new(PoseArray { header, poses: vec![pose()] })),
        "PoseWithCovariance" => AnyMessage::PoseWithCovarianceStamped(Arc::new(with_covariance(secs))),
        "Range" => any!(Range { header, range: 1.0, max_range: 2.0, field_of_view: 0.1 }),
        "RelativeHumidity" => any!(RelativeHumidity { header, relative_humidity: 0.5 }),
        "Temperature" => any!(Temperature { header, temperature: 20.0 }),
        other => panic!("no message for rviz/{other}"),
    }
}

/// A display of a class beside its camera.
fn bench(class: &str, settings: &str) -> Bench {
    let config = format!(
        "
Visualization Manager:
  Global Options: {{Fixed Frame: map}}
  Displays:
  - {{Class: rviz/{class}, Enabled: true, {settings}}}
  - {{Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true, Image Topic: /image, Camera Info Topic: /info}}
"
    );
    let mut bench = Bench::of(&config, AgeLimits::general(Duration::from_secs(1)));
    let robot: Arc<str> = ROBOT.into();
    bench.scene.take_parameter("robot", Some(&robot), bench.now().ros);
    bench
}

impl Bench {
    fn send_all(&mut self, messages: Vec<(&'static str, AnyMessage)>) {
        for (topic, message) in messages {
            self.take(topic, &message);
        }
    }

    /// Whether the display shows something, and that something is current.
    fn is_lit(&mut self, secs: f64) -> bool {
        let assessment = self.wait(secs);
        let is_shown = self.scene.ages().all(|age| !age.is_empty);
        is_shown && !assessment.displays.iter().any(|display| matches!(display.state, AgeState::Stale(_)))
    }

    /// Some seconds with a transform of the arm each.
    fn go_on(&mut self, secs: u32) {
        for _ in 0..secs {
            self.secs += 1.0;
            self.place(self.secs as u32, 0.0, false);
        }
    }
}

#[test]
fn every_class_that_is_drawn_is_in_the_table() {
    use rcs_rviz_config::{classes, Role};
    let scene = classes().iter().filter(|class| class.role == Role::Scene);
    let mut in_table: Vec<&str> = CLASSES.iter().map(|(class, ..)| *class).collect();
    in_table.dedup();
    assert_eq!(in_table, scene.map(|class| class.name.trim_start_matches("rviz/")).collect::<Vec<_>>());
}

/// Messages published once and held by their publisher, as the launch files have it of a path and markers.
#[test]
fn what_follows_a_frame_goes_dark_with_it_and_what_is_placed_once_stays_while_its_message_is_held() {
    for (class, settings, placing) in CLASSES {
        for limit in ["held", "never"] {
            let mut bench = bench(class, settings);
            for topic in ["/t", "/t/image", "/t/update"] {
                bench.connected.insert(topic);
                let limit = format!("{topic}={limit}").parse().unwrap();
                bench.freshness.limits.set(limit, |topic| Ok::<_, String>(topic.to_owned())).unwrap();
            }
            bench.place(100, 0.0, false);
            bench.send_all(messages(class, placing, 100));
            assert!(bench.is_lit(0.5), "{class} {settings}");
            bench.go_on(20);
            assert!(bench.is_lit(0.5), "{class} {settings}: its frame goes on");
            assert_eq!(bench.is_lit(1.0), placing == Once, "{class} {settings}, {limit}: its frame has stopped");
            bench.go_on(1);
            assert!(bench.is_lit(0.5), "{class} {settings}: its frame is back");
        }
    }
}

/// Messages without a stamp are placed by the latest transforms, however old those are.
#[test]
fn messages_that_go_on_keep_nothing_lit_whose_frame_has_stopped() {
    for (class, settings, placing) in CLASSES.into_iter().filter(|(.., placing)| *placing != Singly) {
        let mut bench = bench(class, settings);
        bench.place(100, 0.0, false);
        for tenths in 0..=11 {
            bench.secs = 100.0 + f64::from(tenths) / 10.0;
            bench.send_all(messages(class, placing, 0));
            assert_eq!(bench.is_lit(0.0), tenths <= 10, "{class} {settings} after {tenths} tenths of a second");
        }
        bench.place(101, 0.0, false);
        bench.send_all(messages(class, placing, 0));
        assert!(bench.is_lit(0.0), "{class} {settings}: its frame is back");
    }
}

/// A frame that fell silent below one that goes on cannot be looked up any more, after the ten seconds that are
/// remembered; and what is drawn all the same is drawn where it was, or at the fixed frame's origin.
#[test]
fn what_is_drawn_without_a_place_is_dark() {
    for (class, settings, _) in CLASSES.into_iter().filter(|(.., placing)| *placing == Follows) {
        let mut bench = bench(class, settings);
        bench.latched.extend(["/t", "/t/update", "/t/update_full"]);
        bench.place_in(["odom", "arm"], 100, 0.0, false);
        bench.place_in(["map", "odom"], 100, 0.0, false);
        bench.send_all(messages(class, Follows, 100));
        assert!(bench.is_lit(0.5), "{class} {settings}");
        for secs in 101..=130 {
            bench.secs = f64::from(secs);
            bench.place_in(["odom", "arm"], secs, 0.0, false);
        }
        assert!(bench.scene.known_until("arm").is_none());
        assert!(!bench.is_lit(0.0), "{class} {settings}");
    }
    for (class, settings) in
        [("Map", "Topic: /t"), ("Grid", "Reference Frame: arm"), ("RobotModel", "Robot Description: robot")]
    {
        let mut bench = bench(class, settings);
        bench.latched.insert("/t");
        bench.send_all(messages(class, Follows, 100));
        assert!(!bench.is_lit(0.0), "{class}: its frame was never there");
        bench.place(100, 0.0, false);
        assert!(bench.is_lit(0.0), "{class}");
    }
}

/// The light along rviz's view, and a camera, may follow frames that no display follows.
#[test]
fn the_frame_of_the_view_ages_no_display() {
    let config = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz/Grid, Name: grid, Enabled: true}
  Views: {Current: {Class: rviz/Orbit, Target Frame: arm}}
";
    let mut bench = Bench::of(config, AgeLimits::general(Duration::from_secs(1)));
    bench.place(100, 0.0, false);
    assert!(bench.is_lit(5.0));
}

#[test]
fn a_map_that_stays_through_a_jump_in_time_ages_as_before() {
    let mut bench = bench("Map", "Topic: /t");
    bench.latched.insert("/t");
    bench.place(100, 0.0, true);
    bench.send_all(messages("Map", Follows, 100));
    assert!(bench.is_lit(5.0));
    bench.scene.reset();
    bench.scene.update(bench.now().ros);
    assert!(bench.is_lit(5.0), "its publisher holds it");
    bench.latched.clear();
    assert!(!bench.is_lit(1.1), "its publisher is gone");
}

/// The planned path and the markers of the launch files, which are sent when they change and not again.
#[test]
fn the_launch_files_keep_their_path_and_markers_while_these_are_held_and_their_frames_go_on() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for name in ["projection", "fetch"] {
        let launch = std::fs::read_to_string(folder.join(format!("launch/{name}.launch"))).unwrap();
        let (_, after) = launch.split_once("<arg name=\"stale_timeouts\" default=\"").unwrap();
        let mut limits = AgeLimits::general(Duration::from_secs(1));
        for limit in after.split('"').next().unwrap().split("{topic: ").skip(1) {
            let limit = limit.split('}').next().unwrap().replace(", limit: ", "=");
            limits.set(limit.parse().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
        }
        let config = std::fs::read_to_string(folder.join(format!("rviz/{name}.rviz"))).unwrap();
        let mut bench = Bench::of(&config, limits);
        let fixed = rcs_rviz_config::parse(&config, name).unwrap().global.fixed_frame;
        let drive = |bench: &mut Bench, secs: u32| {
            bench.secs = f64::from(secs);
            bench.place_in([&fixed, "arm"], secs, f64::from(secs), false);
        };
        drive(&mut bench, 100);
        bench.connected.extend(["/move_base/NavfnROS/plan", "/visualization_marker_array"]);
        bench.take("/move_base/NavfnROS/plan", &AnyMessage::Path(Arc::new(path(100))));
        let markers = MarkerArray { markers: vec![marker(0, true)] };
        bench.take("/visualization_marker_array", &AnyMessage::MarkerArray(Arc::new(markers)));
        let stale = |bench: &mut Bench, secs: f64| {
            let displays = bench.wait(secs).displays.into_iter();
            let shown = displays.filter(|display| ["path", "markers"].iter().any(|name| display.path.ends_with(name)));
            let states: Vec<AgeState> = shown.map(|display| display.state).collect();
            assert!(states.len() == 2 && !states.contains(&AgeState::Undated), "{name}: {states:?}");
            states.iter().filter(|state| matches!(state, AgeState::Stale(_))).count()
        };
        for secs in 101..=130 {
            drive(&mut bench, secs);
        }
        assert_eq!(stale(&mut bench, 0.9), 0, "{name}");
        assert_eq!(stale(&mut bench, 0.2), 1, "{name}: the markers follow the frame that stopped, the path does not");
        bench.connected.clear();
        assert_eq!(stale(&mut bench, 0.1), 2, "{name}: their publishers are gone");
    }
}
