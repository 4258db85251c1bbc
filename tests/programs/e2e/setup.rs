//! `camera_stream setup` beside a running robot: what it finds is taken without a terminal.

use rcs_tests::ros::{wait_until, RosMaster, PATIENCE};
use rcs_tests::ros_fixture::master_and_python;
use std::fs;
use std::path::Path;
use std::process::{Output, Stdio};

use crate::viewers::Screen;

/// A robot with a link for the projector, a camera, detections that are latched and a cloud every 0.8 s.
const ROBOT: &str = "
from sensor_msgs.msg import Image
from visualization_msgs.msg import Marker, MarkerArray
latch('/tf_static', tf('odom', 'base_link'))
rospy.set_param('/robot_description', '<robot name=\"r\"><link name=\"projector_mount\"/></robot>')
latch('/detections', MarkerArray([Marker()]))
latch('/camera/color/image_raw', Image())
latch('/camera/color/camera_info', info())
latch('/camera/depth/image_raw', Image())
clouds = PublishRepeatedly(1.25, lambda i: cloud(0xffffff), '/objects')
points = PublishRepeatedly(10, lambda i: cloud(0xffffff), '/camera/depth/points')
";

fn setup(master: &RosMaster, display: Option<&str>, folder: &Path, options: &[&str]) -> Output {
    let mut command = master.program("camera_stream");
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").envs(display.map(|display| ("DISPLAY", display)));
    command.arg("setup").arg(folder).args(options).stdin(Stdio::null()).output().unwrap()
}

#[test]
fn topics_rates_frames_and_the_monitor_are_found() {
    let (master, _python) = master_and_python(ROBOT);
    let listed = || master.output("rostopic", &["list"]).unwrap().contains("/camera/depth/points");
    assert!(wait_until(PATIENCE, listed));
    let (screen, folder) = (Screen::start(), tempfile::tempdir().unwrap());
    let folder = folder.path().join("first");
    let options = ["--profile", "mobile", "--mount", "projector_mont"];
    let output = setup(&master, Some(&screen.display), &folder, &options);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    assert!(errors.contains("did you mean projector_mount?"), "{errors}");
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let launch = read("projection.launch");
    let limits = launch.split("[{topic: /detections, limit: held}, {topic: /objects, limit: ").nth(1);
    let limit: f64 = limits.and_then(|text| text.split('}').next()).unwrap_or(&launch).parse().unwrap();
    assert!(limit > 2.0, "{launch}");
    assert!(!launch.contains("/camera/depth/points"), "{launch}");
    assert!(launch.contains("name=\"fixed_frame\" default=\"odom\""), "{launch}");
    let readme = read("README.md");
    let scan = "scan --size 640x360 --monitor screen --image /camera/color/image_raw --camera-info \
                /camera/color/camera_info --depth /camera/depth/image_raw ";
    assert!(readme.contains(scan), "{readme}");
    // The same again is refused, and replaces the files if that is wanted.
    let again = setup(&master, None, &folder, &options);
    assert_eq!(again.status.code(), Some(1));
    let printed = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(printed.contains("has files; choose another folder or give --overwrite"), "{printed}");
    let options = [&options[..], &["--size", "1280x800", "--try", "--overwrite"]].concat();
    assert!(setup(&master, None, &folder, &options).status.success());
    assert!(read("projector.yaml").contains("width: 1280"));
}
