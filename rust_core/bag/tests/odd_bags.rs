//! Bags as others record them: topics of any type, encrypted ones, split recordings.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use rcs_bag::*;
use rcs_messages::std_msgs::String as Text;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{Message, MessageKind, Time};
use rcs_test_support::BagWriter;

fn time(sec: u32) -> Time {
    Time { sec, nsec: 5 }
}

/// A bag with `/odd` (std_msgs/String) and `/tf`, and changes to all places with certain bytes, which keep their
/// length: the connections are in a chunk and in the index.
fn bag_with(folder: &Path, changes: &[(&[u8], &[u8])]) -> PathBuf {
    let path = folder.join("odd.bag");
    let mut writer = BagWriter::create(&path).unwrap();
    writer.write("/odd", false, time(1), &Text { data: "one".to_owned() }).unwrap();
    writer.write("/tf", false, time(2), &TFMessage::default()).unwrap();
    writer.write("/odd", false, time(3), &Text { data: "two".to_owned() }).unwrap();
    writer.finish().unwrap();
    let mut bytes = fs::read(&path).unwrap();
    for (old, new) in changes {
        assert_eq!(old.len(), new.len());
        let places: Vec<usize> = (0..bytes.len() - old.len()).filter(|at| bytes[*at..].starts_with(old)).collect();
        assert!(!places.is_empty());
        places.into_iter().for_each(|at| bytes[at..at + new.len()].copy_from_slice(new));
    }
    fs::write(&path, bytes).unwrap();
    path
}

fn topics_and_secs(bag: &Bag) -> Vec<(String, u32)> {
    let messages = bag.messages(|_| true).map(Result::unwrap);
    messages.map(|message| (message.connection.topic.to_string(), message.time.sec)).collect()
}

fn connection(bag: &Bag, topic: &str) -> Connection {
    Connection::clone(bag.connections().find(|connection| &*connection.topic == topic).unwrap())
}

#[test]
fn a_definition_in_latin_1_and_an_md5sum_of_a_star_leave_a_bag_whole() {
    let folder = tempfile::tempdir().unwrap();
    let md5sum = [b"md5sum=", Text::md5sum().as_bytes()].concat();
    let star = [&b"md5sum=*"[..], &[b' '; 31]].concat();
    let cases: [&[(&[u8], &[u8])]; 2] = [&[(b"string data", b"string dat\xb0")], &[(&md5sum, &star)]];
    for changes in cases {
        let bag = Bag::open(bag_with(folder.path(), changes)).unwrap();
        let expected = [("/odd", 1), ("/tf", 2), ("/odd", 3)].map(|(topic, sec)| (topic.to_owned(), sec));
        assert_eq!(topics_and_secs(&bag), expected);
        assert_eq!(&*connection(&bag, "/odd").ros_type, "std_msgs/String");
    }
    assert_eq!(connection(&Bag::open(folder.path().join("odd.bag")).unwrap(), "/odd").md5sum, "");
}

#[test]
fn a_connection_without_a_topic_is_left_out_and_all_others_are_read() {
    let folder = tempfile::tempdir().unwrap();
    for broken in [(&b"topic=/odd"[..], &b"tapic=/odd"[..]), (b"topic=/odd", b"topic\xff/odd")] {
        let bag = Bag::open(bag_with(folder.path(), &[broken])).unwrap();
        assert_eq!(topics_and_secs(&bag), [("/tf".to_owned(), 2)]);
    }
}

#[test]
fn types_are_compared_by_md5sum_and_by_name_where_there_is_none() {
    let transforms = Connection {
        topic: "/tf".into(),
        ros_type: "tf2_msgs/TFMessage".into(),
        md5sum: MessageKind::TFMessage.md5sum(),
        publisher: "".into(),
        latching: false,
    };
    let holds = |connection: &Connection| MessageKind::ALL.iter().filter(|kind| connection.holds(**kind)).count();
    assert!(transforms.holds(MessageKind::TFMessage) && holds(&transforms) == 1);
    // The name of before tf2; the same definition.
    let old = Connection { ros_type: "tf/tfMessage".into(), ..transforms.clone() };
    assert!(old.holds(MessageKind::TFMessage) && old.kind() == Some(MessageKind::TFMessage));
    let other = Connection { md5sum: "0".repeat(32), ..transforms.clone() };
    assert!(holds(&other) == 0 && other.kind().is_none());
    let said = other.held();
    assert!(said.contains("another version of tf2_msgs/TFMessage (md5sum 0000"), "{said}");
    assert!(said.contains(&transforms.md5sum), "{said}");
    let unknown = Connection { md5sum: String::new(), ..transforms };
    assert!(unknown.holds(MessageKind::TFMessage) && unknown.kind() == Some(MessageKind::TFMessage));
    assert_eq!(unknown.held(), "tf2_msgs/TFMessage");
    assert!(!Connection { ros_type: "my/Type".into(), ..unknown }.holds(MessageKind::TFMessage));
}

#[test]
fn an_encrypted_bag_is_named_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let path = bag_with(folder.path(), &[]);
    let bytes = fs::read(&path).unwrap();
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let header_end = 17 + u32_at(13) as usize;
    for (encryptor, is_encrypted) in [("rosbag/AesCbcEncryptor", true), ("rosbag/NoEncryptor", false)] {
        let value = format!("encryptor={encryptor}");
        let field = [&u32::try_from(value.len()).unwrap().to_le_bytes()[..], value.as_bytes()].concat();
        let added = u32::try_from(field.len()).unwrap();
        // One more field in the bag's header, and so much less padding behind it.
        let mut changed = bytes.clone();
        changed[13..17].copy_from_slice(&(u32_at(13) + added).to_le_bytes());
        changed[header_end..header_end + 4].copy_from_slice(&(u32_at(header_end) - added).to_le_bytes());
        changed.drain(header_end + 4..header_end + 4 + field.len());
        changed.splice(header_end..header_end, field);
        fs::write(&path, changed).unwrap();
        match Bag::open(&path) {
            Ok(bag) => assert!(!is_encrypted && topics_and_secs(&bag).len() == 3),
            Err(error) => {
                let said = error.to_string();
                assert!(is_encrypted && said.contains("odd.bag: encrypted by rosbag/AesCbcEncryptor"), "{said}");
                assert!(said.contains("rosbag decrypt"), "{said}");
            }
        }
    }
}

/// Three parts of a recording, in which `/a` has a message every second.
fn split_recording(folder: &Path) -> [PathBuf; 3] {
    [0, 1, 2].map(|part| {
        let path = folder.join(format!("part_{part}.bag"));
        let mut writer = BagWriter::create(&path).unwrap();
        for sec in [3 * part, 3 * part + 1, 3 * part + 3] {
            writer.write("/a", false, time(sec), &Text { data: format!("{part}") }).unwrap();
        }
        writer.finish().unwrap();
        path
    })
}

#[test]
fn several_bags_are_read_as_one_in_the_order_of_time() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second, third] = split_recording(folder.path());
    for order in [[&first, &second, &third], [&third, &first, &second]] {
        let bag = Bag::open_all(&order).unwrap();
        assert_eq!(bag.time_range(), Some((time(0), time(9))));
        let secs: Vec<u32> = topics_and_secs(&bag).into_iter().map(|(_, sec)| sec).collect();
        assert_eq!(secs, [0, 1, 3, 3, 4, 6, 6, 7, 9]);
    }
    let error = Bag::open_all(&[&first, &folder.path().join("part_3.bag")]).unwrap_err().to_string();
    assert!(error.contains("part_3.bag"), "{error}");
}

#[test]
fn messages_from_a_time_on_come_from_the_chunks_that_reach_so_far() {
    let folder = tempfile::tempdir().unwrap();
    let paths = split_recording(folder.path());
    let bag = Bag::open_all(&paths).unwrap();
    // The first part would be an error if it was read; its index was.
    let len = fs::metadata(&paths[0]).unwrap().len();
    fs::write(&paths[0], vec![0; usize::try_from(len).unwrap()]).unwrap();
    let secs: Vec<u32> = bag.messages_from(time(4), |_| true).map(|message| message.unwrap().time.sec).collect();
    assert_eq!(secs, [4, 6, 6, 7, 9]);
    assert!(bag.messages(|_| true).any(|message| message.is_err()));
}

#[test]
fn topics_get_their_new_names_all_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = bag_with(folder.path(), &[]);
    let names = [("/odd", "/tf"), ("/tf", "/odd"), ("/none", "/a")].map(|(from, to)| (from.to_owned(), to.to_owned()));
    let bag = Bag::open(path).unwrap().remapped(&HashMap::from(names));
    let expected = [("/tf", 1), ("/odd", 2), ("/tf", 3)].map(|(topic, sec)| (topic.to_owned(), sec));
    assert_eq!(topics_and_secs(&bag), expected);
    assert_eq!(&*connection(&bag, "/tf").ros_type, "std_msgs/String");
}
