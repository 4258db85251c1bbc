//! `/diagnostics` as a Python subscriber receives it, and the log beside it.

use rcs_tests::puppet::Puppet;
use rcs_tests::ros::{wait_until, RosMaster, PATIENCE};
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};

/// Subscribes to a topic and keeps arrivals, stamps and the last status of each name as (level, message, hardware,
/// values).
pub(crate) const MONITOR: &str = "
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
arrays, known = [], {}
def note(array):
    arrays.append((time.time(), array.header.stamp.to_sec(), [status.name for status in array.status]))
    for status in array.status:
        values = {value.key: value.value for value in status.values}
        known[status.name] = (ord(status.level) if isinstance(status.level, bytes) else status.level, status.message, status.hardware_id, values)
monitor = rospy.Subscriber(topic, DiagnosticArray, note)
def level(name): return known[name][0] if name in known else None
def message(name): return known[name][1] if name in known else None
def values(name): return known[name][3] if name in known else {}
";

fn monitored(displays: &[&str], args: &[&str], topic: &str) -> Stand {
    let stand = Stand::start(&config(displays, &[CameraPub::default()]), args).unwrap();
    stand.puppet(format!("topic = '{topic}'"));
    stand.puppet(MONITOR);
    stand
}

#[test]
fn displays_and_cameras_report_what_is_missing_and_then_ok() {
    let disabled = "{Class: rviz/Grid, Name: hidden, Enabled: false}";
    let group =
        "{Class: rviz/Group, Name: paths, Enabled: true, Displays: [{Class: rviz/Path, Name: empty, Enabled: true, \
                 Topic: ''}]}";
    let stand = monitored(&[CLOUD, disabled, group], &[], "/diagnostics");
    stand.wait_for("message('camera_stream: cloud') == 'Topic: No messages received'");
    let names = "['camera_stream: Global Status', 'camera_stream: cloud', 'camera_stream: paths / empty', \
                 'camera_stream: CameraPub']";
    assert_eq!(stand.puppet(format!("arrays[-1][2] == {names}")), "True", "{}", stand.puppet("arrays[-1]"));
    let levels =
        "[level('camera_stream: ' + name) for name in ('Global Status', 'cloud', 'paths / empty', 'CameraPub')]";
    assert_eq!(stand.puppet(levels), "[1, 1, 2, 1]", "{}", stand.puppet("known"));
    assert_eq!(stand.puppet("message('camera_stream: Global Status')"), "Fixed Frame: No TF data");
    assert_eq!(stand.puppet("message('camera_stream: paths / empty')"), "Topic: Error subscribing: Empty topic name");
    stand.wait_for("'/cloud' in values('camera_stream: cloud').get('Publisher', '')");
    assert!(stand.puppet("values('camera_stream: CameraPub')['Camera Info']").contains("/eye/camera_info"));

    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000)); eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    stand
        .wait_for("[level('camera_stream: ' + name) for name in ('Global Status', 'cloud', 'CameraPub')] == [0, 0, 0]");
    assert_eq!(stand.puppet("message('camera_stream: cloud')"), "OK");
    assert_eq!(stand.puppet("values('camera_stream: cloud')['Topic']"), "1 messages received");
    assert_eq!(stand.puppet("values('camera_stream: cloud')['class']"), "rviz/PointCloud2");
    let camera = "[values('camera_stream: CameraPub')[key] for key in ('image topic', 'size', 'subscribers')]";
    assert_eq!(stand.puppet(camera), "['/view/image', '64x48', '1']", "{}", stand.puppet("known"));
    // An unchanged picture is published again without being rendered again.
    let frames = |what: &str| format!("int(values('camera_stream: CameraPub')['frames {what}'])");
    stand.wait_for(format!("{} > 20 and 1 <= {} <= 3", frames("published"), frames("drawn")));
    assert!(stand.puppet("known['camera_stream: cloud'][2]").contains("rviz_camera_stream"));

    // The rate, from when the monitor is connected.
    stand.puppet("del arrays[:]");
    stand.wait_for("len(arrays) >= 4");
    assert_eq!(stand.puppet("2.0 < arrays[3][0] - arrays[0][0] < 5.0"), "True", "{}", stand.puppet("arrays"));
    assert_eq!(stand.puppet("abs(arrays[3][1] - arrays[3][0]) < 1.0"), "True", "{}", stand.puppet("arrays"));
}

#[test]
fn a_missing_frame_is_reported_as_by_rviz_and_its_arrival_is_logged() {
    let stand = monitored(&[CLOUD], &[], "/diagnostics");
    stand.puppet("latch('/tf_static', tf('map', 'eye')); latch('/cloud', cloud(0xff0000, 'lost'))");
    stand.wait_for("message('camera_stream: cloud') == 'Transform: For frame [lost]: Frame [lost] does not exist'");
    assert_eq!(stand.puppet("level('camera_stream: cloud')"), "1");
    let said = || stand.log_lines(&["WARN", "display cloud: Transform", "[lost]"]);
    assert!(wait_until(PATIENCE, || said() == 1), "{}", stand.log());
    stand.puppet("latch('/tf_static', TFMessage(tf('map', 'eye').transforms + tf('map', 'lost').transforms))");
    stand.wait_for("level('camera_stream: cloud') == 0");
    let ended = || stand.log_lines(&["INFO", "display cloud: Transform: ok again"]);
    assert!(wait_until(PATIENCE, || ended() == 1), "{}", stand.log());
    assert_eq!(said(), 1, "{}", stand.log());
}

#[test]
fn a_publisher_of_another_type_is_named_and_the_diagnostics_topic_can_be_remapped() {
    let stand = monitored(&[CLOUD], &["/diagnostics:=/robot/health", "__name:=eyes"], "/robot/health");
    stand.puppet("latch('/cloud', info())");
    stand.wait_for("level('eyes: cloud') == 2");
    let text = stand.puppet("message('eyes: cloud')");
    for part in ["Publisher", "[/cloud]", "sensor_msgs/CameraInfo", "/puppet", "sensor_msgs/PointCloud2"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(wait_until(PATIENCE, || stand.log_lines(&["display cloud: Publisher"]) == 1), "{}", stand.log());
}

#[test]
fn diagnostics_are_published_once_a_second_while_simulated_time_stands_still() {
    let master = RosMaster::start().unwrap();
    master.output("rosparam", &["set", "/use_sim_time", "true"]).unwrap();
    let puppet = Puppet::start(&master, &[]).unwrap();
    let stand = Stand::with(master, puppet, &config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    stand.wait_for_log("drawing ").unwrap();
    stand.puppet("topic = '/diagnostics'");
    stand.puppet(MONITOR);
    stand.wait_for("len(arrays) >= 3");
    assert_eq!(stand.puppet("arrays[-1][1]"), "0.0");
    stand.wait_for("'/clock' in values('camera_stream: Global Status').get('Time', '')");
    stand.puppet("from rosgraph_msgs.msg import Clock");
    stand.puppet("latch('/clock', Clock(rospy.Time(77))); latch('/tf_static', tf('map', 'eye'))");
    stand.wait_for("arrays[-1][1] == 77.0 and level('camera_stream: Global Status') == 0");
    let before = stand.puppet("len(arrays)");
    stand.wait_for(format!("len(arrays) >= {before} + 2 and arrays[-1][1] == 77.0"));
}
