//! MCAP files: those of Foxglove's Python writer in `data` (six texts, every other on `/a` and `/b`, a second apart
//! from 10 s on, in chunks of one; written by `mcap_ros1.writer.Writer`), and some written here, whole and damaged.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use rcs_bag::*;
use rcs_messages::std_msgs::String as Text;
use rcs_messages::{MessageKind, Time};
use rcs_test_support::{BagWriter, McapWriter};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn at(sec: u32) -> Time {
    Time { sec, nsec: 0 }
}

fn texts(bag: &Bag, wanted: impl Fn(&Connection) -> bool) -> Vec<(u32, String)> {
    let messages = bag.messages(wanted).map(Result::unwrap);
    messages.map(|message| (message.time.sec, rcs_messages::decode::<Text>(&message.bytes).unwrap().data)).collect()
}

/// A file in which `/a` has texts at these times.
fn write(path: &Path, encoding: &str, secs: &[u32]) {
    let mut writer = McapWriter::create(path, 100).unwrap();
    for sec in secs {
        let message = rcs_messages::encode(&Text { data: format!("at {sec}") });
        writer.write("/a", "std_msgs/String", encoding, at(*sec), &message).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn files_of_both_compressions_are_read() {
    for name in ["lz4.mcap", "zstd.mcap"] {
        let bag = Bag::open(fixture(name)).unwrap();
        assert_eq!(bag.time_range(), Some((at(10), at(15))), "{name}");
        let expected = |number: u32| (10 + number, format!("message {number} {}", "x".repeat(100)));
        assert_eq!(texts(&bag, |_| true), [0, 1, 2, 3, 4, 5].map(expected), "{name}");
        assert_eq!(texts(&bag, |connection| &*connection.topic == "/a"), [1, 3, 5].map(expected), "{name}");
        let kinds: Vec<_> = bag.connections().map(|connection| connection.ros_type.to_string()).collect();
        assert_eq!(kinds, ["std_msgs/String"; 2], "{name}");
    }
}

#[test]
fn chunks_that_overlap_and_bags_beside_them_are_merged() {
    let folder = tempfile::tempdir().unwrap();
    let (mcap, bag) = (folder.path().join("a.mcap"), folder.path().join("b.bag"));
    write(&mcap, "ros1", &[1, 5, 9, 2, 6, 3]);
    let mut writer = BagWriter::create(&bag).unwrap();
    for sec in [4, 7] {
        writer.write("/b", false, at(sec), &Text { data: "of the bag".to_owned() }).unwrap();
    }
    writer.finish().unwrap();
    let both = Bag::open_all(&[mcap, bag]).unwrap();
    let secs: Vec<u32> = texts(&both, |_| true).into_iter().map(|(sec, _)| sec).collect();
    assert_eq!(secs, [1, 2, 3, 4, 5, 6, 7, 9]);
}

#[test]
fn a_topic_of_another_encoding_is_of_no_type_and_a_file_of_such_topics_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mixed.mcap");
    let mut writer = McapWriter::create(&path, 1000).unwrap();
    writer.write("/a", "std_msgs/String", "ros1", at(1), b"").unwrap();
    writer.write("/b", "sensor_msgs/PointCloud2", "json", at(1), b"{}").unwrap();
    writer.finish().unwrap();
    let bag = Bag::open(&path).unwrap();
    let json = bag.connections().find(|connection| &*connection.topic == "/b").unwrap();
    assert_eq!(json.held(), "sensor_msgs/PointCloud2 (encoded as json)");
    assert!(!json.holds(MessageKind::PointCloud2));
    write(&path, "cdr", &[1]);
    let error = Bag::open(&path).unwrap_err().to_string();
    assert!(error.contains("mixed.mcap: all messages are encoded as cdr"), "{error}");
}

#[test]
fn a_topic_that_is_no_text_is_left_out_and_all_others_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.mcap");
    let mut writer = McapWriter::create(&path, 1000).unwrap();
    for (topic, sec) in [("/a", 1), ("/odd_topic", 2), ("/a", 3)] {
        writer.write(topic, "std_msgs/String", "ros1", at(sec), &rcs_messages::encode(&Text::default())).unwrap();
    }
    writer.finish().unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let places: Vec<_> = (0..bytes.len() - 10).filter(|at| bytes[*at..].starts_with(b"/odd_topic")).collect();
    assert!(places.len() >= 2, "in the chunk and in the summary");
    places.into_iter().for_each(|at| bytes[at + 4] = 0xb0);
    fs::write(&path, bytes).unwrap();
    let secs: Vec<u32> = texts(&Bag::open(&path).unwrap(), |_| true).into_iter().map(|(sec, _)| sec).collect();
    assert_eq!(secs, [1, 3]);
}

#[test]
fn a_file_that_was_not_closed_or_has_no_chunks_is_an_error_that_names_mcap_recover() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.mcap");
    write(&path, "ros1", &[1, 2, 3]);
    let whole = fs::read(&path).unwrap();
    for len in [8, 20, 60, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..len]).unwrap();
        let error = Bag::open(&path).unwrap_err().to_string();
        assert!(error.contains("cut.mcap: no index") && error.contains("mcap recover"), "{len}: {error}");
    }
}

#[test]
fn a_chunk_that_is_gone_is_an_error_and_the_others_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hole.mcap");
    let mut bytes = fs::read(fixture("lz4.mcap")).unwrap();
    let magic = [0x04, 0x22, 0x4d, 0x18];
    let at = bytes.windows(4).position(|window| window == magic).unwrap();
    bytes[at] = 0;
    fs::write(&path, bytes).unwrap();
    let bag = Bag::open(&path).unwrap();
    let (read, failed): (Vec<_>, Vec<_>) = bag.messages(|_| true).partition(Result::is_ok);
    assert_eq!((read.len(), failed.len()), (5, 1));
    let error = failed.into_iter().next().unwrap().unwrap_err().to_string();
    assert!(error.contains("hole.mcap: damaged at byte"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_damaged_file_never_panics(
        name in prop_oneof![Just("lz4.mcap"), Just("zstd.mcap"), Just("none")],
        changes in proptest::collection::vec((0..1700_usize, any::<u8>()), 0..6),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.mcap");
        if name == "none" {
            write(&path, "ros1", &[1, 5, 9, 2, 6, 3]);
        } else {
            fs::copy(fixture(name), &path).unwrap();
        }
        let mut bytes = fs::read(&path).unwrap();
        for (at, value) in changes {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = value;
            }
        }
        fs::write(&path, bytes).unwrap();
        if let Ok(bag) = Bag::open(&path) {
            prop_assert!(bag.messages(|_| true).count() <= 60);
        }
    }
}
