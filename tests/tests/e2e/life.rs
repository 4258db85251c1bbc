//! Starting and ending: waiting for a master, clean shutdown, and other nodes that stall or restart.

use crate::diagnostics::MONITOR;
use rcs_tests::programs::program;
use rcs_tests::puppet::Puppet;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// A node with a picture of a red cloud.
fn stand() -> Stand {
    stand_with(&[CLOUD])
}

/// A node with these displays and a picture of a red cloud.
fn stand_with(displays: &[&str]) -> Stand {
    let stand = Stand::start(&config(displays, &[CameraPub::default()]), &[]).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/eye/camera_info', info())");
    stand.puppet("latch('/cloud', cloud(0xff0000))");
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    stand
}

/// A node whose master is not running yet.
fn node(master: &RosMaster, config: &Path) -> Running {
    let mut command = master.environment(Command::new(program("camera_stream")));
    Running::start(command.arg("-d").arg(config).args(["--renderer", "cpu"])).unwrap()
}

#[test]
fn without_a_master_the_node_logs_once_and_starts_when_the_master_does() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz");
    std::fs::write(&file, config(&[CLOUD], &[CameraPub::default()])).unwrap();
    let mut master = RosMaster::reserve().unwrap();
    let node = node(&master, &file);
    assert!(wait_until(PATIENCE, || !node.errors().is_empty()));
    // No second line may follow while there is no master.
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(node.errors().len(), 1, "{:?}", node.errors());
    assert!(node.errors()[0].contains(&master.uri()), "{:?}", node.errors());
    master.run().unwrap();
    let puppet = Puppet::start(&master, &[]).unwrap();
    puppet.run("latch('/tf_static', tf('map', 'eye')); latch('/eye/camera_info', info())").unwrap();
    puppet.run("latch('/cloud', cloud(0xff0000)); eye = Eye('/view/image')").unwrap();
    assert!(puppet.wait_for(PATIENCE, "eye.middle() == (255, 0, 0)"), "{:?}", node.errors());
    assert_eq!(node.errors().iter().filter(|line| line.contains(&master.uri())).count(), 1, "{:?}", node.errors());
}

#[test]
fn waiting_for_a_master_ends_with_0_on_sigint_and_sigterm() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz");
    std::fs::write(&file, config(&[], &[CameraPub::default()])).unwrap();
    for signal in ["INT", "TERM"] {
        let master = RosMaster::reserve().unwrap();
        let mut node = node(&master, &file);
        assert!(wait_until(PATIENCE, || !node.errors().is_empty()));
        node.signal(signal);
        let status = node.wait(Duration::from_secs(5)).unwrap();
        assert_eq!(status.code(), Some(0), "{:?}", node.errors());
    }
}

#[test]
fn sigint_and_sigterm_end_the_node_with_0_and_nothing_of_it_stays_registered() {
    for signal in ["INT", "TERM"] {
        let mut stand = stand();
        assert!(stand.master.output("rosnode", &["list"]).unwrap().contains("/camera_stream"));
        assert!(stand.master.output("rostopic", &["list"]).unwrap().contains("/view/image"));
        stand.node.signal(signal);
        let asked = Instant::now();
        let status = stand.node.wait(Duration::from_secs(10)).unwrap();
        let took = asked.elapsed();
        assert_eq!(status.code(), Some(0));
        assert!(took < Duration::from_secs(2), "{signal}: {took:?}");
        let nodes = stand.master.output("rosnode", &["list"]).unwrap();
        assert!(nodes.contains("/puppet") && !nodes.contains("/camera_stream"), "{nodes}");
        let published = stand.master.output("rostopic", &["list", "-p"]).unwrap();
        assert!(published.contains("/cloud") && !published.contains("/view"), "{published}");
        let services = stand.master.output("rosservice", &["list"]).unwrap();
        assert!(!services.contains("camera"), "{services}");
    }
}

#[test]
fn rosnode_kill_ends_the_node_with_0() {
    let mut stand = stand();
    stand.master.output("rosnode", &["kill", "/camera_stream"]).unwrap();
    let status = stand.node.wait(PATIENCE).unwrap();
    assert_eq!(status.code(), Some(0), "{}", stand.log());
}

#[test]
fn a_publisher_that_was_killed_and_restarted_is_received_again() {
    let stand = stand();
    let start = |color: &str| {
        let other = Puppet::start(&stand.master, &["__name:=clouds"]).unwrap();
        other.run(format!("latch('/cloud', cloud({color}))")).unwrap();
        other
    };
    let first = start("0x00ff00");
    stand.wait_for("eye.middle() == (0, 255, 0)");
    // Killed, so that it does not unregister; the next has the same name on another port.
    drop(first);
    let second = start("0x0000ff");
    stand.wait_for("eye.middle() == (0, 0, 255)");
    second.run("latch('/cloud', cloud(0xffff00))").unwrap();
    stand.wait_for("eye.middle() == (255, 255, 0)");
}

#[test]
fn a_stalled_subscriber_does_not_stop_anothers_pictures() {
    let stand = stand();
    // Big pictures, so that few fit into a buffer.
    stand.puppet("latch('/eye/camera_info', info(width=1280, height=800))");
    let stalled = Puppet::start(&stand.master, &["__name:=stalled"]).unwrap();
    // It does not subscribe to the CameraInfo, whose small messages would hardly ever fill a buffer.
    stalled.run("received = []; images = rospy.Subscriber('/view/image', Image, received.append)").unwrap();
    assert!(stalled.wait_for(PATIENCE, "len(received) > 3"));
    stand.puppet("topic = '/diagnostics'");
    stand.puppet(MONITOR);
    let subscribers = |count: u32| format!("values('camera_stream: CameraPub').get('subscribers') == '{count}'");
    stand.wait_for(subscribers(2));
    let signal = |name: &str| Command::new("kill").args([name, &stalled.id().to_string()]).status().unwrap();
    assert!(signal("-STOP").success());
    // From filling the buffers until the stalled connection is closed.
    stand.puppet("eye.forget()");
    stand.wait_for(subscribers(1));
    stand.wait_for("len(eye.images) > 60");
    let longest = "max(b[0] - a[0] for a, b in zip(eye.images, eye.images[1:]))";
    let longest: f64 = stand.puppet(longest).parse().unwrap();
    assert!(longest < 1.5, "{longest} s without a picture");
    assert!(signal("-CONT").success());
}

#[test]
fn the_node_registers_again_with_a_restarted_master() {
    let silent = CLOUD.replace("Name: cloud", "Name: silent").replace("/cloud", "/silent");
    let mut stand = stand_with(&[CLOUD, &silent]);
    // The node asks the master every few seconds what is registered, and remembers what is its own. What it reports of
    // the publishers of a topic comes from the same answer: when that has followed a change, all is remembered.
    stand.puppet("topic = '/diagnostics'");
    stand.puppet(MONITOR);
    let has_nobody = "'No publishers on [/silent]' in values('camera_stream: silent').get('Publisher', '')";
    stand.wait_for(has_nobody);
    stand.puppet("publisher('/silent', PointCloud2, False)");
    stand.wait_for(format!("not {has_nobody}"));
    stand.master.restart().unwrap();
    let listed = || stand.master.output("rosservice", &["list"]).unwrap().contains("/camera_trigger");
    assert!(wait_until(PATIENCE, listed), "{}", stand.log());
    let newcomer = Puppet::start(&stand.master, &["__name:=newcomer"]).unwrap();
    newcomer.run("eye = Eye('/view/image')").unwrap();
    assert!(newcomer.wait_for(PATIENCE, "eye.middle() == (255, 0, 0)"), "{}", stand.log());
}
