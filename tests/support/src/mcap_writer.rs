//! Writes MCAP files, without compression.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::{McapResult, WriteOptions, Writer};
use rcs_messages::Time;

/// An MCAP file being written. It has no index until it is [finished](McapWriter::finish).
pub struct McapWriter {
    writer: Writer<BufWriter<File>>,
}

impl McapWriter {
    /// Starts a file at `path`, replacing an existing one. Chunks are closed at `chunk_len` bytes.
    pub fn create(path: impl AsRef<Path>, chunk_len: u64) -> McapResult<Self> {
        Self::create_with(path, chunk_len, |options| options)
    }

    /// Starts a file as [`create`](Self::create) does, with other options, such as those that leave out a part.
    pub fn create_with(
        path: impl AsRef<Path>,
        chunk_len: u64,
        change: impl FnOnce(WriteOptions) -> WriteOptions,
    ) -> McapResult<Self> {
        let options = WriteOptions::new().compression(None).profile("ros1").chunk_size(Some(chunk_len));
        Ok(Self { writer: change(options).create(BufWriter::new(File::create(path)?))? })
    }

    /// Adds an encoded message; `encoding` is `ros1` for ROS 1.
    pub fn write(&mut self, topic: &str, ros_type: &str, encoding: &str, time: Time, message: &[u8]) -> McapResult<()> {
        let schema = self.writer.add_schema(ros_type, &format!("{encoding}msg"), b"")?;
        let channel_id = self.writer.add_channel(schema, topic, encoding, &BTreeMap::new())?;
        let log_time = u64::try_from(time.nanos()).unwrap_or_default();
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, message)
    }

    /// Writes the index.
    pub fn finish(mut self) -> McapResult<()> {
        self.writer.finish().map(drop)
    }
}
