//! Opening bags and listing their topics.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use rcs_messages::Time;
use rcs_text::full_name;

use crate::bounded_file::BoundedFile;
use crate::chunked::{Chunked, Index};
use crate::connection::Connection;
use crate::error::BagError;
use crate::mcap_index;
use crate::messages::{Connections, FileChunk, Messages};
use crate::rosbag_file::{self, RosbagFile};

/// One or several bags, read as one.
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
    /// Channels and schemas that messages refer to and the files lack, one line each.
    problems: Vec<BagError>,
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
        let mut problems = Vec::new();
        for (number, path) in paths.iter().enumerate() {
            let (file, index) = open_file(path.as_ref())?;
            files.push(file);
            connections.extend(index.connections.into_iter().map(|(id, one)| ((number, id), Arc::new(one))));
            chunks.extend(index.chunks.into_iter().map(|chunk| FileChunk { file: number, chunk }));
            problems.extend(index.problems);
        }
        Ok(Self { files: files.into(), connections, chunks, problems })
    }

    /// Renames topics as `rosbag play` does, by whole names; unknown ones are ignored.
    #[must_use]
    pub fn remapped(mut self, names: &HashMap<String, String>) -> Self {
        for connection in self.connections.values_mut() {
            if let Some(name) = names.get(&full_name(&connection.topic)) {
                Arc::make_mut(connection).topic = name.as_str().into();
            }
        }
        self
    }

    /// One connection for each publisher of each topic.
    pub fn connections(&self) -> impl Iterator<Item = &Arc<Connection>> {
        self.connections.values()
    }

    /// Recording times of the first and the last message by the index; `None` without messages. The first is not after
    /// the last.
    pub fn time_range(&self) -> Option<(Time, Time)> {
        // A chunk without messages has no times.
        let chunks = || self.chunks.iter().map(|one| &one.chunk).filter(|chunk| !chunk.connections.is_empty());
        let start = chunks().map(|chunk| chunk.start_nanos).min()?;
        let end = chunks().map(|chunk| chunk.end_nanos).max()?;
        Some((Time::from_nanos(start), Time::from_nanos(end)))
    }

    /// Messages of the wanted topics in the order of time, and of the files at the same time.
    ///
    /// A damaged chunk is an error among the items, and so is what a file lacks; readable messages are still returned.
    pub fn messages(&self, wanted: impl Fn(&Connection) -> bool) -> Messages {
        self.messages_from(Time::default(), wanted)
    }

    /// Messages as of [`messages`](Self::messages) from a recording time on. Chunks that end before it are not read.
    pub fn messages_from(&self, from: Time, wanted: impl Fn(&Connection) -> bool) -> Messages {
        let is_wanted = |(_, connection): &(_, &Arc<Connection>)| wanted(connection);
        let connections = self.connections.iter().filter(is_wanted).map(|(id, one)| (*id, Arc::clone(one))).collect();
        Messages::new(Arc::clone(&self.files), connections, &self.chunks, from, self.problems.clone())
    }
}

fn open_file(path: &Path) -> Result<(Box<dyn Chunked>, Index), BagError> {
    let file = BoundedFile::open(path.to_owned())?;
    let begins_with = |magic: &[u8]| file.read(0, magic.len() as u64).is_ok_and(|bytes| bytes == magic);
    if begins_with(rosbag_file::MAGIC) {
        let (file, index) = RosbagFile::open(file)?;
        Ok((Box::new(file), index))
    } else if begins_with(mcap::MAGIC) {
        let (file, index) = mcap_index::open(file)?;
        Ok((Box::new(file), index))
    } else {
        Err(BagError::no_bag(&file.path))
    }
}
