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
use crate::chunked::{nanos, Chunked, RawMessage};
use crate::compression::{damaged, unpack};
use crate::error::BagError;
use crate::mcap_records::{each_record, parse, split_record, Definitions};

/// An MCAP file.
#[derive(Debug)]
pub(crate) struct McapFile {
    pub(crate) file: BoundedFile,
    /// Lengths of the chunks, and of the records in place of chunks, by their offsets.
    pub(crate) chunk_lens: HashMap<u64, u64>,
}

impl McapFile {
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
