//! Decompression of an MCAP file's chunks.

use std::borrow::Cow;
use std::io::{self, Read};

/// Longest unpacked chunk; recorders cut them below a few megabytes unless one message is longer.
const MAX_CHUNK_LEN: u64 = 1 << 30;
/// Highest compression ratio; bzip2 reaches some 50,000 on zeros.
const MAX_RATIO: u64 = 100_000;

/// Checks the length that a chunk of any format announces.
pub(crate) fn check_len(len: u64, packed_len: u64) -> io::Result<()> {
    if len > MAX_CHUNK_LEN || len > packed_len.saturating_mul(MAX_RATIO) {
        return Err(damaged("chunk announces more bytes than it can have"));
    }
    Ok(())
}

/// Unpacks the records of a chunk that announces `len` bytes.
pub(crate) fn unpack<'a>(compression: &[u8], packed: &'a [u8], len: u64) -> io::Result<Cow<'a, [u8]>> {
    check_len(len, packed.len() as u64)?;
    match compression {
        b"" => Ok(Cow::Borrowed(packed)),
        b"lz4" => read_all(lz4::Decoder::new(packed)?, len),
        b"zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new_with_max_window_size(packed, MAX_CHUNK_LEN);
            read_all(decoder.map_err(io::Error::other)?, len)
        }
        other => Err(damaged(&format!("compression '{}' is not supported", String::from_utf8_lossy(other)))),
    }
}

fn read_all(unpacked: impl Read, len: u64) -> io::Result<Cow<'static, [u8]>> {
    let mut bytes = Vec::new();
    unpacked.take(len).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == len {
        Ok(Cow::Owned(bytes))
    } else {
        Err(damaged("chunk holds fewer bytes than it announces"))
    }
}

pub(crate) fn damaged(reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}
