//! Bags of version 2.0, which ROS 1 records.
//!
//! A record is `header length, header fields, data length, data`; a field is `length, name=value`. Chunks are records
//! with further records in them; the index at the end repeats the connections and says where the chunks are. Records
//! and fields that nothing here needs are skipped by their lengths, whatever is in them.

use std::io;

use crate::bounded_file::BoundedFile;
use crate::chunked::{nanos, ChunkRef, Chunked, Index, RawMessage};
use crate::compression::{damaged, unpack};
use crate::connection::{md5sum, Connection};
use crate::BagError;

/// What such a file begins with.
pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// The longest header that is read; real ones have some hundred bytes.
const MAX_HEADER_LEN: u32 = 1 << 20;
/// The longest record of the index that is read: a connection with its message definition, or a chunk's connections.
const MAX_INDEX_RECORD_LEN: u32 = 16 << 20;
/// The encryptor that encrypts nothing.
const NO_ENCRYPTOR: &[u8] = b"rosbag/NoEncryptor";

/// Kinds of records, their field `op`.
mod op {
    pub(super) const MESSAGE: &[u8] = &[2];
    pub(super) const CHUNK: &[u8] = &[5];
    pub(super) const CHUNK_INFO: &[u8] = &[6];
    pub(super) const CONNECTION: &[u8] = &[7];
}

/// A bag of version 2.0.
#[derive(Debug)]
pub(crate) struct RosbagFile {
    file: BoundedFile,
}

/// A record in the file.
struct Record {
    fields: Vec<u8>,
    data_at: u64,
    data_len: u32,
}

impl Record {
    /// Where the next record begins.
    fn end(&self) -> u64 {
        self.data_at + u64::from(self.data_len)
    }
}

impl RosbagFile {
    pub(crate) fn open(file: BoundedFile) -> Result<(Self, Index), BagError> {
        let bag = Self { file };
        let path = || bag.file.path.clone();
        let header = bag.record(MAGIC.len() as u64).map_err(|_| BagError::NotABag { path: path() })?;
        match field(&header.fields, b"encryptor") {
            None | Some(b"" | NO_ENCRYPTOR) => {}
            Some(encryptor) => {
                let encryptor = String::from_utf8_lossy(encryptor).into_owned();
                return Err(BagError::Encrypted { path: path(), encryptor });
            }
        }
        let index_at = field(&header.fields, b"index_pos").and_then(|value| value.try_into().ok());
        let index_at = u64::from_le_bytes(index_at.ok_or_else(|| BagError::NotABag { path: path() })?);
        if index_at < header.end() || index_at > bag.file.len {
            return Err(BagError::NoIndex { path: path(), remedy: "rosbag reindex" });
        }
        let index = bag.read_index(index_at).map_err(|error| bag.file.damaged(index_at, &error))?;
        Ok((bag, index))
    }

    fn read_index(&self, mut at: u64) -> io::Result<Index> {
        let mut index = Index::default();
        while at < self.file.len {
            let record = self.record(at)?;
            at = record.end();
            let data = || {
                if record.data_len > MAX_INDEX_RECORD_LEN {
                    return Err(damaged("record of the index too long"));
                }
                self.file.read(record.data_at, record.data_len.into())
            };
            match field(&record.fields, b"op") {
                Some(op::CONNECTION) => {
                    // What has neither an id nor a topic belongs to no message that anybody asks for.
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

    fn record(&self, at: u64) -> io::Result<Record> {
        let length = |at: u64| {
            let bytes = self.file.read(at, 4)?;
            Ok::<_, io::Error>(bytes.try_into().map_or(0, u32::from_le_bytes))
        };
        let header_len = length(at)?;
        if header_len > MAX_HEADER_LEN {
            return Err(damaged("record header too long"));
        }
        let fields = self.file.read(at + 4, header_len.into())?;
        let header_end = at + 4 + u64::from(header_len);
        let record = Record { fields, data_at: header_end + 4, data_len: length(header_end)? };
        if record.end() > self.file.len {
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "record reaches past the end of the file"));
        }
        Ok(record)
    }

    fn visit_messages(&self, at: u64, visit: &mut dyn FnMut(RawMessage<'_>)) -> io::Result<()> {
        let chunk = self.record(at)?;
        if field(&chunk.fields, b"op") != Some(op::CHUNK) {
            return Err(damaged("no chunk where the index says that there is one"));
        }
        let size = number(&chunk.fields, b"size").ok_or_else(|| damaged("chunk without size"))?;
        let compression = field(&chunk.fields, b"compression").ok_or_else(|| damaged("chunk without compression"))?;
        let packed = self.file.read(chunk.data_at, chunk.data_len.into())?;
        let records = unpack(compression, &packed, size.into())?;
        let mut rest = &*records;
        while !rest.is_empty() {
            // After a damaged record the next would be read from the wrong place.
            let past_end = || damaged("a message reaches past the end of its chunk");
            let (fields, bytes, after) = split_record(rest).ok_or_else(past_end)?;
            rest = after;
            if field(fields, b"op") == Some(op::MESSAGE) {
                let time = field(fields, b"time").and_then(time);
                let message = number(fields, b"conn").zip(time);
                let (connection, nanos) = message.ok_or_else(|| damaged("message without connection or time"))?;
                visit(RawMessage { connection, nanos, bytes });
            }
        }
        Ok(())
    }
}

impl Chunked for RosbagFile {
    fn unpack(&self, at: u64, visit: &mut dyn FnMut(RawMessage<'_>)) -> Result<(), BagError> {
        self.visit_messages(at, visit).map_err(|error| self.file.damaged(at, &error))
    }
}

/// A connection's id and what its record says, whatever else is in there: the message definition may be in any
/// encoding.
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

/// A chunk and the ids of its connections, each followed by its number of messages.
fn chunk_info(header: &[u8], data: &[u8]) -> Option<ChunkRef> {
    let at = u64::from_le_bytes(field(header, b"chunk_pos")?.try_into().ok()?);
    let times = [time(field(header, b"start_time")?)?, time(field(header, b"end_time")?)?];
    let ids = data.chunks_exact(8).filter_map(|entry| Some(u32::from_le_bytes(*entry.first_chunk()?)));
    Some(ChunkRef::new(at, times, ids.collect()))
}

/// The header's fields, the data, and what follows the record.
fn split_record(bytes: &[u8]) -> Option<(&[u8], &[u8], &[u8])> {
    let (fields, rest) = split_counted(bytes)?;
    let (data, rest) = split_counted(rest)?;
    Some((fields, data, rest))
}

/// Bytes behind their length, and what follows them.
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

/// The value of a field that is a number.
fn number(fields: &[u8], name: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(field(fields, name)?.try_into().ok()?))
}

/// The nanoseconds of a time.
fn time(value: &[u8]) -> Option<i64> {
    let (secs, rest) = value.split_first_chunk()?;
    let nsecs = u32::from_le_bytes(rest.try_into().ok()?);
    Some(nanos(u64::from(u32::from_le_bytes(*secs)) * 1_000_000_000 + u64::from(nsecs)))
}
