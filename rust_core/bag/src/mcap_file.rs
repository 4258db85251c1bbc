//! MCAP files with messages of ROS 1 (<https://mcap.dev/spec>), as `mcap convert` and Foxglove's writers make them.
//!
//! A record is `kind, length, content`. The summary at the end has the channels (topics), their schemas (types), and an
//! index of the chunks. The crate `mcap` parses the content of records; lengths are checked here before.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Display;
use std::io;

use mcap::records::{op, Channel, ChunkIndex, Record};

use crate::bounded_file::BoundedFile;
use crate::chunked::{nanos, ChunkRef, Chunked, Index, RawMessage};
use crate::compression::{damaged, unpack};
use crate::connection::{md5sum, Connection};
use crate::error::BagError;

pub(crate) use mcap::MAGIC;

/// Length of the footer to the end of the file: kind, length, the offsets of the summary and of its index, a checksum,
/// the magic.
const FOOTER_LEN: u64 = 1 + 8 + 8 + 8 + 4 + MAGIC.len() as u64;
/// Longest summary that is read.
const MAX_SUMMARY_LEN: u64 = 256 << 20;
/// Message encodings of ROS 1; the specification once had the second name.
const ROS1: [&str; 2] = ["ros1", "ros"];

/// An MCAP file.
#[derive(Debug)]
pub(crate) struct McapFile {
    file: BoundedFile,
    /// Lengths of the chunks by their offsets.
    chunk_lens: HashMap<u64, u64>,
}

/// The parts of a summary that are read.
#[derive(Default)]
struct Summary {
    schema_names: BTreeMap<u16, String>,
    channels: Vec<Channel>,
    chunks: Vec<ChunkIndex>,
}

impl McapFile {
    pub(crate) fn open(file: BoundedFile) -> Result<(Self, Index), BagError> {
        let no_index = || BagError::no_index(&file.path, "mcap recover");
        let footer_at = file.len.checked_sub(FOOTER_LEN).ok_or_else(no_index)?;
        let footer = file.read(footer_at, FOOTER_LEN).map_err(|error| file.damaged(footer_at, &error))?;
        let summary_at = footer.get(9..17).and_then(|bytes| bytes.try_into().ok()).map_or(0, u64::from_le_bytes);
        let is_whole = footer.first() == Some(&op::FOOTER) && footer.ends_with(MAGIC) && summary_at != 0;
        let len = footer_at.checked_sub(summary_at).filter(|len| is_whole && *len <= MAX_SUMMARY_LEN);
        let damaged = |reason: &dyn Display| file.damaged(summary_at, reason);
        let summary = file.read(summary_at, len.ok_or_else(no_index)?).map_err(|error| damaged(&error))?;
        let summary = Summary::read(&summary).map_err(|error| damaged(&error))?;
        let is_ros1 = |channel: &Channel| ROS1.contains(&&*channel.message_encoding);
        match summary.channels.first() {
            Some(_) if summary.chunks.is_empty() => return Err(no_index()),
            Some(first) if !summary.channels.iter().any(is_ros1) => {
                let encoding = &first.message_encoding;
                let problem =
                    format!("all messages are encoded as {encoding}, but only those of ROS 1 (ros1) are read");
                return Err(BagError::new(&file.path, problem));
            }
            _ => {}
        }
        let chunk_lens = summary.chunks.iter().map(|chunk| (chunk.chunk_start_offset, chunk.chunk_length)).collect();
        Ok((Self { file, chunk_lens }, summary.index()))
    }

    fn visit_messages(&self, at: u64, visit: &mut dyn FnMut(RawMessage<'_>)) -> io::Result<()> {
        let len = self.chunk_lens.get(&at).copied().unwrap_or_default();
        let bytes = self.file.read(at, len)?;
        let no_chunk = || damaged("no chunk where the index lists one");
        let (op::CHUNK, content, _) = split_record(&bytes).ok_or_else(no_chunk)? else { return Err(no_chunk()) };
        let Record::Chunk { header, data } = parse(op::CHUNK, content)? else { return Err(no_chunk()) };
        let records = unpack(header.compression.as_bytes(), &data, header.uncompressed_size)?;
        each_record(&records, |kind, content| {
            if kind != op::MESSAGE {
                return Ok(());
            }
            if let Record::Message { header, data } = parse(kind, content)? {
                let connection = header.channel_id.into();
                visit(RawMessage { connection, nanos: nanos(header.log_time), bytes: &data });
            }
            Ok(())
        })
    }
}

impl Chunked for McapFile {
    fn unpack(&self, at: u64, _: &dyn Fn(u32) -> bool, visit: &mut dyn FnMut(RawMessage<'_>)) -> Result<(), BagError> {
        self.visit_messages(at, visit).map_err(|error| self.file.damaged(at, &error))
    }
}

impl Summary {
    fn read(bytes: &[u8]) -> io::Result<Self> {
        let mut summary = Self::default();
        each_record(bytes, |kind, content| {
            let record = match parse(kind, content) {
                // Such as a topic's name that is not UTF-8, which nobody can have asked for.
                Err(_) if matches!(kind, op::SCHEMA | op::CHANNEL) => return Ok(()),
                record => record?,
            };
            match record {
                Record::Schema { header, .. } => drop(summary.schema_names.insert(header.id, header.name)),
                Record::Channel(channel) => summary.channels.push(channel),
                Record::ChunkIndex(chunk) => summary.chunks.push(chunk),
                _ => {}
            }
            Ok(())
        })?;
        Ok(summary)
    }

    fn index(self) -> Index {
        let connection = |channel: &Channel| (channel.id.into(), self.connection(channel));
        let connections: BTreeMap<u32, Connection> = self.channels.iter().map(connection).collect();
        let chunk = |chunk: &ChunkIndex| {
            let times = [chunk.message_start_time, chunk.message_end_time].map(nanos);
            let ids = if chunk.message_index_offsets.is_empty() {
                // The writer has left out which channels a chunk has.
                connections.keys().copied().collect()
            } else {
                chunk.message_index_offsets.keys().map(|id| (*id).into()).collect()
            };
            ChunkRef::new(chunk.chunk_start_offset, times, ids)
        };
        Index { chunks: self.chunks.iter().map(chunk).collect(), connections }
    }

    fn connection(&self, channel: &Channel) -> Connection {
        let name = self.schema_names.get(&channel.schema_id).map(String::as_str).unwrap_or_default();
        let value = |key| channel.metadata.get(key).map(String::as_str).unwrap_or_default();
        let ros_type = match &*channel.message_encoding {
            encoding if ROS1.contains(&encoding) => name.to_owned(),
            // No type of ROS 1 has such a name.
            encoding => format!("{name} (encoded as {encoding})"),
        };
        Connection {
            topic: channel.topic.as_str().into(),
            ros_type: ros_type.into(),
            md5sum: md5sum(value("md5sum").as_bytes()),
            publisher: value("callerid").into(),
            latching: matches!(value("latching"), "1" | "true"),
        }
    }
}

/// Parses the content of a record; kinds that are not read here may contain anything.
fn parse(kind: u8, content: &[u8]) -> io::Result<Record<'_>> {
    match kind {
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK | op::CHUNK_INDEX => {
            mcap::parse_record(kind, content).map_err(io::Error::other)
        }
        _ => Ok(Record::Unknown { opcode: kind, data: content.into() }),
    }
}

/// Visits consecutive records, up to one that is cut off.
fn each_record(mut bytes: &[u8], mut visit: impl FnMut(u8, &[u8]) -> io::Result<()>) -> io::Result<()> {
    while !bytes.is_empty() {
        let (kind, content, rest) = split_record(bytes).ok_or_else(|| damaged("a record is cut off"))?;
        visit(kind, content)?;
        bytes = rest;
    }
    Ok(())
}

/// A record's kind and content, and the rest.
fn split_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (kind, rest) = bytes.split_first()?;
    let (len, rest) = rest.split_first_chunk()?;
    let (content, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*len)).ok()?)?;
    Some((*kind, content, rest))
}
