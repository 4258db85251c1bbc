//! Writes bag files for samples and tests without ROS.
//!
//! Chunks are uncompressed and closed at [`CHUNK_LEN`]; the index is complete, so every ROS tool reads the file.

use rcs_messages::{Message, Time};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Magic bytes of a bag of version 2.0.
const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

/// Types of records.
mod op {
    pub(super) const MESSAGE: u8 = 2;
    pub(super) const BAG_HEADER: u8 = 3;
    pub(super) const INDEX: u8 = 4;
    pub(super) const CHUNK: u8 = 5;
    pub(super) const CHUNK_INFO: u8 = 6;
    pub(super) const CONNECTION: u8 = 7;
}

/// Size in bytes at which a chunk is closed, as in ROS's recorder.
const CHUNK_LEN: usize = 768 * 1024;
/// Padded size of the bag's header record, which is rewritten in place.
const HEADER_LEN: usize = 4096;

/// A bag being written. It has no index until it is [finished](BagWriter::finish).
///
/// ```
/// use rcs_messages::{std_msgs, Time};
/// use rcs_test_support::BagWriter;
///
/// let folder = std::env::temp_dir();
/// let path = folder.join(format!("bag_writer_{}.bag", std::process::id()));
/// let mut writer = BagWriter::create(&path)?;
/// writer.write("/greeting", false, Time { sec: 1, nsec: 0 }, &std_msgs::String { data: "hello".to_owned() })?;
/// writer.finish()?;
/// assert!(std::fs::read(&path)?.starts_with(b"#ROSBAG V2.0"));
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct BagWriter {
    file: BufWriter<File>,
    at: u64,
    connections: Vec<Vec<u8>>,
    ids: BTreeMap<(String, String, bool), u32>,
    infos: Vec<Vec<u8>>,
    chunk: Chunk,
}

#[derive(Debug, Default)]
struct Chunk {
    bytes: Vec<u8>,
    /// Time and offset of each message, by connection.
    index: BTreeMap<u32, Vec<(Time, u32)>>,
}

impl BagWriter {
    /// Starts a bag at `path`, replacing an existing file.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        let mut writer = Self {
            file: BufWriter::new(File::create(path)?),
            at: 0,
            connections: Vec::new(),
            ids: BTreeMap::new(),
            infos: Vec::new(),
            chunk: Chunk::default(),
        };
        writer.put(MAGIC)?;
        let header = writer.header_record(0);
        writer.put(&header)?;
        Ok(writer)
    }

    /// Adds a message as recorded on `topic` at `time`; `latching` of its publisher.
    pub fn write<T: Message>(&mut self, topic: &str, latching: bool, time: Time, message: &T) -> io::Result<()> {
        let key = (topic.to_owned(), T::msg_type(), latching);
        let id = match self.ids.get(&key) {
            Some(id) => *id,
            None => {
                let id = to_u32(self.ids.len())?;
                self.ids.insert(key, id);
                let record = connection_record::<T>(id, topic, latching)?;
                self.chunk.bytes.extend_from_slice(&record);
                self.connections.push(record);
                id
            }
        };
        let offset = to_u32(self.chunk.bytes.len())?;
        let header = [("op", vec![op::MESSAGE]), ("conn", le(id)), ("time", time_bytes(time))];
        self.chunk.bytes.extend_from_slice(&record(&header, &rcs_messages::encode(message))?);
        self.chunk.index.entry(id).or_default().push((time, offset));
        if self.chunk.bytes.len() >= CHUNK_LEN {
            self.close_chunk()?;
        }
        Ok(())
    }

    /// Writes the index.
    pub fn finish(mut self) -> io::Result<()> {
        self.close_chunk()?;
        let index_at = self.at;
        for bytes in self.connections.iter().chain(&self.infos) {
            self.file.write_all(bytes)?;
        }
        let header = self.header_record(index_at);
        self.file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
        self.file.write_all(&header)?;
        self.file.flush()
    }

    fn close_chunk(&mut self) -> io::Result<()> {
        let chunk = std::mem::take(&mut self.chunk);
        let times = || chunk.index.values().flatten().map(|(time, _)| *time);
        let (Some(first), Some(last)) = (times().min(), times().max()) else {
            return Ok(());
        };
        let chunk_at = self.at;
        let header =
            [("op", vec![op::CHUNK]), ("compression", b"none".to_vec()), ("size", le(to_u32(chunk.bytes.len())?))];
        self.put(&record(&header, &chunk.bytes)?)?;
        let mut counts = Vec::new();
        for (id, entries) in &chunk.index {
            let count = to_u32(entries.len())?;
            counts.extend_from_slice(&[le(*id), le(count)].concat());
            let header = [("op", vec![op::INDEX]), ("ver", le(1)), ("conn", le(*id)), ("count", le(count))];
            let data: Vec<u8> =
                (entries.iter()).flat_map(|(time, offset)| [time_bytes(*time), le(*offset)].concat()).collect();
            self.put(&record(&header, &data)?)?;
        }
        let header = [
            ("op", vec![op::CHUNK_INFO]),
            ("ver", le(1)),
            ("chunk_pos", chunk_at.to_le_bytes().to_vec()),
            ("start_time", time_bytes(first)),
            ("end_time", time_bytes(last)),
            ("count", le(to_u32(chunk.index.len())?)),
        ];
        self.infos.push(record(&header, &counts)?);
        Ok(())
    }

    fn header_record(&self, index_at: u64) -> Vec<u8> {
        let header = [
            ("op", vec![op::BAG_HEADER]),
            ("index_pos", index_at.to_le_bytes().to_vec()),
            ("conn_count", le(self.connections.len().try_into().unwrap_or(u32::MAX))),
            ("chunk_count", le(self.infos.len().try_into().unwrap_or(u32::MAX))),
        ];
        let fields = fields(&header);
        let padding = vec![b' '; HEADER_LEN.saturating_sub(fields.len())];
        [counted(&fields), counted(&padding)].concat()
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.at += bytes.len() as u64;
        self.file.write_all(bytes)
    }
}

fn connection_record<T: Message>(id: u32, topic: &str, latching: bool) -> io::Result<Vec<u8>> {
    let data = fields(&[
        ("topic", topic.as_bytes().to_vec()),
        ("type", T::msg_type().into_bytes()),
        ("md5sum", T::md5sum().into_bytes()),
        ("message_definition", T::msg_definition().into_bytes()),
        ("callerid", b"/bag_writer".to_vec()),
        ("latching", if latching { b"1".to_vec() } else { b"0".to_vec() }),
    ]);
    record(&[("op", vec![op::CONNECTION]), ("conn", le(id)), ("topic", topic.as_bytes().to_vec())], &data)
}

fn record(header: &[(&str, Vec<u8>)], data: &[u8]) -> io::Result<Vec<u8>> {
    to_u32(data.len())?;
    Ok([counted(&fields(header)), counted(data)].concat())
}

fn fields(list: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let field = |(key, value): &(&str, Vec<u8>)| counted(&[key.as_bytes(), b"=", value].concat());
    list.iter().flat_map(field).collect()
}

fn counted(bytes: &[u8]) -> Vec<u8> {
    [&u32::try_from(bytes.len()).unwrap_or(u32::MAX).to_le_bytes(), bytes].concat()
}

fn le(value: u32) -> Vec<u8> {
    value.to_le_bytes().to_vec()
}

fn time_bytes(time: Time) -> Vec<u8> {
    [time.sec.to_le_bytes(), time.nsec.to_le_bytes()].concat()
}

fn to_u32(len: usize) -> io::Result<u32> {
    u32::try_from(len).map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "more than 4 GiB in one record"))
}
