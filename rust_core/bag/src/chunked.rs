//! Common interface of the bag formats: chunks of messages, and an index.

use std::collections::BTreeMap;
use std::fmt;

use crate::connection::Connection;
use crate::error::BagError;

/// A file whose index was read.
pub(crate) trait Chunked: fmt::Debug + Send + Sync {
    /// Visits the messages of the chunk at an offset whose connection is wanted, and perhaps others, up to a damaged
    /// one.
    fn unpack(
        &self,
        at: u64,
        wanted: &dyn Fn(u32) -> bool,
        visit: &mut dyn FnMut(RawMessage<'_>),
    ) -> Result<(), BagError>;
}

/// A message in a chunk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RawMessage<'a> {
    pub(crate) connection: u32,
    /// Recording time.
    pub(crate) nanos: i64,
    pub(crate) bytes: &'a [u8],
}

/// The connections of a file by their ids, its chunks, and what it lacks.
#[derive(Debug, Default)]
pub(crate) struct Index {
    pub(crate) connections: BTreeMap<u32, Connection>,
    pub(crate) chunks: Vec<ChunkRef>,
    pub(crate) problems: Vec<BagError>,
}

/// A chunk as the index describes it.
#[derive(Clone, Debug)]
pub(crate) struct ChunkRef {
    pub(crate) at: u64,
    pub(crate) start_nanos: i64,
    /// Not before the start.
    pub(crate) end_nanos: i64,
    /// Ids of the connections with messages in it.
    pub(crate) connections: Vec<u32>,
}

impl ChunkRef {
    /// Orders the times, because a damaged index may swap them.
    pub(crate) fn new(at: u64, [one, other]: [i64; 2], connections: Vec<u32>) -> Self {
        Self { at, start_nanos: one.min(other), end_nanos: one.max(other), connections }
    }
}

/// Clamps damaged times to what a stamp can hold.
pub(crate) fn nanos(time: u64) -> i64 {
    const LAST: i64 = u32::MAX as i64 * 1_000_000_000 + 999_999_999;
    i64::try_from(time).map_or(LAST, |time| time.min(LAST))
}
