//! `rosbag record`: what this package latches is latched in the bag, and is so again when the bag is played.

use rcs_tests::programs::repository;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{RosMaster, Running, PATIENCE};

#[test]
fn a_recorded_latched_topic_stays_latched() {
    let master = RosMaster::start().unwrap();
    let config = repository().join("config");
    let start =
        |name: &str, args: &[&str]| Running::start(master.program(name).args(args).current_dir(&config)).unwrap();
    let _projector = start("projector", &["projector.yaml"]);
    let _cloud = start("publish_cloud", &["demo/clusters.pcd", "--topic", "/clusters", "--rate", "0"]);
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run("send_once = publisher('/plain', CameraInfo, False)").unwrap();

    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("latched.bag");
    let topics = ["/proj_view/camera_info", "/tf_static", "/clusters", "/plain"];
    // It ends by itself when it has recorded a message of each topic.
    let mut record = master.command("rosbag");
    record.args(["record", "--limit", "1", "-O"]).arg(&bag).args(topics);
    let mut recorder = Running::start(&mut record).unwrap();
    assert!(python.wait_for(PATIENCE, "send_once.get_num_connections() == 1"));
    python.run("send_once.publish(info())").unwrap();
    assert!(recorder.wait(PATIENCE).is_some_and(|status| status.success()));

    python.run(format!("path = '{}'", bag.display())).unwrap();
    python.run("import rosbag").unwrap();
    let latched = "sorted((c.topic, c.header['latching'].decode() if isinstance(c.header['latching'], bytes) else c.header['latching']) for c in rosbag.Bag(path)._connections.values())";
    let expected = "[('/clusters', '1'), ('/plain', '0'), ('/proj_view/camera_info', '1'), ('/tf_static', '1')]";
    assert_eq!(python.run(latched).unwrap(), expected);
}
