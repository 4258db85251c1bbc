//! MCAP files: those of Foxglove's Python writer in `data` (six texts, every other on `/a` and `/b`, a second apart
//! from 10 s on, in chunks of one; written by `mcap_ros1.writer.Writer`), and some written here, whole and damaged.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

use mcap::WriteOptions;
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
    write_with(path, encoding, secs, |options| options);
}

fn write_with(path: &Path, encoding: &str, secs: &[u32], change: impl Fn(WriteOptions) -> WriteOptions) {
    let mut writer = McapWriter::create_with(path, 100, change).unwrap();
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
fn a_file_that_was_not_closed_is_an_error_that_names_mcap_recover() {
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

type Change = fn(WriteOptions) -> WriteOptions;
const WITHOUT_CHUNKS: Change = |options| options.use_chunks(false);
const WITHOUT_SUMMARY: Change = |options| options.emit_summary_records(false);

#[test]
fn each_part_that_a_writer_may_leave_out_is_done_without() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let changes: [(&str, Change); 11] = [
        ("chunks", WITHOUT_CHUNKS),
        ("summary", WITHOUT_SUMMARY),
        ("chunks, summary", |options| WITHOUT_SUMMARY(WITHOUT_CHUNKS(options))),
        ("chunk indexes", |options| options.emit_chunk_indexes(false)),
        ("message indexes", |options| options.emit_message_indexes(false)),
        ("both indexes", |options| options.emit_message_indexes(false).emit_chunk_indexes(false)),
        ("statistics", |options| options.emit_statistics(false)),
        ("channels", |options| options.repeat_channels(false)),
        ("schemas", |options| options.repeat_schemas(false)),
        ("definitions", |options| options.repeat_channels(false).repeat_schemas(false)),
        ("definitions, statistics, message indexes", |options| {
            options.repeat_channels(false).repeat_schemas(false).emit_statistics(false).emit_message_indexes(false)
        }),
    ];
    for (name, change) in changes {
        write_with(&path, "ros1", &[1, 5, 9, 2, 6, 3], change);
        let bag = Bag::open(&path).unwrap();
        assert_eq!(bag.time_range(), Some((at(1), at(9))), "{name}");
        let read = texts(&bag, |connection| &*connection.topic == "/a" && &*connection.ros_type == "std_msgs/String");
        assert_eq!(read, [1, 2, 3, 5, 6, 9].map(|sec| (sec, format!("at {sec}"))), "{name}");
        write_with(&path, "cdr", &[1], change);
        assert!(Bag::open(&path).unwrap_err().to_string().contains("encoded as cdr"), "{name}");
    }
}

#[test]
fn a_channel_or_schema_that_the_file_does_not_have_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    for (kind, expected) in [(4, "a.mcap: no record of channel "), (3, "a.mcap: no schema 1 of /a,")] {
        write_with(&path, "ros1", &[1, 2], |options| WITHOUT_SUMMARY(WITHOUT_CHUNKS(options)));
        let mut bytes = fs::read(&path).unwrap();
        let mut at = 8;
        while bytes[at] != kind {
            at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        }
        // A kind that nobody knows.
        bytes[at] = 0x80;
        fs::write(&path, bytes).unwrap();
        let items: Vec<_> = Bag::open(&path).unwrap().messages(|one| one.kind().is_some()).collect();
        let error = items.into_iter().map(|item| item.unwrap_err().to_string()).collect::<Vec<_>>();
        assert!(error.len() == 1 && error[0].contains(expected) && error[0].contains("are not read"), "{error:?}");
    }
}

/// A record of an MCAP file.
fn record(kind: u8, content: &[u8]) -> Vec<u8> {
    [&[kind][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

fn counted(text: &[u8]) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text].concat()
}

/// A part of a file that is written here.
enum Part {
    /// A chunk of texts at these times, with other times in its record and in the index if given.
    Chunk(&'static [u64], Option<[u64; 2]>),
    /// Messages without a chunk.
    Loose(&'static [u64]),
}

/// A file of texts on `/a`, whose chunks are all in its index.
fn file_of(parts: &[Part]) -> Vec<u8> {
    const NANOS: u64 = 1_000_000_000;
    let schema = [&1_u16.to_le_bytes()[..], &counted(b"std_msgs/String"), &counted(b"ros1msg"), &counted(b"")].concat();
    let channel = [&[0, 0, 1, 0][..], &counted(b"/a"), &counted(b"ros1"), &counted(b"")].concat();
    let definitions = [record(3, &schema), record(4, &channel)].concat();
    let message = |sec: &u64| {
        let (time, text) = ((sec * NANOS).to_le_bytes(), rcs_messages::encode(&Text { data: format!("at {sec}") }));
        record(5, &[&[0; 6][..], &time, &time, &text].concat())
    };
    let mut file =
        [&b"\x89MCAP0\r\n"[..], &record(1, &[counted(b"ros1"), counted(b"")].concat()), &definitions].concat();
    let mut indexes = Vec::new();
    for part in parts {
        let (secs, times) = match part {
            Part::Chunk(secs, times) => (secs, times),
            Part::Loose(secs) => {
                file.extend(secs.iter().flat_map(message));
                continue;
            }
        };
        let own = [secs.iter().min(), secs.iter().max()].map(|sec| sec.map_or(0, |sec| sec * NANOS));
        let times = times.unwrap_or(own).map(u64::to_le_bytes).concat();
        let records: Vec<u8> = secs.iter().flat_map(message).collect();
        let len = (records.len() as u64).to_le_bytes();
        let chunk = record(6, &[&times[..], &len, &[0; 4], &counted(b""), &len, &records].concat());
        let place = [file.len() as u64, chunk.len() as u64].map(u64::to_le_bytes).concat();
        let index = [&times[..], &place, &counted(b""), &[0; 8], &counted(b""), &len, &len].concat();
        indexes.extend(record(8, &index));
        file.extend(chunk);
    }
    file.extend(record(15, &[0; 4]));
    let footer = [&(file.len() as u64).to_le_bytes()[..], &[0; 12]].concat();
    [file, definitions, indexes, record(2, &footer), b"\x89MCAP0\r\n".to_vec()].concat()
}

#[test]
fn times_are_those_of_messages_whatever_a_chunk_without_any_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    for times in [[0, 0], [u64::MAX, 0], [9, 8]] {
        let empty = || Part::Chunk(&[], Some(times));
        let swapped = Part::Chunk(&[5, 7], Some([7_000_000_000, 5_000_000_000]));
        for parts in [
            vec![empty(), Part::Chunk(&[5, 7], None)],
            vec![Part::Chunk(&[5, 7], None), empty()],
            vec![Part::Chunk(&[5], None), empty(), Part::Chunk(&[7], None)],
            vec![empty(), swapped],
            vec![Part::Chunk(&[5, 7], Some([0, 0]))],
        ] {
            fs::write(&path, file_of(&parts)).unwrap();
            let bag = Bag::open(&path).unwrap();
            assert_eq!(bag.time_range(), Some((at(5), at(7))), "{times:?}");
            assert_eq!(texts(&bag, |_| true), [5, 7].map(|sec| (sec, format!("at {sec}"))), "{times:?}");
        }
        fs::write(&path, file_of(&[empty()])).unwrap();
        assert_eq!(Bag::open(&path).unwrap().time_range(), None);
    }
    fs::write(&path, file_of(&[Part::Chunk(&[0, 3], None)])).unwrap();
    assert_eq!(Bag::open(&path).unwrap().time_range(), Some((at(0), at(3))), "messages at 0 count");
}

#[test]
fn messages_beside_indexed_chunks_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    for parts in [
        [Part::Loose(&[4, 1]), Part::Chunk(&[2, 3], None), Part::Loose(&[])],
        [Part::Chunk(&[2, 3], None), Part::Loose(&[4, 1]), Part::Chunk(&[], None)],
        [Part::Chunk(&[2], None), Part::Loose(&[4]), Part::Chunk(&[1, 3], None)],
    ] {
        fs::write(&path, file_of(&parts)).unwrap();
        let read = texts(&Bag::open(&path).unwrap(), |_| true);
        assert_eq!(read, [1, 2, 3, 4].map(|sec| (sec, format!("at {sec}"))));
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
