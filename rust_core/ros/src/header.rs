//! The connection header of TCPROS: `key=value` fields, each with its length before it, all with theirs.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

/// A header longer than this is no header; the longest parts are message definitions.
const MAX_LEN: u32 = 16 << 20;

/// The fields of a connection header.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Header(BTreeMap<String, String>);

impl Header {
    pub(crate) fn new<'a>(fields: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let owned = fields.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned()));
        Self(owned.collect())
    }

    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }

    pub(crate) fn is_set(&self, key: &str) -> bool {
        self.get(key) == Some("1")
    }

    pub(crate) fn read(stream: &mut impl Read) -> io::Result<Self> {
        let mut len = [0; 4];
        stream.read_exact(&mut len)?;
        let len = u32::from_le_bytes(len);
        if len > MAX_LEN {
            return Err(invalid(format!("connection header of {len} bytes")));
        }
        let mut bytes = Vec::new();
        stream.take(u64::from(len)).read_to_end(&mut bytes)?;
        if bytes.len() != len as usize {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Self::parse(&bytes)
    }

    fn parse(mut bytes: &[u8]) -> io::Result<Self> {
        let mut fields = BTreeMap::new();
        while !bytes.is_empty() {
            let (len, rest) = bytes.split_first_chunk().ok_or_else(|| invalid("connection header cut short".into()))?;
            let len = u32::from_le_bytes(*len) as usize;
            let (field, rest) =
                rest.split_at_checked(len).ok_or_else(|| invalid("connection header cut short".into()))?;
            let field = String::from_utf8_lossy(field);
            let (key, value) =
                field.split_once('=').ok_or_else(|| invalid(format!("connection header field '{field}'")))?;
            fields.insert(key.to_owned(), value.to_owned());
            bytes = rest;
        }
        Ok(Self(fields))
    }

    pub(crate) fn write(&self, stream: &mut impl Write) -> io::Result<()> {
        let mut bytes = vec![0; 4];
        for (key, value) in &self.0 {
            bytes.extend_from_slice(&len_prefix(key.len() + 1 + value.len()));
            bytes.extend_from_slice(key.as_bytes());
            bytes.push(b'=');
            bytes.extend_from_slice(value.as_bytes());
        }
        let len = len_prefix(bytes.len() - 4);
        bytes.splice(..4, len);
        stream.write_all(&bytes)
    }

    /// Whether the other end's type agrees with ours; `*` on either side does with all.
    pub(crate) fn check_type(&self, ours: &crate::TypeInfo) -> Result<(), String> {
        for (key, ours) in [("md5sum", &ours.md5sum), ("type", &ours.name)] {
            let theirs = self.get(key).unwrap_or("*");
            if theirs != ours && theirs != "*" && ours != "*" {
                return Err(format!("{key} is {theirs} there and {ours} here"));
            }
        }
        Ok(())
    }
}

fn len_prefix(len: usize) -> [u8; 4] {
    u32::try_from(len).unwrap_or(u32::MAX).to_le_bytes()
}

fn invalid(text: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_header_survives_the_wire() {
        let header = Header::new([("callerid", "/a"), ("message_definition", "a=b\nc"), ("latching", "1")]);
        let mut bytes = Vec::new();
        header.write(&mut bytes).unwrap();
        assert_eq!(Header::read(&mut bytes.as_slice()).unwrap(), header);
        assert!(header.is_set("latching"));
    }

    #[test]
    fn giant_lengths_are_errors() {
        assert!(Header::read(&mut [0xff; 12].as_slice()).is_err());
        assert!(Header::read(&mut [8, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0].as_slice()).is_err());
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
            let _ = Header::parse(&bytes);
        }
    }
}
