//! Publishing images.

use crate::{probe, PEER};
use rcs_tests::ros::{RosMaster, Running};

#[test]
fn rospy_receives_image_and_camera_info_with_the_same_header() {
    let master = RosMaster::start().unwrap();
    let publisher = probe(&master, &["image", "/view/image", "64", "48", "10"]);
    let ready = publisher.line_with("ready").unwrap();
    assert_eq!(ready, "ready /probe image /view/image info /view/camera_info");
    let viewer = Running::start(master.command("python3").args([PEER, "pair"])).unwrap();
    let line = viewer.line_with("pair").unwrap_or_else(|| panic!("{:?}", viewer.errors()));
    assert_eq!(line, "pair True projector 64 48 rgb8 192 9216 64");
    assert!(publisher.line_with("subscriber /viewer").is_some());
    assert!(publisher.line_with("to 1 in").is_some());
    // It subscribes to the very topic that its camera_info is published on.
    assert_eq!(publisher.count("message"), 0);
}
