//! `rosbag record`: what this package latches is latched in the bag, and is so again when the bag is played.

use rcs_tests::programs::{program, repository};
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{RosMaster, Running, PATIENCE};
use std::process::Command;

#[test]
fn a_recorded_latched_topic_stays_latched() {
    let master = RosMaster::start().unwrap();
    let config = repository().join("config");
    let start = |name: &str, args: &[&str]| {
        Running::start(master.environment(Command::new(program(name))).args(args).current_dir(&config)).unwrap()
    };
    let _projector = start("projector", &["projector.yaml"]);
    let _cloud = start("publish_cloud", &["demo/clusters.pcd", "--topic", "/clusters", "--rate", "0"]);
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run("send_once = publisher('/plain', CameraInfo, False)").unwrap();

    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("latched.bag");
    let topics = ["/proj_view/camera_info", "/tf_static", "/clusters", "/plain"];
    let mut recorder = Running::start(master.command("rosbag").args(["record", "-O"]).arg(&bag).args(topics)).unwrap();
    // rosbag says nothing of what it wrote, but its subscription to the last topic is seen.
    assert!(python.wait_for(PATIENCE, "send_once.get_num_connections() == 1"));
    for topic in &topics[..3] {
        let connected = format!("any('{topic}' in c for c in bus('/record'))");
        python.run(BUS).unwrap();
        assert!(python.wait_for(PATIENCE, connected), "{topic}");
    }
    python.run("send_once.publish(info())").unwrap();
    recorder.signal("INT");
    assert!(recorder.wait(PATIENCE).is_some());

    python.run(format!("path = '{}'", bag.display())).unwrap();
    python.run("import rosbag").unwrap();
    let latched = "sorted((c.topic, c.header['latching'].decode() if isinstance(c.header['latching'], bytes) else c.header['latching']) for c in rosbag.Bag(path)._connections.values())";
    let expected = "[('/clusters', '1'), ('/plain', '0'), ('/proj_view/camera_info', '1'), ('/tf_static', '1')]";
    assert_eq!(python.run(latched).unwrap(), expected);
}

/// Python that returns the connections of a node whose name begins like that, as its API has them.
const BUS: &str = "
import rosgraph, rosnode
from xmlrpc.client import ServerProxy
def bus(name):
    for node in rosnode.get_node_names():
        if node.startswith(name):
            return [str(c) for c in ServerProxy(rosnode.get_api_uri(rosgraph.Master('/test'), node)).getBusInfo('/test')[2]]
    return []
";
