//! The index of an MCAP file: the summary's, or what reading the whole file once gives.
//!
//! A writer may leave out the summary, or the channels, schemas and chunk indexes in it, and may write messages without
//! chunks. A summary counts if it knows all that its own chunks refer to and nothing else in the file holds messages.
//! Messages without chunks are read in pieces, as if these were chunks.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io;

use mcap::records::{op, ChunkIndex, Record};
use mcap::MAGIC;

use crate::bounded_file::BoundedFile;
use crate::chunked::{nanos, ChunkRef, Index};
use crate::compression::damaged;
use crate::error::BagError;
use crate::mcap_file::McapFile;
use crate::mcap_records::{each_record, is_ros1, parse, Definitions};

/// Length of the footer to the end of the file: kind, length, the offsets of the summary and of its index, a checksum,
/// the magic.
const FOOTER_LEN: u64 = 1 + 8 + 8 + 8 + 4 + MAGIC.len() as u64;
/// Longest summary that is read.
const MAX_SUMMARY_LEN: u64 = 256 << 20;
/// Length of a record's kind and length.
const HEAD_LEN: u64 = 1 + 8;
/// Length of consecutive messages without a chunk from which on they are another piece.
const PIECE_LEN: u64 = 4 << 20;
/// The parts of a summary that are read.
#[derive(Default)]
struct Summary {
    definitions: Definitions,
    chunks: Vec<ChunkIndex>,
}

/// Opens a file and reads its index.
///
/// # Errors
/// The file was not closed, is damaged, or has no messages of ROS 1.
pub(crate) fn open(file: BoundedFile) -> Result<(McapFile, Index), BagError> {
    let not_closed = || BagError::no_index(&file.path, "mcap recover");
    let footer_at = file.len.checked_sub(FOOTER_LEN).ok_or_else(not_closed)?;
    let footer = file.read(footer_at, FOOTER_LEN).map_err(|error| file.damaged(footer_at, &error))?;
    let summary_at = footer.get(9..17).and_then(|bytes| bytes.try_into().ok()).map_or(0, u64::from_le_bytes);
    if footer.first() != Some(&op::FOOTER) || !footer.ends_with(MAGIC) || summary_at > footer_at {
        return Err(not_closed());
    }
    let mut opened = McapFile { file, chunk_lens: HashMap::new() };
    let index = read(&mut opened, summary_at, footer_at)?;
    Ok((opened, index))
}

/// Reads the index of a file, whose footer is at `footer_at`, and notes the lengths of its chunks. `summary_at` is 0
/// without a summary.
fn read(opened: &mut McapFile, summary_at: u64, footer_at: u64) -> Result<Index, BagError> {
    let file = &opened.file;
    let mut summary = Summary::default();
    if summary_at != 0 && footer_at - summary_at <= MAX_SUMMARY_LEN {
        let bytes = file.read(summary_at, footer_at - summary_at);
        let read = bytes.and_then(|bytes| each_record(&bytes, |kind, content| summary.take(kind, content)));
        read.map_err(|error| file.damaged(summary_at, &error))?;
    }
    let end = if summary_at == 0 { footer_at } else { summary_at };
    let is_complete = summary.is_complete() && holds_all(file, &summary.chunks, end);
    let (chunks, definitions, mut problems) = if is_complete {
        opened.chunk_lens = summary.chunks.iter().map(|chunk| (chunk.chunk_start_offset, chunk.chunk_length)).collect();
        let (chunks, problems) = opened.dated(&summary);
        (chunks, summary.definitions, problems)
    } else {
        opened.scan(summary.definitions, end)?
    };
    let file = &opened.file;
    definitions.check_encoding(file)?;
    problems.extend(definitions.missing(&chunks).into_iter().map(|problem| BagError::new(&file.path, problem)));
    let connections = definitions.channels.values().map(|one| (one.id.into(), definitions.connection(one))).collect();
    Ok(Index { connections, chunks, problems })
}

/// Whether no message before `end` is outside of these chunks, and no chunk is missing among them.
fn holds_all(file: &BoundedFile, chunks: &[ChunkIndex], end: u64) -> bool {
    let len = |chunk: &ChunkIndex| chunk.chunk_length.saturating_add(chunk.message_index_length);
    let lens: BTreeMap<u64, u64> = chunks.iter().map(|chunk| (chunk.chunk_start_offset, len(chunk))).collect();
    let mut at = MAGIC.len() as u64;
    while at < end {
        at = match (lens.get(&at), head(file, at)) {
            (Some(len), _) if *len > 0 => at.saturating_add(*len),
            (_, Ok((op::MESSAGE | op::CHUNK, _))) => return false,
            (_, Ok((_, record_end))) => record_end,
            // What the index lists is read all the same.
            (_, Err(_)) => return true,
        };
    }
    true
}

/// The kind of the record at an offset, and its end.
fn head(file: &BoundedFile, at: u64) -> io::Result<(u8, u64)> {
    let bytes = file.read(at, HEAD_LEN)?;
    let (kind, len) = bytes.split_first().ok_or_else(|| damaged("a record is cut off"))?;
    let len = len.try_into().map_or(0, u64::from_le_bytes);
    let end = (at + HEAD_LEN).checked_add(len).filter(|end| *end <= file.len);
    Ok((*kind, end.ok_or_else(|| damaged("a record reaches past the end of the file"))?))
}

impl Summary {
    fn take(&mut self, kind: u8, content: &[u8]) -> io::Result<()> {
        if matches!(kind, op::SCHEMA | op::CHANNEL) {
            self.definitions.take(kind, content);
        } else if let Record::ChunkIndex(chunk) = parse(kind, content)? {
            self.chunks.push(chunk);
        }
        Ok(())
    }

    /// Whether all channels of its chunks, and all schemas of its channels are in it.
    fn is_complete(&self) -> bool {
        let used = self.chunks.iter().flat_map(|chunk| chunk.message_index_offsets.keys());
        let Definitions { channels, schema_names, .. } = &self.definitions;
        let knows = |id: &u16| self.definitions.knows(*id);
        !channels.is_empty()
            && { used }.all(knows)
            && channels.values().all(|channel| !is_ros1(channel) || schema_names.contains_key(&channel.schema_id))
    }
}

impl McapFile {
    /// The chunks of a summary. Those whose times cannot be messages' are looked into: the specification has 0 for a
    /// chunk without messages, of which writers leave some.
    fn dated(&self, summary: &Summary) -> (Vec<ChunkRef>, Vec<BagError>) {
        let (mut chunks, mut problems) = (Vec::new(), Vec::new());
        let all: Vec<u32> = summary.definitions.channels.keys().map(|id| (*id).into()).collect();
        for chunk in &summary.chunks {
            let [start, end] = [chunk.message_start_time, chunk.message_end_time];
            if end == 0 || start > end {
                let (seen, problem) = self.look_into(chunk.chunk_start_offset, &mut Definitions::default());
                chunks.extend(seen);
                problems.extend(problem);
                continue;
            }
            let listed = &chunk.message_index_offsets;
            // The writer may have left out which channels a chunk has.
            let ids = if listed.is_empty() { all.clone() } else { listed.keys().map(|id| (*id).into()).collect() };
            chunks.push(ChunkRef::new(chunk.chunk_start_offset, [start, end].map(nanos), ids));
        }
        (chunks, problems)
    }

    /// A chunk, or the records in place of one, with the times and channels of its messages: none without messages.
    fn look_into(&self, at: u64, definitions: &mut Definitions) -> (Option<ChunkRef>, Option<BagError>) {
        let (mut first, mut last, mut ids) = (i64::MAX, i64::MIN, BTreeSet::new());
        let result = self.visit_messages(at, definitions, &mut |message| {
            (first, last) = (first.min(message.nanos), last.max(message.nanos));
            ids.insert(message.connection);
        });
        if ids.is_empty() {
            return (None, result.err().map(|error| self.file.damaged(at, &error)));
        }
        // What is damaged in it is reported when it is played.
        (Some(ChunkRef::new(at, [first, last], ids.into_iter().collect())), None)
    }

    /// Reads the file's records in order, up to `end`.
    fn scan(
        &mut self,
        mut definitions: Definitions,
        end: u64,
    ) -> Result<(Vec<ChunkRef>, Definitions, Vec<BagError>), BagError> {
        let (mut chunks, mut problems, mut at) = (Vec::new(), Vec::new(), MAGIC.len() as u64);
        while at < end {
            let (kind, mut next) = head(&self.file, at).map_err(|error| self.file.damaged(at, &error))?;
            match kind {
                op::SCHEMA | op::CHANNEL => {
                    let content = self.file.read(at + HEAD_LEN, next - at - HEAD_LEN);
                    definitions.take(kind, &content.map_err(|error| self.file.damaged(at, &error))?);
                }
                op::MESSAGE | op::CHUNK => {
                    while kind == op::MESSAGE && next < end && next - at < PIECE_LEN {
                        match head(&self.file, next) {
                            Ok((op::MESSAGE, record_end)) => next = record_end,
                            _ => break,
                        }
                    }
                    self.chunk_lens.insert(at, next - at);
                    let (chunk, problem) = self.look_into(at, &mut definitions);
                    chunks.extend(chunk);
                    problems.extend(problem);
                }
                op::DATA_END => break,
                _ => {}
            }
            at = next;
        }
        Ok((chunks, definitions, problems))
    }
}
