//! `/use_sim_time`: the node's time is that of a played bag, also when the bag is played again.

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, CLOUD};

/// Writes a bag of times around 5000 s: a frame and a camera at once, a red cloud after 1.5 s, a blue one after 2.5 s.
const WRITE_BAG: &str = "
import rosbag
with rosbag.Bag(path, 'w') as bag:
    at = lambda secs: rospy.Time(5000) + rospy.Duration(secs)
    for i in range(50):
        bag.write('/tf', tf('map', 'eye', stamp=at(i * 0.08)), at(i * 0.08))
    for i in range(8):
        bag.write('/eye/camera_info', info(), at(i * 0.5))
    bag.write('/cloud', cloud(0xff0000, stamp=at(1.5)), at(1.5))
    bag.write('/cloud', cloud(0x0000ff, stamp=at(2.5)), at(2.5))
";

#[test]
fn a_bag_played_again_with_its_clock_starts_without_the_clouds_of_the_first_round() {
    let master = RosMaster::start().unwrap();
    master.output("rosparam", &["set", "/use_sim_time", "true"]).unwrap();
    let python = PythonNode::start(&master, &[]).unwrap();
    let fixture = RosFixture::with(master, python, &config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    fixture.wait_for_log("drawing ").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("simulated.bag");
    fixture.python(format!("path = '{}'", bag.display()));
    fixture.python(WRITE_BAG);
    fixture.python("viewer = Viewer('/view/image')");
    for round in 1..=2 {
        fixture.python("viewer.forget()");
        let mut player = fixture.master.command("rosbag");
        let mut player = Running::start(player.args(["play", "--clock", "-d", "1"]).arg(&bag)).unwrap();
        fixture.wait_for("len(viewer.colors) > 0 and viewer.middle() == (0, 0, 255)");
        let ended = player.wait(PATIENCE);
        assert!(ended.is_some(), "{:?}", player.errors());
        // Pictures of the first round that were repeated before the second began do not count.
        let of_round = if round == 1 { "viewer.colors" } else { "viewer.colors[viewer.colors.index((0, 0, 0)):]" };
        assert_eq!(fixture.python(of_round), "[(0, 0, 0), (255, 0, 0), (0, 0, 255)]", "round {round}");
        // Stamps are in the bag's time.
        assert_eq!(
            fixture.python("4999 < viewer.images[-1][2] < 5010"),
            "True",
            "{}",
            fixture.python("viewer.images[-1]")
        );
        let jumps = || fixture.log_lines(&["jumped back", "5003", "5000"]);
        assert!(wait_until(PATIENCE, || jumps() == round - 1), "round {round}");
    }
}
