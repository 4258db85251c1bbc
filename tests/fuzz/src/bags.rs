//! Bags, and the messages in them.

use std::path::Path;

use rcs_bag::Bag;
use rcs_messages::MessageKind;
use tempfile::TempDir;

/// More messages than an input can hold, unless chunks are compressed.
const MOST_MESSAGES: usize = 1000;

/// A bag: its index, and its messages in order.
pub(crate) fn bag(data: &[u8]) {
    thread_local! {
        static FOLDER: TempDir = tempfile::tempdir().unwrap_or_else(|error| panic!("no temporary folder: {error}"));
    }
    FOLDER.with(|folder| {
        let path = folder.path().join("fuzz.bag");
        std::fs::write(&path, data).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        read(&path);
    });
}

fn read(path: &Path) {
    let bag = match Bag::open(path) {
        Ok(bag) => bag,
        Err(error) => {
            assert!(error.to_string().contains("fuzz.bag"));
            return;
        }
    };
    assert!(bag.time_range().is_none_or(|(start, end)| (start.sec, start.nsec) <= (end.sec, end.nsec)));
    for message in bag.messages(|_| true).take(MOST_MESSAGES) {
        match message {
            Ok(message) => {
                if let Some(kind) = MessageKind::from_ros_type(&message.connection.ros_type) {
                    let _ = kind.decode_owned(message.bytes);
                }
            }
            Err(error) => assert!(error.to_string().contains("fuzz.bag")),
        }
    }
}
