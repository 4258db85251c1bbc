//! Common part of the bag formats: messages in chunks that are unpacked one by one, and an index of both.

use std::collections::BTreeMap;
use std::fmt;

use crate::connection::Connection;
use crate::BagError;

/// A file whose index was read.
pub(crate) trait Chunked: fmt::Debug + Send + Sync {
    /// Visits the messages of the chunk at an offset whose connection is wanted, and perhaps others. What comes before
    /// a damaged one is visited, too.
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
    /// When it was recorded.
    pub(crate) nanos: i64,
    pub(crate) bytes: &'a [u8],
}

/// The connections of a file by their ids, and its chunks.
#[derive(Debug, Default)]
pub(crate) struct Index {
    pub(crate) connections: BTreeMap<u32, Connection>,
    pub(crate) chunks: Vec<ChunkRef>,
}

/// Where a chunk is, and what its index says of it.
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
    /// A damaged index may say that a chunk ends before it begins.
    pub(crate) fn new(at: u64, [one, other]: [i64; 2], connections: Vec<u32>) -> Self {
        Self { at, start_nanos: one.min(other), end_nanos: one.max(other), connections }
    }
}

/// Nanoseconds that a stamp can hold: damaged bytes may say more.
pub(crate) fn nanos(time: u64) -> i64 {
    const LAST: i64 = u32::MAX as i64 * 1_000_000_000 + 999_999_999;
    i64::try_from(time).map_or(LAST, |time| time.min(LAST))
}
