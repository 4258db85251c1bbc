//! Bag files: which topics are in one, and their messages in the order of time.
//!
//! A bag is a row of chunks, each with some messages, and an index at its end; the crate `rosbag` reads both. Chunks
//! may overlap in time, so messages are merged: a chunk is unpacked once the iteration reaches the time of its first
//! message. However long the bag, only the chunks that overlap are in memory.
//!
//! `rosbag` panics on a file whose header points outside of it and allocates whatever length a chunk announces, so
//! [`record`] checks both first. Writing bags, which only tests do, is in the crate `rcs_test_support`.

#![forbid(unsafe_code)]

mod record;

use rcs_messages::Time;
use record::ChunkHeaders;
use rosbag::{ChunkRecord, IndexRecord, MessageRecord, RosBag};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Why a bag, or a part of it, cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}")]
    File {
        /// The bag.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// It does not begin as a bag does.
    #[error("{path}: not a ROS bag of version 2.0")]
    NotABag {
        /// The file.
        path: PathBuf,
    },
    /// The recorder was killed before it wrote the index, or the file is cut off.
    #[error("{path}: no index, the bag was not closed or is cut off: run `rosbag reindex` on it")]
    NoIndex {
        /// The bag.
        path: PathBuf,
    },
    /// A part of it is damaged.
    #[error("{path}: damaged at byte {at}: {reason}")]
    Damaged {
        /// The bag.
        path: PathBuf,
        /// Offset in the file.
        at: u64,
        /// What is wrong there.
        reason: String,
    },
}

/// A topic of a bag, of one publisher.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The topic's whole name.
    pub topic: Arc<str>,
    /// `package/Name`.
    pub ros_type: Arc<str>,
    /// The checksum of the type's definition, in hexadecimal.
    pub md5sum: String,
    /// Name of the publishing node; empty when it was not recorded.
    pub publisher: Arc<str>,
    /// Whether the publisher latched its messages.
    pub latching: bool,
}

/// A topic's whole name in a bag, without remapping: names without a slash are below the root.
///
/// ```
/// assert_eq!([rcs_bag::full_name("tf"), rcs_bag::full_name("/tf")], ["/tf", "/tf"]);
/// ```
pub fn full_name(topic: &str) -> String {
    format!("/{}", topic.trim_start_matches('/'))
}

/// A message of a bag.
#[derive(Clone, Debug)]
pub struct BagMessage {
    /// When it was recorded.
    pub time: Time,
    /// The topic and its publisher.
    pub connection: Arc<Connection>,
    /// Its bytes, serialised as the connection's type.
    pub bytes: Vec<u8>,
}

/// A bag file whose index was read.
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
pub struct Bag {
    file: Arc<BagFile>,
    connections: BTreeMap<u32, Arc<Connection>>,
    chunks: Vec<ChunkRef>,
}

struct BagFile {
    path: PathBuf,
    bag: RosBag,
    headers: ChunkHeaders,
}

#[derive(Clone, Debug)]
struct ChunkRef {
    at: u64,
    start_nanos: i64,
    end_nanos: i64,
    /// Ids of the connections with messages in it.
    connections: Vec<u32>,
}

impl Bag {
    /// Opens a bag and reads its index.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, BagError> {
        let path = path.as_ref().to_owned();
        let from_file = |source| BagError::File { path: path.clone(), source };
        let not_a_bag = |_| BagError::NotABag { path: path.clone() };
        let headers = ChunkHeaders::open(&path).map_err(from_file)?;
        let (first_record, index_at) = headers.bag_header().map_err(not_a_bag)?;
        if index_at < first_record || index_at > headers.file_len() {
            return Err(BagError::NoIndex { path });
        }
        let bag = RosBag::new(&path).map_err(not_a_bag)?;
        let file = BagFile { path, bag, headers };
        let (connections, chunks) = file.read_index(index_at)?;
        Ok(Self { file: Arc::new(file), connections, chunks })
    }

    /// Its topics, one connection for each publisher of a topic.
    pub fn connections(&self) -> impl Iterator<Item = &Arc<Connection>> {
        self.connections.values()
    }

    /// The times of the first and the last message by the index, unless there is none. The first is not after the last.
    pub fn time_range(&self) -> Option<(Time, Time)> {
        let start = self.chunks.iter().map(|chunk| chunk.start_nanos).min()?;
        let end = self.chunks.iter().map(|chunk| chunk.end_nanos).max()?;
        Some((Time::from_nanos(start), Time::from_nanos(end)))
    }

    /// The messages of the wanted topics in the order of time, those of the same time in the order of the file.
    ///
    /// A damaged chunk is an error among the items; its readable messages and the other chunks are still returned.
    pub fn messages(&self, wanted: impl Fn(&Connection) -> bool) -> Messages {
        let connections: BTreeMap<_, _> = (self.connections.iter())
            .filter(|(_, connection)| wanted(connection))
            .map(|(id, connection)| (*id, Arc::clone(connection)))
            .collect();
        let has_wanted = |chunk: &&ChunkRef| chunk.connections.iter().any(|id| connections.contains_key(id));
        let mut chunks: Vec<_> = self.chunks.iter().filter(has_wanted).cloned().collect();
        chunks.sort_by_key(|chunk| Reverse((chunk.start_nanos, chunk.at)));
        Messages { file: Arc::clone(&self.file), connections, chunks, errors: Vec::new(), waiting: BinaryHeap::new() }
    }
}

type Index = (BTreeMap<u32, Arc<Connection>>, Vec<ChunkRef>);

impl BagFile {
    fn read_index(&self, index_at: u64) -> Result<Index, BagError> {
        let mut connections = BTreeMap::new();
        let mut chunks = Vec::new();
        let end = self.headers.file_len();
        self.headers.check_no_chunk(index_at, end).map_err(|error| self.damaged(index_at, &error))?;
        for record in self.bag.index_records() {
            match record.map_err(|error| self.damaged(index_at, &error))? {
                IndexRecord::Connection(found) => {
                    let connection = Connection {
                        topic: found.storage_topic.into(),
                        ros_type: found.tp.into(),
                        md5sum: hexadecimal(&found.md5sum),
                        publisher: found.caller_id.into(),
                        latching: found.latching,
                    };
                    connections.insert(found.id, Arc::new(connection));
                }
                IndexRecord::ChunkInfo(info) => {
                    // A damaged index may say that a chunk ends before it begins.
                    let (one, other) = (nanos(info.start_time), nanos(info.end_time));
                    chunks.push(ChunkRef {
                        at: info.chunk_pos,
                        start_nanos: one.min(other),
                        end_nanos: one.max(other),
                        connections: info.entries().map(|entry| entry.conn_id).collect(),
                    });
                }
                IndexRecord::IndexData(_) => {}
            }
        }
        Ok((connections, chunks))
    }

    fn damaged(&self, at: u64, reason: &dyn std::fmt::Display) -> BagError {
        BagError::Damaged { path: self.path.clone(), at, reason: reason.to_string() }
    }
}

/// Iterates over the messages of a bag, see [`Bag::messages`].
pub struct Messages {
    file: Arc<BagFile>,
    connections: BTreeMap<u32, Arc<Connection>>,
    /// Those not unpacked yet, the earliest last.
    chunks: Vec<ChunkRef>,
    errors: Vec<BagError>,
    waiting: BinaryHeap<Reverse<Waiting>>,
}

/// A message of an unpacked chunk. Its order is that of time, then of the file.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting {
    nanos: i64,
    chunk_at: u64,
    index: usize,
    connection: u32,
    bytes: Vec<u8>,
}

impl Messages {
    fn unpack(&mut self, at: u64) -> Result<(), BagError> {
        let file = &self.file;
        file.headers.check_chunk(at).map_err(|error| file.damaged(at, &error))?;
        let mut records = file.bag.chunk_records();
        records.seek(at).map_err(|error| file.damaged(at, &error))?;
        let Some(Ok(ChunkRecord::Chunk(chunk))) = records.next() else {
            return Err(file.damaged(at, &"the chunk cannot be unpacked"));
        };
        for (index, record) in chunk.messages().enumerate() {
            // After a damaged record the next would be read from the wrong place.
            let record = record.map_err(|error| file.damaged(at, &error))?;
            let MessageRecord::MessageData(message) = record else {
                continue;
            };
            if self.connections.contains_key(&message.conn_id) {
                self.waiting.push(Reverse(Waiting {
                    nanos: nanos(message.time),
                    chunk_at: at,
                    index,
                    connection: message.conn_id,
                    bytes: message.data.to_vec(),
                }));
            }
        }
        Ok(())
    }

    /// Unpacks every chunk that may have a message before the first waiting one.
    fn unpack_due(&mut self) {
        while let Some(next) = self.chunks.last() {
            let due = (self.waiting.peek()).is_none_or(|Reverse(first)| next.start_nanos <= first.nanos);
            if !due {
                break;
            }
            let at = next.at;
            self.chunks.pop();
            if let Err(error) = self.unpack(at) {
                self.errors.push(error);
            }
        }
    }
}

impl Iterator for Messages {
    type Item = Result<BagMessage, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.unpack_due();
        if let Some(error) = self.errors.pop() {
            return Some(Err(error));
        }
        let Reverse(first) = self.waiting.pop()?;
        let connection = Arc::clone(self.connections.get(&first.connection)?);
        Some(Ok(BagMessage { time: Time::from_nanos(first.nanos), connection, bytes: first.bytes }))
    }
}

/// Nanoseconds that a stamp can hold: one of damaged bytes may have more nanoseconds than fit into its last second.
fn nanos(time: u64) -> i64 {
    const LAST: i64 = u32::MAX as i64 * 1_000_000_000 + 999_999_999;
    i64::try_from(time).map_or(LAST, |time| time.min(LAST))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
