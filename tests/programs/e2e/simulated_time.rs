//! `/use_sim_time`: the node's time is that of a played bag, also when the bag is played again.

use rcs_tests::ros::{wait_until, Running, PATIENCE};
use rcs_tests::ros_fixture::{RosFixture, Setup, CLOUD};

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
    let fixture = Setup::of(&[CLOUD]).simulated_time().start();
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("simulated.bag");
    fixture.python(format!("path = '{}'", bag.display()));
    fixture.python(WRITE_BAG);
    fixture.python("viewer = Viewer('/view/image')");
    for round in 1..=2 {
        fixture.python("viewer.forget()");
        let mut player = fixture.master.command("rosbag");
        // So slowly that each cloud is seen.
        let mut player = Running::start(player.args(["play", "--clock", "-d", "2", "-r", "0.4"]).arg(&bag)).unwrap();
        fixture.wait_for("len(viewer.colors) > 0 and viewer.middle() == (0, 0, 255)");
        let ended = player.wait(PATIENCE);
        assert!(ended.is_some(), "{:?}", player.errors());
        // Images of the first round that were repeated before the second began do not count.
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

#[test]
fn a_camera_that_moves_is_drawn_where_it_will_be() {
    let start = |args: &[&str]| {
        let fixture = Setup::of(&[CLOUD]).simulated_time().args(args).launch();
        fixture.python("from rosgraph_msgs.msg import Clock");
        fixture.python("at = lambda secs: rospy.Time(5000) + rospy.Duration(secs)");
        fixture.python("latch('/clock', Clock(at(0.1)))");
        fixture.python("latch('/eye/camera_info', info())");
        // 1 m before the camera's place at the newest transform, which it passes at 10 m/s.
        fixture.python("latch('/cloud', cloud(0xff0000, points=((2, 0, 2),)))");
        fixture.python("viewer = Viewer('/view/image')");
        fixture.python("for i in range(6): send('/tf', tf('map', 'eye', xyz=(0.2 * i, 0, 0), stamp=at(0.02 * i)))");
        fixture
    };
    let fixture = start(&["_predict:=0.06"]);
    // 1 m at a distance of 2 m are 25 pixels, and the cloud is a square of that size.
    let middle_is = |fixture: &RosFixture, middle: u32| {
        let (outside, inside) = (middle - 14, middle - 11);
        fixture.wait_for(format!(
            "viewer.pixel({outside}, 24) == (0, 0, 0) and viewer.pixel({inside}, 24) == (255, 0, 0)"
        ));
    };
    middle_is(&fixture, 32 + 10);
    // The command line wins, and the limit holds.
    middle_is(&start(&["_predict:=0.06", "--predict", "0.5", "--predict-limit", "0.08"]), 32 + 5);
    middle_is(&start(&[]), 32 + 25);
}
