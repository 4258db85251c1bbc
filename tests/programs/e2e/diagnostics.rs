//! `/diagnostics` as a Python subscriber receives it, and the log beside it.

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};
fn monitored(displays: &[&str], args: &[&str], topic: &str) -> RosFixture {
    let fixture = Setup::of(displays).args(args).start();
    fixture.python(format!("monitor('{topic}')"));
    fixture
}

#[test]
fn a_camera_info_that_a_projection_does_not_fit_is_a_warning() {
    let fixture = monitored(&[CLOUD], &[], "/diagnostics");
    fixture.python("latch('/tf_static', tf('map', 'eye')); viewer = Viewer('/view/image')");
    fixture.python("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000))");
    fixture.wait_for("level('camera_stream: CameraPub') == 0");
    fixture.python("latch('/eye/camera_info', info(P=[50, 0, 32, 0, 0, 40, 24, 0, 0, 0, 1, 0]))");
    fixture.wait_for(
        "level('camera_stream: CameraPub') == 1 and 'differ by 20.00 %' in message('camera_stream: CameraPub')",
    );
    fixture.python("latch('/eye/camera_info', info(D=[0.1, 0, 0, 0, 0], distortion_model='plumb_bob'))");
    fixture.wait_for("'D is not zero (plumb_bob)' in message('camera_stream: CameraPub')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    fixture.python("latch('/eye/camera_info', info())");
    fixture.wait_for("level('camera_stream: CameraPub') == 0");
}

#[test]
fn displays_and_cameras_report_what_is_missing_and_then_ok() {
    let disabled = "{Class: rviz/Grid, Name: hidden, Enabled: false}";
    let group =
        "{Class: rviz/Group, Name: paths, Enabled: true, Displays: [{Class: rviz/Path, Name: empty, Enabled: true, \
                 Topic: ''}]}";
    let fixture = monitored(&[CLOUD, disabled, group], &[], "/diagnostics");
    fixture.wait_for("'No publishers on [/cloud]' in message('camera_stream: cloud')");
    assert_eq!(fixture.python("values('camera_stream: cloud')['Topic']"), "Warn: No messages received");
    let names = "['camera_stream: Global Status', 'camera_stream: cloud', 'camera_stream: paths / empty', \
                 'camera_stream: CameraPub']";
    assert_eq!(fixture.python(format!("arrays[-1][2] == {names}")), "True", "{}", fixture.python("arrays[-1]"));
    let levels =
        "[level('camera_stream: ' + name) for name in ('Global Status', 'cloud', 'paths / empty', 'CameraPub')]";
    assert_eq!(fixture.python(levels), "[1, 1, 2, 1]", "{}", fixture.python("known"));
    assert_eq!(fixture.python("message('camera_stream: Global Status')"), "Fixed Frame: No TF data");
    assert_eq!(fixture.python("message('camera_stream: paths / empty')"), "Topic: Error subscribing: Empty topic name");
    assert!(fixture.python("values('camera_stream: CameraPub')['Camera Info']").contains("/eye/camera_info"));

    fixture.python("show()");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    fixture
        .wait_for("[level('camera_stream: ' + name) for name in ('Global Status', 'cloud', 'CameraPub')] == [0, 0, 0]");
    assert_eq!(fixture.python("message('camera_stream: cloud')"), "OK");
    assert_eq!(fixture.python("values('camera_stream: cloud')['Topic']"), "1 messages received");
    assert_eq!(fixture.python("values('camera_stream: cloud')['class']"), "rviz/PointCloud2");
    let camera = "[values('camera_stream: CameraPub')[key] for key in ('image topic', 'size', 'subscribers')]";
    assert_eq!(fixture.python(camera), "['/view/image', '64x48', '1']", "{}", fixture.python("known"));
    // An unchanged image is published again without being rendered again.
    let frames = |what: &str| format!("int(values('camera_stream: CameraPub')['frames {what}'])");
    fixture.wait_for(format!("{} > 20 and 1 <= {} <= 3", frames("published"), frames("drawn")));
    assert!(fixture.python("known['camera_stream: cloud'][2]").contains("rviz_camera_stream"));

    // The rate, from when the monitor is connected.
    fixture.python("del arrays[:]");
    fixture.wait_for("len(arrays) >= 4");
    assert_eq!(fixture.python("2.0 < arrays[3][1] - arrays[0][1]"), "True", "{}", fixture.python("arrays"));
    assert_eq!(fixture.python("arrays[3][1] <= arrays[3][0]"), "True", "{}", fixture.python("arrays"));
}

#[test]
fn a_missing_frame_is_reported_as_by_rviz_and_its_arrival_is_logged() {
    let fixture = monitored(&[CLOUD], &[], "/diagnostics");
    fixture.python("latch('/tf_static', tf('map', 'eye')); latch('/cloud', cloud(0xff0000, 'lost'))");
    fixture.wait_for("message('camera_stream: cloud') == 'Transform: For frame [lost]: Frame [lost] does not exist'");
    assert_eq!(fixture.python("level('camera_stream: cloud')"), "1");
    let warnings = || fixture.log_lines(&["WARN", "display cloud: Transform", "[lost]"]);
    assert!(wait_until(PATIENCE, || warnings() == 1), "{}", fixture.log());
    fixture.python("latch('/tf_static', TFMessage(tf('map', 'eye').transforms + tf('map', 'lost').transforms))");
    fixture.wait_for("level('camera_stream: cloud') == 0");
    let ended = || fixture.log_lines(&["INFO", "display cloud: Transform: ok again"]);
    assert!(wait_until(PATIENCE, || ended() == 1), "{}", fixture.log());
    assert_eq!(warnings(), 1, "{}", fixture.log());
}

#[test]
fn a_publisher_of_another_type_is_named_and_the_diagnostics_topic_can_be_remapped() {
    let fixture = monitored(&[CLOUD], &["/diagnostics:=/robot/health", "__name:=eyes"], "/robot/health");
    fixture.python("latch('/cloud', info())");
    fixture.wait_for("level('eyes: cloud') == 2");
    let text = fixture.python("message('eyes: cloud')");
    for part in ["Publisher", "[/cloud]", "sensor_msgs/CameraInfo", "/python_node", "sensor_msgs/PointCloud2"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(wait_until(PATIENCE, || fixture.log_lines(&["display cloud: Publisher"]) == 1), "{}", fixture.log());
}

#[test]
fn a_display_that_is_hidden_or_out_of_view_is_reported() {
    let grid = "{Class: rviz/Grid, Name: grid, Enabled: true}";
    // The camera looks along z from the frame's origin.
    let behind = "{Class: rviz/Grid, Name: behind, Enabled: true, Offset: {X: 0, Y: 0, Z: -5}, Reference Frame: eye}";
    let scene = config(&[grid, behind], &[CameraPub::default()]);
    let scene = scene.replace("Visibility: {Value: true}", "Visibility: {Value: true, grid: false}");
    let fixture = Setup::with_config(scene).start();
    fixture.python("monitor()");
    let visibility = |display| format!("values('camera_stream: {display}').get('Visibility')");
    fixture.wait_for(format!("{} == 'hidden in camera CameraPub'", visibility("grid")));
    assert_eq!(fixture.python(visibility("behind")), "None", "without a CameraInfo no view is known");
    fixture.python("place_camera()");
    fixture.wait_for(format!("{} == 'Warn: outside the view of camera CameraPub'", visibility("behind")));
    let levels = "[level('camera_stream: ' + name) for name in ('grid', 'behind')]";
    assert_eq!(fixture.python(levels), "[0, 1]", "{}", fixture.python("known"));
    assert_eq!(fixture.python(visibility("grid")), "hidden in camera CameraPub");
}

#[test]
fn diagnostics_are_published_once_a_second_while_simulated_time_stands_still() {
    let fixture = Setup::of(&[CLOUD]).simulated_time().start();
    fixture.python("monitor()");
    fixture.wait_for("len(arrays) >= 3");
    assert_eq!(fixture.python("arrays[-1][1]"), "0.0");
    fixture.wait_for("'/clock' in values('camera_stream: Global Status').get('Time', '')");
    fixture.python("from rosgraph_msgs.msg import Clock");
    fixture.python("latch('/clock', Clock(rospy.Time(77))); latch('/tf_static', tf('map', 'eye'))");
    fixture.wait_for("arrays[-1][1] == 77.0 and level('camera_stream: Global Status') == 0");
    let before = fixture.python("len(arrays)");
    fixture.wait_for(format!("len(arrays) >= {before} + 2 and arrays[-1][1] == 77.0"));
}
