//! Bags of version 2.0, which ROS 1 records.
//!
//! A record is `header length, header fields, data length, data`; a field is `length, name=value`. Chunks are records
//! that contain records; the index at the end repeats the connections and lists the chunks.
//!
//! The crate `rosbag` unpacks chunks. It takes a message definition that is not UTF-8 or an md5sum of `*` for damage,
//! and allocates whatever length a chunk announces, so the index and the headers of chunks are read here.

use std::fmt;
use std::io;

use crate::bounded_file::BoundedFile;
use crate::chunked::{nanos, ChunkRef, Chunked, Index, RawMessage};
use crate::compression::{check_len, damaged};
use crate::connection::{md5sum, Connection};
use crate::error::BagError;
use rosbag::{ChunkRecord, MessageRecord, RosBag};

/// First bytes of the file.
pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Longest header that is read; real ones have some hundred bytes.
const MAX_HEADER_LEN: u32 = 1 << 20;
/// Longest record of the index that is read: a connection with its message definition, or a chunk's connections.
const MAX_INDEX_RECORD_LEN: u32 = 16 << 20;
/// Encryptor of bags that are not encrypted.
const NO_ENCRYPTOR: &[u8] = b"rosbag/NoEncryptor";

/// Values of the field `op`.
mod op {
    pub(super) const CHUNK: &[u8] = &[5];
    pub(super) const CHUNK_INFO: &[u8] = &[6];
    pub(super) const CONNECTION: &[u8] = &[7];
}

/// A bag of version 2.0.
pub(crate) struct RosbagFile {
    file: BoundedFile,
    bag: RosBag,
}

impl fmt::Debug for RosbagFile {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("RosbagFile").field("file", &self.file).finish_non_exhaustive()
    }
}

/// A record of the file.
struct Record {
    fields: Vec<u8>,
    data_at: u64,
    data_len: u32,
}

impl Record {
    /// Offset of the next record.
    fn end(&self) -> u64 {
        self.data_at + u64::from(self.data_len)
    }
}

impl RosbagFile {
    pub(crate) fn open(file: BoundedFile) -> Result<(Self, Index), BagError> {
        let header = record(&file, MAGIC.len() as u64).map_err(|_| BagError::no_bag(&file.path))?;
        match field(&header.fields, b"encryptor") {
            None | Some(b"" | NO_ENCRYPTOR) => {}
            Some(encryptor) => {
                let encryptor = String::from_utf8_lossy(encryptor);
                let problem = format!("encrypted by {encryptor}: run `rosbag decrypt` on it");
                return Err(BagError::new(&file.path, problem));
            }
        }
        let index_at = field(&header.fields, b"index_pos").and_then(|value| value.try_into().ok());
        let index_at = u64::from_le_bytes(index_at.ok_or_else(|| BagError::no_bag(&file.path))?);
        if index_at < header.end() || index_at > file.len {
            return Err(BagError::no_index(&file.path, "rosbag reindex"));
        }
        // It was checked that the header points into the file.
        let bag = RosBag::new(&file.path).map_err(|error| BagError::new(&file.path, error))?;
        let opened = Self { file, bag };
        let index = opened.read_index(index_at).map_err(|error| opened.file.damaged(index_at, &error))?;
        Ok((opened, index))
    }

    fn read_index(&self, mut at: u64) -> io::Result<Index> {
        let mut index = Index::default();
        while at < self.file.len {
            let record = record(&self.file, at)?;
            at = record.end();
            let data = || {
                if record.data_len > MAX_INDEX_RECORD_LEN {
                    return Err(damaged("record of the index too long"));
                }
                self.file.read(record.data_at, record.data_len.into())
            };
            match field(&record.fields, b"op") {
                Some(op::CONNECTION) => {
                    // Without id or topic it belongs to no message that can be asked for.
                    if let Some((id, connection)) = data().ok().and_then(|data| connection(&record.fields, &data)) {
                        index.connections.insert(id, connection);
                    }
                }
                Some(op::CHUNK_INFO) => {
                    let info = chunk_info(&record.fields, &data()?);
                    index.chunks.push(info.ok_or_else(|| damaged("chunk info without place or times"))?);
                }
                _ => {}
            }
        }
        Ok(index)
    }

    fn visit_messages(
        &self,
        at: u64,
        wanted: &dyn Fn(u32) -> bool,
        visit: &mut dyn FnMut(RawMessage<'_>),
    ) -> io::Result<()> {
        self.check_chunk(at)?;
        let mut records = self.bag.chunk_records();
        records.seek(at).map_err(|_| damaged("chunk in the index"))?;
        let Some(Ok(ChunkRecord::Chunk(chunk))) = records.next() else {
            return Err(damaged("the chunk cannot be unpacked"));
        };
        // Behind a chunk are the offsets of each connection's messages.
        let mut offsets = Vec::new();
        for record in records {
            let Ok(ChunkRecord::IndexData(of_connection)) = record else { break };
            if wanted(of_connection.conn_id) {
                offsets.extend(of_connection.entries().map(|entry| entry.offset));
            }
        }
        if offsets.is_empty() {
            return Err(damaged("no message where the index lists some"));
        }
        offsets.sort_unstable();
        let mut messages = chunk.messages();
        for offset in offsets {
            let message = messages.seek(offset).ok().and_then(|()| messages.next());
            let Some(Ok(MessageRecord::MessageData(message))) = message else {
                return Err(damaged("a message that cannot be read"));
            };
            visit(RawMessage { connection: message.conn_id, nanos: nanos(message.time), bytes: message.data });
        }
        Ok(())
    }

    /// Checks the length that the chunk at `at` announces, and that it contains no chunk, which would be unpacked, too.
    /// The content of a packed chunk cannot be checked before it is unpacked.
    fn check_chunk(&self, at: u64) -> io::Result<()> {
        let chunk = record(&self.file, at)?;
        if field(&chunk.fields, b"op") != Some(op::CHUNK) {
            return Err(damaged("no chunk where the index lists one"));
        }
        let size = number(&chunk.fields, b"size").ok_or_else(|| damaged("chunk without size"))?;
        check_len(size.into(), chunk.data_len.into())?;
        let mut inner = chunk.data_at;
        while field(&chunk.fields, b"compression") == Some(b"none") && inner < chunk.end() {
            // A truncated record is reported when it is read.
            let Ok(within) = record(&self.file, inner) else { break };
            if field(&within.fields, b"op") == Some(op::CHUNK) {
                return Err(damaged("a chunk in a chunk"));
            }
            inner = within.end();
        }
        Ok(())
    }
}

/// The record at an offset of the file.
fn record(file: &BoundedFile, at: u64) -> io::Result<Record> {
    let length = |at: u64| {
        let bytes = file.read(at, 4)?;
        Ok::<_, io::Error>(bytes.try_into().map_or(0, u32::from_le_bytes))
    };
    let header_len = length(at)?;
    if header_len > MAX_HEADER_LEN {
        return Err(damaged("record header too long"));
    }
    let fields = file.read(at + 4, header_len.into())?;
    let header_end = at + 4 + u64::from(header_len);
    let record = Record { fields, data_at: header_end + 4, data_len: length(header_end)? };
    if record.end() > file.len {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "record reaches past the end of the file"));
    }
    Ok(record)
}

impl Chunked for RosbagFile {
    fn unpack(
        &self,
        at: u64,
        wanted: &dyn Fn(u32) -> bool,
        visit: &mut dyn FnMut(RawMessage<'_>),
    ) -> Result<(), BagError> {
        self.visit_messages(at, wanted, visit).map_err(|error| self.file.damaged(at, &error))
    }
}

/// A connection and its id. The message definition is not read: it may be in any encoding.
fn connection(header: &[u8], data: &[u8]) -> Option<(u32, Connection)> {
    let id = number(header, b"conn")?;
    let text = |value: &[u8]| String::from_utf8_lossy(value).into_owned();
    let value = |name| field(data, name).map(text).unwrap_or_default();
    let connection = Connection {
        topic: text(field(header, b"topic")?).into(),
        ros_type: value(b"type").into(),
        md5sum: md5sum(field(data, b"md5sum").unwrap_or_default()),
        publisher: value(b"callerid").into(),
        latching: field(data, b"latching") == Some(b"1"),
    };
    Some((id, connection))
}

/// A chunk with the ids of its connections, which the record lists with their numbers of messages.
fn chunk_info(header: &[u8], data: &[u8]) -> Option<ChunkRef> {
    let at = u64::from_le_bytes(field(header, b"chunk_pos")?.try_into().ok()?);
    let times = [time(field(header, b"start_time")?)?, time(field(header, b"end_time")?)?];
    let ids = data.chunks_exact(8).filter_map(|entry| Some(u32::from_le_bytes(*entry.first_chunk()?)));
    Some(ChunkRef::new(at, times, ids.collect()))
}

/// Splits off bytes that follow their length.
fn split_counted(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (len, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*len) as usize)
}

/// The value of a header's field.
fn field<'a>(mut fields: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    while let Some((field, rest)) = split_counted(fields) {
        if let Some(value) = field.strip_prefix(name).and_then(|value| value.strip_prefix(b"=")) {
            return Some(value);
        }
        fields = rest;
    }
    None
}

/// A field's value as a number.
fn number(fields: &[u8], name: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(field(fields, name)?.try_into().ok()?))
}

/// A time in nanoseconds.
fn time(value: &[u8]) -> Option<i64> {
    let (secs, rest) = value.split_first_chunk()?;
    let nsecs = u32::from_le_bytes(rest.try_into().ok()?);
    Some(nanos(u64::from(u32::from_le_bytes(*secs)) * 1_000_000_000 + u64::from(nsecs)))
}
