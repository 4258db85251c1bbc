//! Bags that ROS recorded, and ours read by ROS.

use crate::PEER;
use rcs_bag::Bag;
use rcs_messages::std_msgs::Header;
use rcs_messages::{geometry_msgs::PointStamped, AnyMessage, MessageKind, Time};
use rcs_test_support::BagWriter;
use rcs_tests::ros::RosMaster;

#[test]
fn bags_of_every_compression_are_read() {
    let master = RosMaster::reserve().unwrap();
    let dir = tempfile::tempdir().unwrap();
    for compression in ["none", "bz2", "lz4"] {
        let path = dir.path().join(format!("{compression}.bag"));
        master.output("python3", &[PEER, "write_bag", path.to_str().unwrap(), compression]).unwrap();
        let bag = Bag::open(&path).unwrap();
        let messages: Vec<_> = bag.messages(|_| true).collect::<Result<_, _>>().unwrap();
        let secs: Vec<_> = messages.iter().map(|message| message.time.sec).collect();
        assert_eq!(secs, (1000..1100).collect::<Vec<_>>(), "{compression}");
        let AnyMessage::PointStamped(point) = MessageKind::PointStamped.decode(&messages[37].bytes).unwrap() else {
            panic!("another type");
        };
        assert_eq!((point.header.frame_id.as_str(), point.point.x), ("map", 1.0), "{compression}");
    }
}

#[test]
fn rosbag_reads_a_bag_that_we_wrote() {
    let master = RosMaster::reserve().unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("ours.bag");
    let mut writer = BagWriter::create(&path).unwrap();
    for sec in 0..3 {
        let mut message = PointStamped {
            header: Header { frame_id: "map".to_owned(), ..Header::default() },
            ..PointStamped::default()
        };
        message.point.y = f64::from(sec);
        writer.write("/point", false, Time { sec: 50 + sec, nsec: 0 }, &message).unwrap();
    }
    writer.finish().unwrap();
    let printed = master.output("python3", &[PEER, "read_bag", path.to_str().unwrap()]).unwrap();
    let lines: Vec<_> = printed.lines().collect();
    assert_eq!(lines.len(), 3, "{printed}");
    assert_eq!(lines[2], "/point geometry_msgs/PointStamped map 2.0 52");
}
