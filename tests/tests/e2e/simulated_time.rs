//! `/use_sim_time`: the node's time is that of a played bag, also when the bag is played again.

use rcs_tests::puppet::Puppet;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};

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
    let puppet = Puppet::start(&master, &[]).unwrap();
    let stand = Stand::with(master, puppet, &config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    stand.wait_for_log("drawing ").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("simulated.bag");
    stand.puppet(format!("path = '{}'", bag.display()));
    stand.puppet(WRITE_BAG);
    stand.puppet("eye = Eye('/view/image')");
    for round in 1..=2 {
        stand.puppet("eye.forget()");
        let mut player = stand.master.command("rosbag");
        let mut player = Running::start(player.args(["play", "--clock", "-d", "1"]).arg(&bag)).unwrap();
        stand.wait_for("len(eye.colors) > 0 and eye.middle() == (0, 0, 255)");
        let ended = player.wait(PATIENCE);
        assert!(ended.is_some(), "{:?}", player.errors());
        // Pictures of the first round that were repeated before the second began do not count.
        let of_round = if round == 1 { "eye.colors" } else { "eye.colors[eye.colors.index((0, 0, 0)):]" };
        assert_eq!(stand.puppet(of_round), "[(0, 0, 0), (255, 0, 0), (0, 0, 255)]", "round {round}");
        // Stamps are in the bag's time.
        assert_eq!(stand.puppet("4999 < eye.images[-1][2] < 5010"), "True", "{}", stand.puppet("eye.images[-1]"));
        let jumps = || stand.log_lines(&["jumped back", "5003", "5000"]);
        assert!(wait_until(PATIENCE, || jumps() == round - 1), "round {round}");
    }
}
