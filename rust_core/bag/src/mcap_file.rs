//! MCAP files with messages of ROS 1 (<https://mcap.dev/spec>), as `mcap convert` and Foxglove's writers make them.
//!
//! A record is `kind, length, content`. Messages are in chunks or directly in the file. A summary at the end may repeat
//! the channels (topics) and their schemas (types) and have an index of the chunks; where it leaves out any of them,
//! the whole file is read once (`mcap_index`). The crate `mcap` parses the content of records; lengths are checked
//! here before.

use std::collections::HashMap;
use std::io;

use mcap::records::{op, Record};

use crate::bounded_file::BoundedFile;
use crate::chunked::{nanos, Chunked, Index, RawMessage};
use crate::compression::{damaged, unpack};
use crate::error::BagError;
use crate::mcap_index::{self, Definitions};

pub(crate) use mcap::MAGIC;

/// Length of the footer to the end of the file: kind, length, the offsets of the summary and of its index, a checksum,
/// the magic.
const FOOTER_LEN: u64 = 1 + 8 + 8 + 8 + 4 + MAGIC.len() as u64;

/// An MCAP file.
#[derive(Debug)]
pub(crate) struct McapFile {
    pub(crate) file: BoundedFile,
    /// Lengths of the chunks, and of the records in place of chunks, by their offsets.
    pub(crate) chunk_lens: HashMap<u64, u64>,
}

impl McapFile {
    pub(crate) fn open(file: BoundedFile) -> Result<(Self, Index), BagError> {
        let not_closed = || BagError::no_index(&file.path, "mcap recover");
        let footer_at = file.len.checked_sub(FOOTER_LEN).ok_or_else(not_closed)?;
        let footer = file.read(footer_at, FOOTER_LEN).map_err(|error| file.damaged(footer_at, &error))?;
        let summary_at = footer.get(9..17).and_then(|bytes| bytes.try_into().ok()).map_or(0, u64::from_le_bytes);
        if footer.first() != Some(&op::FOOTER) || !footer.ends_with(MAGIC) || summary_at > footer_at {
            return Err(not_closed());
        }
        let mut opened = Self { file, chunk_lens: HashMap::new() };
        let index = mcap_index::read(&mut opened, summary_at, footer_at)?;
        Ok((opened, index))
    }

    /// Visits the messages of a chunk, or of records in place of one, and notes the channels and schemas among them.
    pub(crate) fn visit_messages(
        &self,
        at: u64,
        definitions: &mut Definitions,
        visit: &mut dyn FnMut(RawMessage<'_>),
    ) -> io::Result<()> {
        let bytes = self.file.read(at, self.chunk_lens.get(&at).copied().unwrap_or_default())?;
        let mut take = |kind: u8, content: &[u8]| match kind {
            op::SCHEMA | op::CHANNEL => {
                definitions.take(kind, content);
                Ok(())
            }
            op::MESSAGE => {
                if let Record::Message { header, data } = parse(kind, content)? {
                    let connection = header.channel_id.into();
                    visit(RawMessage { connection, nanos: nanos(header.log_time), bytes: &data });
                }
                Ok(())
            }
            _ => Ok(()),
        };
        let no_chunk = || damaged("no chunk where the index lists one");
        match split_record(&bytes).ok_or_else(no_chunk)? {
            (op::CHUNK, content, _) => {
                let Record::Chunk { header, data } = parse(op::CHUNK, content)? else { return Err(no_chunk()) };
                let records = unpack(header.compression.as_bytes(), &data, header.uncompressed_size)?;
                each_record(&records, take)
            }
            (op::MESSAGE, ..) => each_record(&bytes, &mut take),
            _ => Err(no_chunk()),
        }
    }
}

impl Chunked for McapFile {
    fn unpack(&self, at: u64, _: &dyn Fn(u32) -> bool, visit: &mut dyn FnMut(RawMessage<'_>)) -> Result<(), BagError> {
        let result = self.visit_messages(at, &mut Definitions::default(), visit);
        result.map_err(|error| self.file.damaged(at, &error))
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
fn split_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (kind, rest) = bytes.split_first()?;
    let (len, rest) = rest.split_first_chunk()?;
    let (content, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*len)).ok()?)?;
    Some((*kind, content, rest))
}
