//! Bags, one or several: which topics are in them, and their messages in the order of time.
//!
//! A bag is a row of chunks, each with some messages, and an index at its end. Chunks may overlap in time, most of all
//! those of several files, so messages are merged: a chunk is unpacked once the iteration reaches the time of its first
//! message. However long the bag, only the chunks that overlap are in memory. Two formats are read, each by a module
//! that knows nothing of the merging: ROS 1's own (`rosbag_file`), and MCAP with messages of ROS 1 (`mcap_file`).
//!
//! Each length that a file announces is compared with its own before memory is taken. Writing bags, which only tests
//! do, is in the crate `rcs_test_support`.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bounded_file;
mod chunked;
mod compression;
mod connection;
mod error;
mod mcap_file;
mod messages;
mod rosbag_file;

pub use connection::{full_name, Connection, Held};
pub use error::BagError;
pub use messages::{BagMessage, Messages};

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use bounded_file::BoundedFile;
use chunked::{Chunked, Index};
use mcap_file::McapFile;
use messages::{Connections, FileChunk};
use rcs_messages::Time;
use rosbag_file::RosbagFile;

/// Bags whose indices were read, as if they were one.
///
/// ```
/// use rcs_bag::Bag;
/// use rcs_messages::{std_msgs, MessageKind, Time};
/// # use rcs_test_support::BagWriter;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("scene.bag");
/// # let mut writer = BagWriter::create(&path)?;
/// # writer.write("/greeting", false, Time { sec: 1, nsec: 0 }, &std_msgs::String { data: "hello".to_owned() })?;
/// # writer.finish()?;
/// let bag = Bag::open(&path)?;
/// for message in bag.messages(|connection| &*connection.topic == "/greeting") {
///     let message = message?;
///     let text: std_msgs::String = rcs_messages::decode(&message.bytes)?;
///     println!("{} at {:?}: {}", message.connection.topic, message.time, text.data);
///     # assert_eq!((text.data.as_str(), message.time.sec), ("hello", 1));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Bag {
    files: Arc<[Box<dyn Chunked>]>,
    connections: Connections,
    chunks: Vec<FileChunk>,
}

impl Bag {
    /// Opens a bag and reads its index.
    ///
    /// # Errors
    /// [`BagError`]: the file cannot be read, is no bag, was not closed, is encrypted or damaged.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, BagError> {
        Self::open_all(&[path])
    }

    /// Opens several bags, such as the parts of a split recording, in any order.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_all(paths: &[impl AsRef<Path>]) -> Result<Self, BagError> {
        let (mut files, mut connections, mut chunks) = (Vec::new(), Connections::new(), Vec::new());
        for (number, path) in paths.iter().enumerate() {
            let (file, index) = open_file(path.as_ref())?;
            files.push(file);
            connections.extend(index.connections.into_iter().map(|(id, one)| ((number, id), Arc::new(one))));
            chunks.extend(index.chunks.into_iter().map(|chunk| FileChunk { file: number, chunk }));
        }
        Ok(Self { files: files.into(), connections, chunks })
    }

    /// Gives topics other names, as `rosbag play` does: the bag's name, and the one that takes its place. Names are
    /// whole; those of topics that the bag does not have are ignored.
    #[must_use]
    pub fn remapped(mut self, names: &HashMap<String, String>) -> Self {
        for connection in self.connections.values_mut() {
            if let Some(name) = names.get(&full_name(&connection.topic)) {
                Arc::make_mut(connection).topic = name.as_str().into();
            }
        }
        self
    }

    /// Its topics, one connection for each publisher of a topic.
    pub fn connections(&self) -> impl Iterator<Item = &Arc<Connection>> {
        self.connections.values()
    }

    /// The times at which the first and the last message were recorded by the index, unless there is none. The first is
    /// not after the last.
    pub fn time_range(&self) -> Option<(Time, Time)> {
        let start = self.chunks.iter().map(|FileChunk { chunk, .. }| chunk.start_nanos).min()?;
        let end = self.chunks.iter().map(|FileChunk { chunk, .. }| chunk.end_nanos).max()?;
        Some((Time::from_nanos(start), Time::from_nanos(end)))
    }

    /// The messages of the wanted topics in the order of time, those of the same time in the order of the files.
    ///
    /// A damaged chunk is an error among the items; its readable messages and the other chunks are still returned.
    pub fn messages(&self, wanted: impl Fn(&Connection) -> bool) -> Messages {
        self.messages_from(Time::default(), wanted)
    }

    /// As [`messages`](Self::messages), without those that were recorded before a time. Chunks that end before it are
    /// not read.
    pub fn messages_from(&self, from: Time, wanted: impl Fn(&Connection) -> bool) -> Messages {
        let is_wanted = |(_, connection): &(_, &Arc<Connection>)| wanted(connection);
        let connections = self.connections.iter().filter(is_wanted).map(|(id, one)| (*id, Arc::clone(one))).collect();
        Messages::new(Arc::clone(&self.files), connections, &self.chunks, from)
    }
}

fn open_file(path: &Path) -> Result<(Box<dyn Chunked>, Index), BagError> {
    let file = BoundedFile::open(path.to_owned())?;
    let begins_with = |magic: &[u8]| file.read(0, magic.len() as u64).is_ok_and(|bytes| bytes == magic);
    if begins_with(rosbag_file::MAGIC) {
        let (file, index) = RosbagFile::open(file)?;
        Ok((Box::new(file), index))
    } else if begins_with(mcap_file::MAGIC) {
        let (file, index) = McapFile::open(file)?;
        Ok((Box::new(file), index))
    } else {
        Err(BagError::NotABag { path: file.path })
    }
}
