//! Publishing images.

use crate::probe;
use rcs_tests::ros::RosMaster;
use std::time::Duration;

#[test]
fn rospy_receives_image_and_camera_info_with_the_same_header() {
    let master = RosMaster::start().unwrap();
    let publisher = probe(&master, &["image", "/view/image", "64", "48", "10"]);
    let ready = publisher.line_with("ready").unwrap();
    assert_eq!(ready, "ready /probe image /view/image info /view/camera_info");
    let script = "import rospy, message_filters\n\
                  from sensor_msgs.msg import Image, CameraInfo\n\
                  rospy.init_node('viewer')\n\
                  def both(image, info):\n\
                  \x20   print('pair', image.header == info.header, image.header.frame_id, image.width, image.height,\n\
                  \x20         image.encoding, image.step, len(image.data), info.width, flush=True)\n\
                  subs = [message_filters.Subscriber('/view/image', Image),\n\
                  \x20       message_filters.Subscriber('/view/camera_info', CameraInfo)]\n\
                  message_filters.TimeSynchronizer(subs, 20).registerCallback(both)\n\
                  rospy.spin()\n";
    let viewer = rcs_tests::ros::Running::start(master.command("python3").args(["-c", script])).unwrap();
    let line = viewer.line_with("pair").unwrap_or_else(|| panic!("{:?}", viewer.errors()));
    assert_eq!(line, "pair True projector 64 48 rgb8 192 9216 64");
    assert!(publisher.line_with("subscriber /viewer").is_some());
    assert!(publisher.line_with("to 1 in").is_some());
    // It subscribes to the very topic that its camera_info is published on.
    assert_eq!(publisher.count("message"), 0);
}

#[test]
fn a_terminated_publisher_is_unregistered() {
    let master = RosMaster::start().unwrap();
    let mut publisher = probe(&master, &["image", "/view/image", "64", "48", "10"]);
    assert!(publisher.line_with("published").is_some());
    assert!(master.output("rostopic", &["list"]).unwrap().contains("/view/image"));
    publisher.signal("TERM");
    assert!(publisher.wait(Duration::from_secs(5)).unwrap().success());
    let topics = master.output("rostopic", &["list"]).unwrap();
    assert!(topics.contains("/rosout") && !topics.contains("/view"), "{topics}");
    assert!(!master.output("rosnode", &["list"]).unwrap().contains("/probe"));
}
