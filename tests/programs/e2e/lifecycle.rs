//! Start and shutdown: waiting for a master, clean shutdown, and other nodes that stall or restart.

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Scenarios of a node that shows a red cloud; after one that ends the node it is started again.
const SCENARIOS: [fn(&mut RosFixture); 7] = [
    every_thread_has_a_name,
    a_publisher_that_was_killed_and_restarted_is_received_again,
    a_stalled_subscriber_does_not_stop_anothers_images,
    |fixture| a_signal_ends_the_node_with_0_and_nothing_of_it_stays_registered(fixture, "INT"),
    |fixture| a_signal_ends_the_node_with_0_and_nothing_of_it_stays_registered(fixture, "TERM"),
    rosnode_kill_ends_the_node_with_0,
    the_node_registers_again_with_a_restarted_master,
];

#[test]
fn a_node_lives_among_others_and_ends() {
    let mut fixture = Setup::of(&[CLOUD]).showing_red();
    for scenario in SCENARIOS {
        if fixture.node.is_silent() {
            fixture.respawn().unwrap();
        }
        fixture.python("place_camera(); latch('/cloud', cloud(0xff0000)); viewer.forget()");
        fixture.wait_for("viewer.middle() == (255, 0, 0)");
        scenario(&mut fixture);
    }
}

/// A node whose master is not running yet.
fn node(master: &RosMaster, config: &Path) -> Running {
    Running::start(master.program("camera_stream").arg("-d").arg(config).args(["--renderer", "cpu"])).unwrap()
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
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run("place_camera()").unwrap();
    python.run("latch('/cloud', cloud(0xff0000)); viewer = Viewer('/view/image')").unwrap();
    assert!(python.wait_for(PATIENCE, "viewer.middle() == (255, 0, 0)"), "{:?}", node.errors());
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
        assert_eq!(node.end(signal).unwrap().code(), Some(0), "{:?}", node.errors());
    }
}

fn a_signal_ends_the_node_with_0_and_nothing_of_it_stays_registered(fixture: &mut RosFixture, signal: &str) {
    assert!(fixture.master.output("rosnode", &["list"]).unwrap().contains("/camera_stream"));
    assert!(fixture.master.output("rostopic", &["list"]).unwrap().contains("/view/image"));
    assert_eq!(fixture.node.end(signal).unwrap().code(), Some(0), "{}", fixture.log());
    let nodes = fixture.master.output("rosnode", &["list"]).unwrap();
    assert!(nodes.contains("/python_node") && !nodes.contains("/camera_stream"), "{nodes}");
    let published = fixture.master.output("rostopic", &["list", "-p"]).unwrap();
    assert!(published.contains("/cloud") && !published.contains("/view"), "{published}");
    let services = fixture.master.output("rosservice", &["list"]).unwrap();
    assert!(!services.contains("camera"), "{services}");
}

fn rosnode_kill_ends_the_node_with_0(fixture: &mut RosFixture) {
    fixture.master.output("rosnode", &["kill", "/camera_stream"]).unwrap();
    let status = fixture.node.wait(PATIENCE).unwrap();
    assert_eq!(status.code(), Some(0), "{}", fixture.log());
}

fn a_publisher_that_was_killed_and_restarted_is_received_again(fixture: &mut RosFixture) {
    let start = |color: &str| {
        let other = PythonNode::start(&fixture.master, &["__name:=clouds"]).unwrap();
        other.run(format!("latch('/cloud', cloud({color}))")).unwrap();
        other
    };
    let first = start("0x00ff00");
    fixture.wait_for("viewer.middle() == (0, 255, 0)");
    // Killed, so that it does not unregister; the next has the same name on another port.
    drop(first);
    let second = start("0x0000ff");
    fixture.wait_for("viewer.middle() == (0, 0, 255)");
    second.run("latch('/cloud', cloud(0xffff00))").unwrap();
    fixture.wait_for("viewer.middle() == (255, 255, 0)");
}

fn a_stalled_subscriber_does_not_stop_anothers_images(fixture: &mut RosFixture) {
    // Big images, so that few fit into a buffer.
    fixture.python("latch('/eye/camera_info', info(width=1280, height=800))");
    let stalled = PythonNode::start(&fixture.master, &["__name:=stalled"]).unwrap();
    // It does not subscribe to the CameraInfo, whose small messages would hardly ever fill a buffer.
    stalled.run("received = []; images = rospy.Subscriber('/view/image', Image, received.append)").unwrap();
    assert!(stalled.wait_for(PATIENCE, "len(received) > 3"));
    fixture.python("monitor()");
    let subscribers = |count: u32| format!("values('camera_stream: CameraPub').get('subscribers') == '{count}'");
    fixture.wait_for(subscribers(2));
    let signal = |name: &str| Command::new("kill").args([name, &stalled.id().to_string()]).status().unwrap();
    assert!(signal("-STOP").success());
    // Many more than the stalled one's buffers hold.
    fixture.images_go_on(60);
    // It was not cut off, and goes on with what is new.
    fixture.wait_for(subscribers(2));
    let newest: f64 = fixture.python("viewer.images[-1][2]").parse().unwrap();
    assert!(signal("-CONT").success());
    assert!(stalled.wait_for(PATIENCE, format!("received[-1].header.stamp.to_sec() > {newest}")));
}

#[test]
fn nothing_is_drawn_when_a_viewer_has_left_and_one_that_returns_gets_a_image_at_once() {
    // One of them does not repeat its image while this test runs.
    let rare =
        CameraPub { name: "Rare", image: "/rare/image", namespace: "rare", rate: "0.0001", ..CameraPub::default() };
    let fixture = Setup::with_cameras(&[CLOUD], &[CameraPub::default(), rare]).start();
    fixture.python("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000))");
    fixture.python("moving = lambda i: tf('map', 'eye', xyz=(i * 1e-4, 0, 0), stamp=rospy.Time.now())");
    fixture.python("monitor()");
    let of = |camera: &str, value: &str| format!("int(values('camera_stream: {camera}').get('{value}', -1))");
    let are_gone = format!("{} == 0 and {} == 0", of("CameraPub", "subscribers"), of("Rare", "subscribers"));
    // With a moving camera every image is another one, while somebody watches.
    fixture.python("moves = PublishRepeatedly(60, moving, '/tf'); viewer = Viewer('/view/image')");
    fixture.wait_for(format!("viewer.middle() == (255, 0, 0) and {} > 30", of("CameraPub", "frames drawn")));
    fixture.python("viewer.close()");
    fixture.wait_for(&are_gone);
    let drawn = fixture.python(of("CameraPub", "frames drawn"));
    fixture.python("del arrays[:]");
    fixture.wait_for("len(arrays) > 2");
    assert_eq!(fixture.python(of("CameraPub", "frames drawn")), drawn, "drawn for nobody");
    fixture.python("moves.stop()");

    for _ in 0..4 {
        fixture.python("began = time.time(); viewer = Viewer('/rare/image')");
        fixture.wait_for("len(viewer.images) > 0 and viewer.middle() == (255, 0, 0)");
        println!("a picture {} s after subscribing", fixture.python("viewer.images[0][0] - began"));
        fixture.python("viewer.close()");
        fixture.wait_for(&are_gone);
    }
}

fn the_node_registers_again_with_a_restarted_master(fixture: &mut RosFixture) {
    fixture.master.restart().unwrap();
    let listed = || fixture.master.output("rosservice", &["list"]).unwrap().contains("/camera_trigger");
    assert!(wait_until(PATIENCE, listed), "{}", fixture.log());
    let newcomer = PythonNode::start(&fixture.master, &["__name:=newcomer"]).unwrap();
    newcomer.run("viewer = Viewer('/view/image')").unwrap();
    assert!(newcomer.wait_for(PATIENCE, "viewer.middle() == (255, 0, 0)"), "{}", fixture.log());
}

fn every_thread_has_a_name(fixture: &mut RosFixture) {
    let tasks = std::fs::read_dir(format!("/proc/{}/task", fixture.node.id())).unwrap();
    // One that ends meanwhile has no name any more.
    let mut names: Vec<String> =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok()).collect();
    names.iter_mut().for_each(|name| name.truncate(name.trim_end().len()));
    names.sort();
    println!("{}", names.join(" "));
    assert_eq!(names.iter().filter(|name| *name == "camera_stream").count(), 1, "the first: {names:?}");
    assert!(["scene", "ros-registrar"].iter().all(|name| names.contains(&(*name).to_owned())), "{names:?}");
    assert!(!names.contains(&"ros-start".to_owned()), "that thread has ended: {names:?}");
}
