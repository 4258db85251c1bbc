//! `camera_stream render` with bags as others record them: split, of other names, of a simulation's time, `.mcap`.

use std::fs;

use rcs_bag::Bag;
use rcs_messages::MessageKind;
use rcs_test_support::McapWriter;
use rcs_tests::ros_fixture::{config, CameraPub, CLOUD};

use crate::render::{colors, Render};

const RED: [u8; 3] = [255, 0, 0];
const GREEN: [u8; 3] = [0, 255, 0];
const BLUE: [u8; 3] = [0, 0, 255];
const BLACK: [u8; 3] = [0, 0, 0];

/// What `render -o out.png` draws in the middle, and what it warns of.
fn middle(render: &Render, arguments: &str) -> ([u8; 3], String) {
    let output = render.run(&format!("-d scene.rviz -o out.png {arguments}"));
    let warnings = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {warnings}");
    (render.pixel("out.png", 32, 24), warnings)
}

/// `scene.bag` in pieces: the frames and the CameraInfo, and one bag for each colour.
fn split(render: &Render) {
    render.bag(
        "first.bag",
        "bag.write('/tf_static', tf('map', 'eye'), at(100))\nbag.write('/eye/camera_info', info(), at(100))",
    );
    for (name, color, secs) in [("red", 0xff0000, 100), ("green", 0x00ff00, 101), ("blue", 0x0000ff, 102)] {
        render.bag(&format!("{name}.bag"), &format!("bag.write('/cloud', cloud({color}), at({secs}))"));
    }
}

#[test]
fn a_split_recording_is_drawn_as_one_bag_whatever_the_order_of_its_parts() {
    let render = Render::with_scene();
    split(&render);
    for parts in ["first.bag red.bag green.bag blue.bag", "blue.bag green.bag --bag red.bag first.bag"] {
        for (at, color) in [("", BLUE), ("--at 0", RED), ("--at 101.5", GREEN)] {
            render.good(&format!("-d scene.rviz --bag {parts} -o out.png {at}"));
            assert_eq!(render.pixel("out.png", 32, 24), color, "{parts} {at}");
        }
    }
    let error = render.bad("-d scene.rviz --bag red.bag green.bag -o out.png");
    assert!(error.contains("red.bag, green.bag") && error.contains("/eye/camera_info"), "{error}");
}

#[test]
fn topics_are_renamed_as_rosbag_play_does() {
    let render = Render::with_scene();
    render.bag(
        "robot.bag",
        "bag.write('/robot1/tf_static', tf('map', 'eye'), at(100))\n\
         bag.write('/robot1/camera_info', info(), at(100))\n\
         bag.write('robot1/points', cloud(0xff0000), at(100))\n\
         bag.write('/cloud', cloud(0x0000ff), at(101))",
    );
    let names = "/robot1/tf_static:=/tf_static /robot1/camera_info:=/eye/camera_info";
    assert_eq!(middle(&render, &format!("--bag robot.bag {names}")), (BLUE, String::new()));
    let swapped = format!("{names} --bag robot.bag /robot1/points:=/cloud /cloud:=/robot1/points");
    assert_eq!(middle(&render, &swapped), (RED, String::new()));
    let (color, warning) = middle(&render, &format!("--bag robot.bag {names} /robot2/points:=/cloud"));
    assert!(color == BLUE && warning.contains("the bag has no topic /robot2/points"), "{warning}");
    let error = render.bad("-d scene.rviz --bag robot.bag -o out.png /robot1/points:=1!");
    assert!(error.contains("'1!' is no topic of a bag"), "{error}");
}

/// A bag that was recorded in 2023 while a simulation's clock was at 10 s.
fn simulated(render: &Render, clock: &str) {
    render.bag(
        "simulated.bag",
        &format!(
            "at, start = rospy.Time.from_sec, 1.7e9\n\
             bag.write('/tf_static', tf('map', 'eye'), at(start))\n\
             bag.write('/eye/camera_info', info(), at(start))\n\
             for secs, color in [(0, 0xff0000), (1, 0x00ff00), (2, 0x0000ff)]:\n\
             \x20   bag.write('/cloud', cloud(color, stamp=at(10 + secs)), at(start + 2 * secs + 0.5))\n\
             from rosgraph_msgs.msg import Clock\n\
             for secs in {clock}:\n\
             \x20   bag.write('/clock', Clock(at(10 + secs)), at(start + 2 * secs + 0.1))"
        ),
    );
}

#[test]
fn ros_time_is_that_of_the_bags_clock() {
    let render = Render::with_scene();
    simulated(&render, "[i / 4 for i in range(13)]");
    for (at, color) in [("", BLUE), ("--at 0.2", RED), ("--at 1.2", GREEN), ("--at 11.3", GREEN), ("--at 3", BLUE)] {
        render.good(&format!("-d scene.rviz --bag simulated.bag -o out.png {at}"));
        assert_eq!(render.pixel("out.png", 32, 24), color, "{at}");
    }
    render.good("-d scene.rviz --bag simulated.bag --sequence all --rate 1 --start 0.3");
    assert_eq!(colors(&render, "all"), [RED, GREEN, BLUE]);
    let error = render.bad("-d scene.rviz --bag simulated.bag -o out.png --at 4");
    assert!(error.contains("the bag ends 3 s after its first message, at 13"), "{error}");
    // Without it: seconds of recording.
    render.good("-d scene.rviz --bag simulated.bag -o out.png --at 3 /clock:=/unused");
    assert_eq!(render.pixel("out.png", 32, 24), GREEN);
}

#[test]
fn a_clock_that_jumps_back_is_refused_where_the_moment_may_be_another() {
    let render = Render::with_scene();
    let jumps = ["[0, 1, 2, 0.5, 1.5]", "[0, 1, 0.5, 2]", "[1, 2, 0.5]"];
    for clock in jumps {
        // In the order of recording, which is that of the list.
        render.bag(
            "jump.bag",
            &format!(
                "from rosgraph_msgs.msg import Clock\n\
                 at = rospy.Time.from_sec\n\
                 bag.write('/tf_static', tf('map', 'eye'), at(50))\n\
                 bag.write('/eye/camera_info', info(), at(50))\n\
                 for i, secs in enumerate({clock}):\n\
                 \x20   bag.write('/clock', Clock(at(10 + secs)), at(50 + i))"
            ),
        );
        let error = render.bad("-d scene.rviz --bag jump.bag -o out.png");
        assert!(error.contains("jump.bag: /clock jumps back from 1"), "{clock}: {error}");
        assert!(error.contains("rosbag filter") && error.contains("/clock:=/unused"), "{clock}: {error}");
        assert_eq!(middle(&render, "--bag jump.bag /clock:=/unused").0, BLACK, "{clock}: a camera, and no cloud");
    }
}

#[test]
fn mcap_files_are_drawn_as_the_bags_that_they_were_made_from() {
    let render = Render::with_scene();
    let bag = Bag::open(render.path("scene.bag")).unwrap();
    let mut writer = McapWriter::create(render.path("scene.mcap"), 1000).unwrap();
    for message in bag.messages(|_| true) {
        let message = message.unwrap();
        let (topic, ros_type) = (&message.connection.topic, &message.connection.ros_type);
        writer.write(topic, ros_type, "ros1", message.time, &message.bytes).unwrap();
    }
    writer.finish().unwrap();
    for (at, color) in [("", BLUE), ("--at 0", RED), ("--at 1.5", GREEN)] {
        assert_eq!(middle(&render, &format!("--bag scene.mcap {at}")), (color, String::new()), "{at}");
    }
    split(&render);
    assert_eq!(middle(&render, "--bag scene.mcap green.bag --at 1").0, GREEN);
}

#[test]
fn each_display_takes_its_own_type_of_a_topic_with_several() {
    let render = Render::with_scene();
    // rosbag in Python keeps one type for each topic; other recorders do not.
    render.bag(
        "two.bag",
        "from visualization_msgs.msg import Marker\n\
         bag.write('/tf_static', tf('map', 'eye'), at(100))\n\
         bag.write('/eye/camera_info', info(), at(100))\n\
         marker = Marker(type=Marker.POINTS)\n\
         marker.header.frame_id, marker.pose.orientation.w = 'map', 1\n\
         marker.scale.x = marker.scale.y = marker.color.g = 0.5\n\
         marker.color.a = 1\n\
         marker.points = [TransformStamped().transform.translation]\n\
         marker.points[0].z = 1\n\
         for message in [marker, cloud(0xff0000)]:\n\
         \x20   bag._topic_connections.clear()\n\
         \x20   bag.write('/cloud', message, at(100))",
    );
    let marker = "{Class: rviz/Marker, Name: marker, Enabled: true, Marker Topic: /cloud}";
    let unread = "topic /cloud holds visualization_msgs/Marker in the bag, not sensor_msgs/PointCloud2";
    for (displays, color, warning) in [(&[CLOUD, marker][..], [0, 128, 0], ""), (&[CLOUD], RED, unread)] {
        fs::write(render.path("scene.rviz"), config(displays, &[CameraPub::default()])).unwrap();
        let (drawn, warnings) = middle(&render, "--bag two.bag");
        let is_near = drawn.iter().zip(color).all(|(drawn, level)| drawn.abs_diff(level) < 2);
        assert!(
            is_near && warnings.contains(warning) && warnings.is_empty() == warning.is_empty(),
            "{drawn:?} {warnings}"
        );
    }
}

#[test]
fn a_topic_of_another_version_of_its_type_is_reported_and_not_drawn() {
    let render = Render::with_scene();
    let bytes = fs::read(render.path("scene.bag")).unwrap();
    let change = |md5sum: &[u8; 32]| {
        let (mut bytes, old) = (bytes.clone(), MessageKind::PointCloud2.md5sum());
        let places: Vec<_> = (0..bytes.len() - 32).filter(|at| bytes[*at..].starts_with(old.as_bytes())).collect();
        assert!(places.len() >= 2, "in the chunk and in the index");
        places.into_iter().for_each(|at| bytes[at..at + 32].copy_from_slice(md5sum));
        fs::write(render.path("other.bag"), bytes).unwrap();
        middle(&render, "--bag other.bag")
    };
    let (color, warnings) = change(b"0123456789abcdef0123456789abcdef");
    let reports = warnings.lines().filter(|line| line.contains("in the bag")).count();
    assert!(color == BLACK && reports == 1, "{color:?} {warnings}");
    let said = "holds another version of sensor_msgs/PointCloud2 (md5sum 0123456789abcdef0123456789abcdef, here ";
    assert!(warnings.contains(said) && warnings.contains("topic /cloud"), "{warnings}");
    // None was recorded.
    assert_eq!(change(b"*                               "), (BLUE, String::new()));
}
