//! Checks of the few lengths in a bag file that the crate `rosbag` uses unchecked.
//!
//! A record is `header length, header fields, data length, data`; a field is `length, name=value`. All lengths are
//! checked against the file.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// The longest header that is read; real ones have some hundred bytes.
const MAX_HEADER_LEN: u32 = 1 << 20;
/// The longest unpacked chunk; recorders cut them below a megabyte unless one message is longer.
const MAX_CHUNK_LEN: u32 = 1 << 30;
/// The kind of record that a chunk is, its field `op`.
const CHUNK: &[u8] = &[5];
/// No compression packs more tightly: bzip2 reaches some 50 000 on zeros, so a small chunk may still be a large one.
const MAX_RATIO: u64 = 100_000;

/// The file, opened once more to read headers from.
pub(crate) struct ChunkHeaders {
    file: Mutex<File>,
    len: u64,
}

struct Record {
    fields: Vec<u8>,
    data_len: u32,
    /// Where the next record begins.
    end: u64,
}

impl ChunkHeaders {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        if metadata.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        Ok(Self { len: metadata.len(), file: Mutex::new(file) })
    }

    pub(crate) fn file_len(&self) -> u64 {
        self.len
    }

    /// The offsets of the first record after the bag's header and, by that header, of the index.
    pub(crate) fn bag_header(&self) -> io::Result<(u64, u64)> {
        let mut magic = vec![0; MAGIC.len()];
        {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(0))?;
            file.read_exact(&mut magic)?;
        }
        if magic != MAGIC {
            return Err(damaged("not the beginning of a bag"));
        }
        let header = self.record(MAGIC.len() as u64)?;
        let index_at = field(&header.fields, b"index_pos").and_then(|value| value.try_into().ok());
        let index_at = index_at.ok_or_else(|| damaged("no place of the index"))?;
        Ok((header.end, u64::from_le_bytes(index_at)))
    }

    /// Whether the chunk at `at` lies in the file and announces a length that it can have.
    pub(crate) fn check_chunk(&self, at: u64) -> io::Result<()> {
        let record = self.record(at)?;
        let size = field(&record.fields, b"size").and_then(|value| value.try_into().ok());
        let size = u32::from_le_bytes(size.ok_or_else(|| damaged("chunk without size"))?);
        if size > MAX_CHUNK_LEN || u64::from(size) > u64::from(record.data_len) * MAX_RATIO {
            return Err(damaged("chunk announces more bytes than it can have"));
        }
        // What the others hold cannot be seen before it is unpacked.
        if field(&record.fields, b"compression") == Some(b"none") {
            self.check_no_chunk(record.end - u64::from(record.data_len), record.end)?;
        }
        Ok(())
    }

    /// Whether there is no chunk among the records from one offset to another. In the index or in another chunk it
    /// would be unpacked, too, whatever it announces.
    pub(crate) fn check_no_chunk(&self, mut at: u64, end: u64) -> io::Result<()> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let mut file = BufReader::new(&mut *file);
        file.seek(SeekFrom::Start(at))?;
        while at < end {
            let record = match self.record_from(&mut file, at) {
                // What comes before it is still read, and then this is reported.
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
                record => record?,
            };
            if field(&record.fields, b"op") == Some(CHUNK) {
                return Err(damaged("a chunk where none can be"));
            }
            file.seek_relative(i64::from(record.data_len))?;
            at = record.end;
        }
        Ok(())
    }

    fn record(&self, at: u64) -> io::Result<Record> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(at))?;
        self.record_from(&mut *file, at)
    }

    /// The record at `at`, which is where the file is read next; its data come after that.
    fn record_from(&self, file: &mut impl Read, at: u64) -> io::Result<Record> {
        let header_len = read_u32(file)?;
        if header_len > MAX_HEADER_LEN {
            return Err(damaged("record header too long"));
        }
        let mut fields = vec![0; header_len as usize];
        file.read_exact(&mut fields)?;
        let data_len = read_u32(file)?;
        let lengths = 8 + u64::from(header_len) + u64::from(data_len);
        let end = at.checked_add(lengths).filter(|end| *end <= self.len);
        let past_end = || io::Error::new(io::ErrorKind::UnexpectedEof, "record reaches past the end of the file");
        Ok(Record { fields, data_len, end: end.ok_or_else(past_end)? })
    }
}

/// The value of a header's field.
fn field<'a>(mut fields: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    while let Some((len, rest)) = fields.split_first_chunk::<4>() {
        let (field, rest) = rest.split_at_checked(u32::from_le_bytes(*len) as usize)?;
        if let Some(value) = field.strip_prefix(name).and_then(|value| value.strip_prefix(b"=")) {
            return Some(value);
        }
        fields = rest;
    }
    None
}

fn damaged(reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

fn read_u32(file: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}
