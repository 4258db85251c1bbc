//! Bags written here, whole and damaged in every way.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use proptest::prelude::*;
use rcs_bag::*;
use rcs_messages::rosgraph_msgs::Clock;
use rcs_messages::std_msgs::String as Text;
use rcs_messages::{MessageKind, Time};
use rcs_test_support::BagWriter;
use std::fs;
use std::path::Path;

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

fn time(sec: u32) -> Time {
    Time { sec, nsec: 5 }
}

fn text(data: &str) -> Text {
    Text { data: data.to_owned() }
}

/// Three chunks whose times overlap: the big texts close the first two.
fn write_sample(path: &Path) {
    let big = "x".repeat(800 * 1024);
    let mut writer = BagWriter::create(path).unwrap();
    writer.write("/a", false, time(10), &text("first")).unwrap();
    writer.write("/a", false, time(30), &text(&big)).unwrap();
    writer.write("/a", false, time(20), &text("second")).unwrap();
    writer.write("/clock", true, time(40), &Clock { clock: time(7) }).unwrap();
    writer.write("/a", false, time(25), &text(&big)).unwrap();
    writer.write("/a", false, time(50), &text("last")).unwrap();
    writer.finish().unwrap();
}

fn secs(bag: &Bag, wanted: impl Fn(&Connection) -> bool) -> Vec<u32> {
    bag.messages(wanted).map(|message| message.unwrap().time.sec).collect()
}

#[test]
fn messages_of_overlapping_chunks_come_in_the_order_of_time() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.bag");
    write_sample(&path);
    let bag = Bag::open(&path).unwrap();
    assert_eq!(secs(&bag, |_| true), [10, 20, 25, 30, 40, 50]);
    assert_eq!(secs(&bag, |connection| &*connection.topic == "/clock"), [40]);
    assert_eq!(bag.time_range(), Some((time(10), time(50))));
    let clock = bag.connections().find(|connection| &*connection.topic == "/clock").unwrap();
    assert!(clock.latching);
    assert_eq!(&*clock.ros_type, "rosgraph_msgs/Clock");
    assert_eq!(clock.md5sum, MessageKind::Clock.md5sum());
    let message = bag.messages(|c| c.latching).next().unwrap().unwrap();
    assert_eq!(rcs_messages::decode::<Clock>(&message.bytes).unwrap().clock, time(7));
}

#[test]
fn a_bag_that_was_not_closed_is_an_error_that_names_rosbag_reindex() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("cut.bag");
    write_sample(&path);
    let whole = fs::read(&path).unwrap();
    let index_pos = whole.windows(10).position(|window| window == b"index_pos=").unwrap() + 10;
    let mut unclosed = whole.clone();
    unclosed[index_pos..index_pos + 8].fill(0);
    for content in [unclosed.as_slice(), &whole[..1_000_000]] {
        fs::write(&path, content).unwrap();
        let error = Bag::open(&path).err().unwrap().to_string();
        assert!(error.contains("cut.bag: no index") && error.contains("rosbag reindex"), "{error}");
    }
}

#[test]
fn a_damaged_chunk_is_an_error_and_the_others_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("hole.bag");
    write_sample(&path);
    let mut bytes = fs::read(&path).unwrap();
    // In the second chunk, the length of a message's header.
    let second = bytes.windows(6).position(|window| window == b"second").unwrap();
    bytes[second - 40..second].fill(0xff);
    fs::write(&path, bytes).unwrap();
    let bag = Bag::open(&path).unwrap();
    let (read, failed): (Vec<_>, Vec<_>) = bag.messages(|_| true).partition(Result::is_ok);
    let secs: Vec<_> = read.into_iter().map(|message| message.unwrap().time.sec).collect();
    assert_eq!(secs, [10, 30, 50]);
    assert_eq!(failed.len(), 1);
    let error = failed.into_iter().next().unwrap().unwrap_err().to_string();
    assert!(error.contains("hole.bag: damaged at byte"), "{error}");
}

#[test]
fn what_comes_before_a_damaged_message_of_its_chunk_is_read() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("cut.bag");
    let mut writer = BagWriter::create(&path).unwrap();
    writer.write("/a", false, time(10), &text("first")).unwrap();
    writer.write("/a", false, time(50), &text("last")).unwrap();
    writer.finish().unwrap();
    let mut bytes = fs::read(&path).unwrap();
    // The length of the last message's data, which are the length of its text and the text.
    let last = bytes.windows(4).position(|window| window == b"last").unwrap();
    bytes[last - 8..last - 4].copy_from_slice(&0xffff_u32.to_le_bytes());
    fs::write(&path, bytes).unwrap();
    let bag = Bag::open(&path).unwrap();
    let (read, failed): (Vec<_>, Vec<_>) = bag.messages(|_| true).partition(Result::is_ok);
    assert_eq!((read.len(), failed.len()), (1, 1));
}

#[test]
fn a_bag_whose_index_swaps_a_chunks_times_does_not_end_before_it_begins() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("swapped.bag");
    let mut writer = BagWriter::create(&path).unwrap();
    writer.write("/a", false, time(10), &text("first")).unwrap();
    writer.write("/a", false, time(50), &text("last")).unwrap();
    writer.finish().unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let mut value_of = |name: &[u8], value: Option<[u8; 8]>| -> [u8; 8] {
        let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len();
        let old = bytes[at..at + 8].try_into().unwrap();
        bytes[at..at + 8].copy_from_slice(&value.unwrap_or(old));
        old
    };
    let start = value_of(b"start_time=", None);
    let end = value_of(b"end_time=", Some(start));
    value_of(b"start_time=", Some(end));
    fs::write(&path, bytes).unwrap();
    let bag = Bag::open(&path).unwrap();
    assert_eq!(bag.time_range(), Some((time(10), time(50))));
    assert_eq!(secs(&bag, |_| true), [10, 50]);
}

#[test]
fn other_files_are_no_bags_and_the_error_names_them() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("b.bag");
    for content in [b"".as_slice(), b"#ROSBAG V1.2\n", MAGIC, b"#ROSBAG V2.0\n\xff\xff\xff\xff"] {
        fs::write(&path, content).unwrap();
        let error = Bag::open(&path).err().unwrap().to_string();
        assert!(error.ends_with("b.bag: neither a ROS bag of version 2.0 nor an MCAP file"), "{error}");
    }
    let error = Bag::open(dir.path().join("none.bag")).err().unwrap().to_string();
    assert!(error.contains("none.bag"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_damaged_bag_never_panics(
        changes in proptest::collection::vec((0..12_000usize, any::<u8>()), 0..6),
        cut in 0..20_000usize,
    ) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("m.bag");
        let mut writer = BagWriter::create(&path).unwrap();
        for sec in 0..20 {
            writer.write("/a", false, time(sec), &text(&"y".repeat(200))).unwrap();
        }
        writer.finish().unwrap();
        let mut bytes = fs::read(&path).unwrap();
        // Most of the first 4 kB is padding: damage to it would test nothing.
        for (at, value) in changes {
            let at = if at > 200 { at + 3900 } else { at };
            if let Some(byte) = bytes.get_mut(at) {
                *byte = value;
            }
        }
        bytes.truncate(cut);
        fs::write(&path, bytes).unwrap();
        if let Ok(bag) = Bag::open(&path) {
            prop_assert!(bag.messages(|_| true).count() <= 60);
        }
    }
}
