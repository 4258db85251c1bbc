//! Messages of a bag in the order of time.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use rcs_messages::Time;

use crate::chunked::{ChunkRef, Chunked};
use crate::connection::Connection;
use crate::error::BagError;

/// A message of a bag.
#[derive(Clone, Debug)]
pub struct BagMessage {
    /// Recording time.
    pub time: Time,
    /// The topic and its publisher.
    pub connection: Arc<Connection>,
    /// Serialised as the connection's type.
    pub bytes: Vec<u8>,
}

/// Connections by file number and id.
pub(crate) type Connections = BTreeMap<(usize, u32), Arc<Connection>>;

/// A chunk, and the number of its file.
#[derive(Clone, Debug)]
pub(crate) struct FileChunk {
    pub(crate) file: usize,
    pub(crate) chunk: ChunkRef,
}

/// Iterates over the messages of a bag, see [`Bag::messages`](crate::Bag::messages).
#[derive(Debug)]
pub struct Messages {
    files: Arc<[Box<dyn Chunked>]>,
    connections: Connections,
    /// Earliest recording time.
    from_nanos: i64,
    /// Chunks not unpacked yet, the earliest last.
    chunks: Vec<FileChunk>,
    errors: Vec<BagError>,
    unpacked: BinaryHeap<Reverse<UnpackedMessage>>,
}

/// A message of an unpacked chunk, ordered by time, then by file, then by its place in the file.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct UnpackedMessage {
    nanos: i64,
    file: usize,
    chunk_at: u64,
    index: usize,
    connection: u32,
    bytes: Vec<u8>,
}

impl Messages {
    /// Messages of these connections from a time on, after `errors`.
    pub(crate) fn new(
        files: Arc<[Box<dyn Chunked>]>,
        connections: Connections,
        chunks: &[FileChunk],
        from: Time,
        errors: Vec<BagError>,
    ) -> Self {
        let from_nanos = from.nanos();
        let is_wanted = |FileChunk { file, chunk }: &&FileChunk| {
            chunk.end_nanos >= from_nanos && chunk.connections.iter().any(|id| connections.contains_key(&(*file, *id)))
        };
        let mut chunks: Vec<_> = chunks.iter().filter(is_wanted).cloned().collect();
        chunks.sort_by_key(|FileChunk { file, chunk }| Reverse((chunk.start_nanos, *file, chunk.at)));
        Self { files, connections, from_nanos, chunks, errors, unpacked: BinaryHeap::new() }
    }

    fn unpack(&mut self, file: usize, at: u64) {
        let Self { files, connections, from_nanos, errors, unpacked, .. } = self;
        let Some(chunked) = files.get(file) else { return };
        let mut index = 0;
        let is_wanted = |connection| connections.contains_key(&(file, connection));
        let result = chunked.unpack(at, &is_wanted, &mut |message| {
            if message.nanos >= *from_nanos && is_wanted(message.connection) {
                let (nanos, connection, bytes) = (message.nanos, message.connection, message.bytes.to_vec());
                unpacked.push(Reverse(UnpackedMessage { nanos, file, chunk_at: at, index, connection, bytes }));
            }
            index += 1;
        });
        errors.extend(result.err());
    }

    /// Unpacks every chunk that may have a message before the first unpacked one.
    fn unpack_due(&mut self) {
        while let Some(FileChunk { file, chunk }) = self.chunks.last() {
            let due = (self.unpacked.peek()).is_none_or(|Reverse(first)| chunk.start_nanos <= first.nanos);
            if !due {
                break;
            }
            let (file, at) = (*file, chunk.at);
            self.chunks.pop();
            self.unpack(file, at);
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
        let Reverse(first) = self.unpacked.pop()?;
        let connection = Arc::clone(self.connections.get(&(first.file, first.connection))?);
        Some(Ok(BagMessage { time: Time::from_nanos(first.nanos), connection, bytes: first.bytes }))
    }
}
