//! The records of an MCAP file: their framing, and the channels and schemas that messages refer to.

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use mcap::records::{op, Channel, Record};

use crate::bounded_file::BoundedFile;
use crate::chunked::ChunkRef;
use crate::compression::damaged;
use crate::connection::{md5sum, Connection};
use crate::error::BagError;

/// Message encodings of ROS 1; the specification once had the second name.
const ROS1: [&str; 2] = ["ros1", "ros"];

/// The channels and schemas of a file.
#[derive(Default)]
pub(crate) struct Definitions {
    pub(crate) schema_names: BTreeMap<u16, String>,
    pub(crate) channels: BTreeMap<u16, Channel>,
    /// Channels whose record cannot be read, such as one of a topic that is not UTF-8, which nobody can have asked for.
    unreadable: BTreeSet<u16>,
}

pub(crate) fn is_ros1(channel: &Channel) -> bool {
    ROS1.contains(&&*channel.message_encoding)
}

impl Definitions {
    /// Takes the content of a schema's or a channel's record.
    pub(crate) fn take(&mut self, kind: u8, content: &[u8]) {
        match parse(kind, content) {
            Ok(Record::Schema { header, .. }) => drop(self.schema_names.insert(header.id, header.name)),
            Ok(Record::Channel(channel)) => drop(self.channels.insert(channel.id, channel)),
            Ok(_) => {}
            Err(_) => {
                let id = content.first_chunk().map(|id| u16::from_le_bytes(*id)).filter(|_| kind == op::CHANNEL);
                self.unreadable.extend(id);
            }
        }
    }

    pub(crate) fn knows(&self, channel: u16) -> bool {
        self.channels.contains_key(&channel) || self.unreadable.contains(&channel)
    }

    /// # Errors
    /// No channel is of ROS 1.
    pub(crate) fn check_encoding(&self, file: &BoundedFile) -> Result<(), BagError> {
        match self.channels.values().next() {
            Some(first) if !self.channels.values().any(is_ros1) => {
                let encoding = &first.message_encoding;
                let problem =
                    format!("all messages are encoded as {encoding}, but only those of ROS 1 (ros1) are read");
                Err(BagError::new(&file.path, problem))
            }
            _ => Ok(()),
        }
    }

    /// Channels and schemas that the messages refer to and the file lacks, one line each.
    pub(crate) fn missing(&self, chunks: &[ChunkRef]) -> Vec<String> {
        let used: BTreeSet<u32> = chunks.iter().flat_map(|chunk| chunk.connections.iter().copied()).collect();
        let problem = |id: &u32| {
            let channel = u16::try_from(*id).ok()?;
            match self.channels.get(&channel) {
                None if self.unreadable.contains(&channel) => None,
                None => Some(format!("no record of channel {id}, so its messages are not read")),
                Some(one) if is_ros1(one) && !self.schema_names.contains_key(&one.schema_id) => {
                    Some(format!("no schema {} of {}, so its messages are not read", one.schema_id, one.topic))
                }
                Some(_) => None,
            }
        };
        used.iter().filter_map(problem).collect()
    }

    pub(crate) fn connection(&self, channel: &Channel) -> Connection {
        let name = self.schema_names.get(&channel.schema_id).map(String::as_str).unwrap_or_default();
        let value = |key| channel.metadata.get(key).map(String::as_str).unwrap_or_default();
        let ros_type = if is_ros1(channel) {
            name.to_owned()
        } else {
            // No type of ROS 1 has such a name.
            format!("{name} (encoded as {})", channel.message_encoding)
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
pub(crate) fn parse(kind: u8, content: &[u8]) -> io::Result<Record<'_>> {
    match kind {
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK | op::CHUNK_INDEX => {
            mcap::parse_record(kind, content).map_err(io::Error::other)
        }
        _ => Ok(Record::Unknown { opcode: kind, data: content.into() }),
    }
}

/// Visits consecutive records, up to one that is cut off.
pub(crate) fn each_record(mut bytes: &[u8], mut visit: impl FnMut(u8, &[u8]) -> io::Result<()>) -> io::Result<()> {
    while !bytes.is_empty() {
        let (kind, content, rest) = split_record(bytes).ok_or_else(|| damaged("a record is cut off"))?;
        visit(kind, content)?;
        bytes = rest;
    }
    Ok(())
}

/// A record's kind and content, and the rest.
pub(crate) fn split_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (kind, rest) = bytes.split_first()?;
    let (len, rest) = rest.split_first_chunk()?;
    let (content, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*len)).ok()?)?;
    Some((*kind, content, rest))
}
