//! Text, XML and names as other people's tools write them.
//!
//! [`decode`] reads any encoding and end of line that is met in robots' files; [`xml`] reads what TinyXML (urdfdom,
//! rospack) and pugixml (Assimp) read, and tells what it passed over. [`graph_name`] takes ROS names as roscpp does.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, UTF_8, WINDOWS_1252};

mod graph_name;
pub mod xml;

pub use graph_name::{clean_name, full_name, graph_name, topic_name};

/// Bytes at the start of a file in which an XML declaration is looked for.
const DECLARATION_BYTES: usize = 256;

/// Decodes a text file; its lines end with `\n`, whatever ended them.
///
/// The encoding is that of the byte order mark, UTF-16 if every other of the first bytes is zero, that of the XML
/// declaration, else UTF-8; bytes that are no UTF-8 are Windows-1252, of which ISO-8859-1 is a part.
///
/// ```
/// assert_eq!(rcs_text::decode(b"\xef\xbb\xbfa\r\nb\rc\n"), "a\nb\nc\n");
/// assert_eq!(rcs_text::decode(b"v\xe9lo"), "vélo");
/// assert_eq!(rcs_text::decode(b"\xff\xfea\0\r\0b\0"), "a\nb");
/// ```
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let (encoding, mark_len) = encoding(bytes);
    let (text, _) = encoding.decode_without_bom_handling(bytes.get(mark_len..).unwrap_or_default());
    if text.contains('\r') {
        return text.replace("\r\n", "\n").replace('\r', "\n").into();
    }
    text
}

/// The encoding of a text, and the length of its byte order mark.
fn encoding(bytes: &[u8]) -> (&'static Encoding, usize) {
    if let Some(marked) = Encoding::for_bom(bytes) {
        return marked;
    }
    let encoding = match bytes {
        [0, 1..=255, 0, 1..=255, ..] => UTF_16BE,
        [1..=255, 0, 1..=255, 0, ..] => UTF_16LE,
        _ => declared(bytes).filter(|declared| *declared != UTF_8).unwrap_or_else(|| {
            let is_utf8 = std::str::from_utf8(bytes).is_ok();
            if is_utf8 {
                UTF_8
            } else {
                WINDOWS_1252
            }
        }),
    };
    (encoding, 0)
}

/// The encoding of an XML declaration, if the declaration itself can be read in it.
fn declared(bytes: &[u8]) -> Option<&'static Encoding> {
    let start = bytes.get(..bytes.len().min(DECLARATION_BYTES)).unwrap_or_default().trim_ascii_start();
    let start = std::str::from_utf8(start.strip_prefix(b"<?xml")?.split(|byte| *byte == b'>').next()?).ok()?;
    let (_, value) = start.split_once("encoding")?;
    let value = value.trim_start().strip_prefix('=')?.trim_start();
    let label = value.strip_prefix(['"', '\''])?.split(['"', '\'']).next()?;
    Encoding::for_label(label.as_bytes()).filter(|encoding| encoding.is_ascii_compatible())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_encoding_is_known_by_its_mark_its_zeros_or_its_declaration() {
        let text = "<?xml version='1.0' encoding='UTF-16'?>\r\n<é>\r</é>";
        let expected = text.replace("\r\n", "\n").replace('\r', "\n");
        let units = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        let with_mark = |mark: &[u8], bytes: Vec<u8>| [mark, &bytes].concat();
        for bytes in [
            units(u16::to_le_bytes),
            units(u16::to_be_bytes),
            with_mark(b"\xff\xfe", units(u16::to_le_bytes)),
            with_mark(b"\xfe\xff", units(u16::to_be_bytes)),
            with_mark(b"\xef\xbb\xbf", text.into()),
            text.into(),
        ] {
            assert_eq!(decode(&bytes), expected);
        }
        for (declared, bytes, expected) in [
            ("ISO-8859-1", &b"\xe9"[..], "é"),
            ("ISO-8859-1", b"\xc3\xa9", "Ã©"),
            ("utf-8", b"\xc3\xa9", "é"),
            // Declared in error.
            ("utf-8", b"\xe9", "é"),
            ("KOI8-R", b"\xc1", "а"),
            ("nonsense", b"\xc3\xa9", "é"),
        ] {
            let start = format!("<?xml version=\"1.0\" encoding = \"{declared}\"?>");
            assert_eq!(decode(&[start.as_bytes(), bytes].concat()), start + expected);
        }
    }

    #[test]
    fn text_without_anything_odd_is_not_copied() {
        for bytes in [&b""[..], b"a", b"a\nb\n", "é\n".as_bytes()] {
            assert!(matches!(decode(bytes), Cow::Borrowed(_)));
        }
        assert_eq!(decode(b"\0"), "\0");
        assert_eq!(decode(b"a\r\n\r\r\nb"), "a\n\n\nb");
    }
}
