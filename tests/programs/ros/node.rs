//! Start, shutdown, names, subscriptions and services of a node.

use crate::probe;
use rcs_tests::ros::{RosMaster, Running};

const POINT: &str = "geometry_msgs/PointStamped";

/// Publishes points until it is dropped.
fn publish_points(master: &RosMaster, topic: &str, frame: &str) -> Running {
    let message = format!("{{header: {{frame_id: {frame}}}}}");
    Running::start(master.command("rostopic").args(["pub", "-r", "20", topic, POINT, &message])).unwrap()
}

#[test]
fn names_are_remapped_and_a_dead_publisher_is_replaced() {
    let master = RosMaster::start().unwrap();
    // The topic is named absolutely, as in a config, and remapped by a relative rule.
    let probe = probe(&master, &["listen", "/cloud", POINT, "1", "cloud:=/other", "__name:=eye", "_rate:=30"]);
    assert_eq!(probe.line_with("subscribed").as_deref(), Some("subscribed /other"));
    assert_eq!(probe.line_with("ready").as_deref(), Some("ready /eye simulated false"));
    assert_eq!(master.output("rosparam", &["get", "/eye/rate"]).unwrap().trim(), "30");
    let first = publish_points(&master, "/other", "first");
    let line = probe.line_with("frame first").unwrap();
    assert!(line.starts_with("message /other geometry_msgs/PointStamped from /rostopic_"), "{line}");
    // Killed, so that it does not unregister.
    drop(first);
    let _second = publish_points(&master, "/other", "second");
    assert!(probe.line_with("frame second").is_some());
}

#[test]
fn transforms_carry_their_publishers_name_and_the_service_answers() {
    let master = RosMaster::start().unwrap();
    let probe = probe(&master, &["listen", "__ns:=robot"]);
    assert_eq!(probe.line_with("ready").as_deref(), Some("ready /robot/probe simulated false"));
    let transform = "{transforms: [{header: {frame_id: map}, child_frame_id: odom}]}";
    let _moving = Running::start(master.command("rostopic").args([
        "pub",
        "-r",
        "5",
        "/tf",
        "tf2_msgs/TFMessage",
        transform,
        "__name:=mover",
    ]));
    let transform = "{transforms: [{header: {frame_id: odom}, child_frame_id: base}]}";
    let _standing =
        Running::start(master.command("rostopic").args(["pub", "-l", "/tf_static", "tf2_msgs/TFMessage", transform]));
    let line = probe.line_with("transform map odom static false from /").unwrap();
    assert!(!line.ends_with("from /"), "{line}");
    assert!(probe.line_with("transform odom base static true from /rostopic_").is_some());
    let printed = master.output("rosservice", &["call", "/robot/probe_trigger", "{}"]).unwrap();
    assert!(printed.contains("success: True") && printed.contains("received by /robot/probe"), "{printed}");
    let printed = master.output("rosservice", &["call", "/robot/probe_switch", "true"]).unwrap();
    assert!(printed.contains("success: True"), "{printed}");
    assert!(probe.line_with("set /robot/probe_switch true by /rosservice").is_some());
}

#[test]
fn simulated_time_is_followed_and_a_jump_back_is_reported() {
    let master = RosMaster::start().unwrap();
    assert!(master.output("rosparam", &["set", "/use_sim_time", "true"]).is_ok());
    let probe = probe(&master, &["listen"]);
    assert_eq!(probe.line_with("ready").as_deref(), Some("ready /probe simulated true"));
    // Each sends for three seconds.
    master.output("rostopic", &["pub", "-1", "/clock", "rosgraph_msgs/Clock", "{clock: {secs: 500}}"]).unwrap();
    master.output("rosservice", &["call", "/probe_trigger", "{}"]).unwrap();
    assert!(probe.line_with("trigger /probe_trigger at 500").is_some());
    master.output("rostopic", &["pub", "-1", "/clock", "rosgraph_msgs/Clock", "{clock: {secs: 20}}"]).unwrap();
    assert!(probe.line_with("jump from 500 to 20").is_some());
}

#[test]
fn messages_of_another_type_are_ignored() {
    let master = RosMaster::start().unwrap();
    let probe = probe(&master, &["listen", "/a", "nav_msgs/Path", "1"]);
    assert!(probe.line_with("ready").is_some());
    let _points = publish_points(&master, "/a", "wrong");
    let path = "{header: {frame_id: right}}";
    let _path = Running::start(master.command("rostopic").args(["pub", "-r", "5", "/a", "nav_msgs/Path", path]));
    assert!(probe.line_with("frame right").is_some());
    assert_eq!(probe.count("frame wrong"), 0);
}

#[test]
fn a_stopped_publisher_delays_neither_the_start_nor_other_publishers() {
    let master = RosMaster::start().unwrap();
    let stopped = publish_points(&master, "/a", "stopped");
    let live = publish_points(&master, "/a", "live");
    let first = probe(&master, &["listen", "/a", POINT, "1", "__name:=first"]);
    assert!(first.line_with("frame stopped").is_some() && first.line_with("frame live").is_some());
    stopped.signal("STOP");
    let second = probe(&master, &["listen", "/a", POINT, "1", "__name:=second"]);
    assert!(second.line_with("frame live").is_some(), "{:?}", second.errors());
    assert!(first.prints_again("frame live"));
    assert_eq!(second.count("frame stopped"), 0);
    stopped.signal("CONT");
    assert!(second.line_with("frame stopped").is_some(), "{:?}", second.errors());
    drop(live);
}
