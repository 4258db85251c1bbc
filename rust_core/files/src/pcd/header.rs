//! The header of a PCD file.
//!
//! A PCD file (Point Cloud Library, versions 0.5 to 0.7) begins with lines of text, one entry each, in any order
//! up to `DATA`, after which the points follow. Bytes that are not UTF-8, as in comments of Windows tools, are allowed.
//!
//! ```text
//! # comment
//! VERSION 0.7
//! FIELDS x y z rgb
//! SIZE 4 4 4 4          bytes of one element of each field: 1, 2, 4 or 8; 4 each when the line is missing
//! TYPE F F F F          float, signed (I) or unsigned (U); float each when the line is missing
//! COUNT 1 1 1 1         elements of each field, which 0 drops; 1 each when the line is missing
//! WIDTH 640
//! HEIGHT 480            1 for a cloud without rows
//! VIEWPOINT 0 0 0 1 0 0 0
//! POINTS 307200         WIDTH * HEIGHT when the line is missing
//! DATA binary           ascii, binary or binary_compressed
//! ```
//!
//! `VIEWPOINT` is not used: a PointCloud2 cannot hold it, and PCL's points are already in the frame of the cloud.

use std::fmt;

use rcs_messages::sensor_msgs::PointField;

/// Type of a field's elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PcdType {
    /// Signed, 1 byte.
    I8,
    /// Unsigned, 1 byte.
    U8,
    /// Signed, 2 bytes.
    I16,
    /// Unsigned, 2 bytes.
    U16,
    /// Signed, 4 bytes.
    I32,
    /// Unsigned, 4 bytes.
    U32,
    /// Signed, 8 bytes.
    I64,
    /// Unsigned, 8 bytes.
    U64,
    /// Floating point, 4 bytes.
    F32,
    /// Floating point, 8 bytes.
    F64,
}

impl PcdType {
    /// Type by a `TYPE` letter and a `SIZE`.
    pub(super) fn of(letter: &str, size_bytes: usize) -> Option<Self> {
        Some(match (letter.to_ascii_uppercase().as_str(), size_bytes) {
            ("I", 1) => Self::I8,
            ("U", 1) => Self::U8,
            ("I", 2) => Self::I16,
            ("U", 2) => Self::U16,
            ("I", 4) => Self::I32,
            ("U", 4) => Self::U32,
            ("I", 8) => Self::I64,
            ("U", 8) => Self::U64,
            ("F", 4) => Self::F32,
            ("F", 8) => Self::F64,
            _ => return None,
        })
    }

    /// Datatype of a PointField, which has no integers of 8 bytes.
    pub(super) fn datatype(self) -> u8 {
        match self {
            Self::I8 => PointField::INT8,
            Self::U8 => PointField::UINT8,
            Self::I16 => PointField::INT16,
            Self::U16 => PointField::UINT16,
            Self::I32 => PointField::INT32,
            Self::U32 => PointField::UINT32,
            Self::F32 => PointField::FLOAT32,
            Self::F64 | Self::I64 | Self::U64 => PointField::FLOAT64,
        }
    }

    /// Bytes of an element.
    pub(super) fn size_bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// A field of the points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PcdField {
    /// Name, `_` for padding.
    pub name: String,
    /// Type of each element.
    pub kind: PcdType,
    /// Elements in each point, at least 1.
    pub count: usize,
    /// Offset in the point, bytes.
    pub offset_bytes: usize,
}

impl PcdField {
    /// Bytes of the field in each point.
    pub(super) fn size_bytes(&self) -> usize {
        self.kind.size_bytes() * self.count
    }
}

/// Encoding of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PcdEncoding {
    /// A line of text for each point.
    Ascii,
    /// Bytes of the points, little-endian.
    Binary,
    /// Values of the first field, then of the second, and so on, compressed with LZF.
    BinaryCompressed,
}

/// A header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PcdHeader {
    /// Fields in the order of the file, without gaps.
    pub fields: Vec<PcdField>,
    /// Points in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Encoding of the points.
    pub encoding: PcdEncoding,
    /// Offset of the points in the file, bytes.
    pub data_offset_bytes: usize,
    /// First line of the points, from 1.
    pub data_line: usize,
    /// Bytes of a point.
    pub point_step_bytes: usize,
}

/// A header is invalid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct HeaderError {
    /// Line, from 1; `None` for a missing line.
    pub line: Option<usize>,
    /// Reason.
    pub reason: String,
}

impl fmt::Display for HeaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.reason),
            None => write!(f, "{}", self.reason),
        }
    }
}

/// Most bytes of a `sensor_msgs/PointCloud2`, whose length is a `uint32`.
const MOST_BYTES: u64 = u32::MAX as u64;

/// Entries of the file with their lines.
#[derive(Default)]
struct Entries {
    names: Option<(usize, Vec<String>)>,
    sizes: Option<(usize, Vec<String>)>,
    types: Option<(usize, Vec<String>)>,
    counts: Option<(usize, Vec<String>)>,
    width: Option<(usize, u32)>,
    height: Option<(usize, u32)>,
    points: Option<(usize, u64)>,
}

impl PcdHeader {
    /// Parses the header at the beginning of a file.
    ///
    /// # Errors
    /// [`HeaderError`] with the invalid line or the missing entry.
    pub(super) fn parse(file: &[u8]) -> Result<Self, HeaderError> {
        let mut entries = Entries::default();
        let mut offset = if file.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        for line_number in 1.. {
            let rest = file.get(offset..).unwrap_or(&[]);
            if rest.is_empty() {
                return Err(missing("there is no DATA line: not a PCD file, or cut off in its header"));
            }
            let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
            let text = rest.get(..length).unwrap_or(rest);
            offset += (length + 1).min(rest.len());
            let fail = |reason: String| HeaderError { line: Some(line_number), reason };
            let text = String::from_utf8_lossy(text);
            let mut words = text.split_ascii_whitespace();
            let Some(entry) = words.next().filter(|word| !word.starts_with('#')) else {
                continue;
            };
            let values: Vec<String> = words.map(str::to_owned).collect();
            let one = || match values.as_slice() {
                [value] => Ok(value.as_str()),
                _ => Err(fail(format!("{entry} takes one value, not {}", values.len()))),
            };
            let number = || {
                let value = one()?;
                value.parse::<u32>().map_err(|_| fail(format!("{entry} {value}: not a number from 0 to {}", u32::MAX)))
            };
            match entry {
                "VERSION" | "VIEWPOINT" => {}
                "FIELDS" | "COLUMNS" => entries.names = Some((line_number, values)),
                "SIZE" => entries.sizes = Some((line_number, values)),
                "TYPE" => entries.types = Some((line_number, values)),
                "COUNT" => entries.counts = Some((line_number, values)),
                "WIDTH" => entries.width = Some((line_number, number()?)),
                "HEIGHT" => entries.height = Some((line_number, number()?)),
                "POINTS" => entries.points = Some((line_number, u64::from(number()?))),
                "DATA" => {
                    let encoding = match one()? {
                        "ascii" => PcdEncoding::Ascii,
                        "binary" => PcdEncoding::Binary,
                        "binary_compressed" => PcdEncoding::BinaryCompressed,
                        other => {
                            return Err(fail(format!("DATA {other}: not one of ascii, binary, binary_compressed")))
                        }
                    };
                    return entries.finish(encoding, offset, line_number + 1);
                }
                other if other.contains('\u{fffd}') => {
                    return Err(fail("not text: not a PCD file, or its DATA line is missing".to_owned()))
                }
                other => return Err(fail(format!("'{}' is no entry of a PCD header", shorten(other)))),
            }
        }
        Err(missing("there is no DATA line"))
    }

    /// Number of points.
    pub(super) fn points(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Bytes of all points, at most 4 GiB.
    pub(super) fn total_bytes(&self) -> usize {
        self.points() * self.point_step_bytes
    }
}

impl Entries {
    fn finish(
        self,
        encoding: PcdEncoding,
        data_offset_bytes: usize,
        data_line: usize,
    ) -> Result<PcdHeader, HeaderError> {
        let (width, height) = self.size()?;
        let fields = self.fields()?;
        let point_step_bytes = fields.iter().map(PcdField::size_bytes).sum::<usize>();
        let total = u64::from(width)
            .checked_mul(u64::from(height))
            .and_then(|points| points.checked_mul(point_step_bytes as u64));
        if total.is_none_or(|total| total > MOST_BYTES) {
            return Err(missing(format!(
                "{width}x{height} points of {point_step_bytes} bytes are more than the {MOST_BYTES} bytes that a \
                 PointCloud2 holds"
            )));
        }
        Ok(PcdHeader { fields, width, height, encoding, data_offset_bytes, data_line, point_step_bytes })
    }

    /// Width and height by WIDTH, HEIGHT and POINTS, of which some may be missing.
    fn size(&self) -> Result<(u32, u32), HeaderError> {
        let points = self.points;
        let height = self.height.map_or(1, |(_, height)| height);
        let width = match (self.width, points) {
            (Some((_, width)), _) => width,
            // Old files give only the number of points, which were read as a number of 32 bits.
            (None, Some((_, points))) if height == 1 => u32::try_from(points).unwrap_or(u32::MAX),
            _ => return Err(missing("there is no WIDTH line")),
        };
        let product = u64::from(width) * u64::from(height);
        match points {
            Some((line, points)) if points != product => Err(HeaderError {
                line: Some(line),
                reason: format!("POINTS {points} is not WIDTH {width} times HEIGHT {height}"),
            }),
            _ => Ok((width, height)),
        }
    }

    fn fields(&self) -> Result<Vec<PcdField>, HeaderError> {
        let (names_line, names) = self.names.as_ref().ok_or_else(|| missing("there is no FIELDS line"))?;
        if names.is_empty() {
            return Err(HeaderError { line: Some(*names_line), reason: "FIELDS names no field".to_owned() });
        }
        for (entry, values) in [("SIZE", &self.sizes), ("TYPE", &self.types), ("COUNT", &self.counts)] {
            let Some((line, values)) = values.as_ref().filter(|(_, values)| values.len() != names.len()) else {
                continue;
            };
            let reason = format!("{entry} has {} values for {} FIELDS", values.len(), names.len());
            return Err(HeaderError { line: Some(*line), reason });
        }
        let mut fields = Vec::with_capacity(names.len());
        let mut offset_bytes = 0usize;
        for (index, name) in names.iter().enumerate() {
            let (kind, count) = (self.kind(index, name)?, self.count(index, name)?);
            if count == 0 {
                continue;
            }
            let field = PcdField { name: name.clone(), kind, count, offset_bytes };
            offset_bytes = offset_bytes
                .checked_add(field.size_bytes())
                .filter(|bytes| *bytes as u64 <= MOST_BYTES)
                .ok_or_else(|| missing("a point is larger than a PointCloud2 can hold"))?;
            fields.push(field);
        }
        if fields.is_empty() {
            return Err(missing("COUNT is 0 for all FIELDS"));
        }
        Ok(fields)
    }

    /// Type of a field: floats of 4 bytes without TYPE and SIZE, as in PCL.
    fn kind(&self, index: usize, name: &str) -> Result<PcdType, HeaderError> {
        let value = |entry: &'_ Option<(usize, Vec<String>)>, default: &str| {
            let given = entry.as_ref().and_then(|(_, values)| values.get(index));
            given.map_or_else(|| default.to_owned(), String::clone)
        };
        let (letter, size) = (value(&self.types, "F"), value(&self.sizes, "4"));
        let kind = size.parse().ok().and_then(|size| PcdType::of(&letter, size));
        kind.ok_or_else(|| HeaderError {
            line: self.types.as_ref().or(self.sizes.as_ref()).map(|(line, _)| *line),
            reason: format!("field '{}': no type {letter} of SIZE {size} exists", shorten(name)),
        })
    }

    /// Number of a field's elements.
    fn count(&self, index: usize, name: &str) -> Result<usize, HeaderError> {
        let Some((line, counts)) = &self.counts else { return Ok(1) };
        let text = counts.get(index).map(String::as_str).unwrap_or_default();
        text.parse::<u32>().map(|count| count as usize).map_err(|_| HeaderError {
            line: Some(*line),
            reason: format!("field '{}': COUNT {text} is not a number from 0", shorten(name)),
        })
    }
}

fn missing(reason: impl Into<String>) -> HeaderError {
    HeaderError { line: None, reason: reason.into() }
}

/// A word of a message, cut to a readable length.
fn shorten(word: &str) -> String {
    word.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "# .PCD v0.7\nVERSION 0.7\nFIELDS x normal id\nSIZE 4 8 1\nTYPE F F u\nCOUNT 1 3 1\n\
                         WIDTH 3\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 6\nDATA binary\nrest";

    fn error(from: &str, to: &str) -> HeaderError {
        let text = WHOLE.replace(from, to);
        assert_ne!(text, WHOLE, "the test changes something");
        PcdHeader::parse(text.as_bytes()).unwrap_err()
    }

    #[test]
    fn every_entry_is_read() {
        let header = PcdHeader::parse(WHOLE.as_bytes()).unwrap();
        assert_eq!((header.width, header.height, header.points()), (3, 2, 6));
        assert_eq!(header.encoding, PcdEncoding::Binary);
        assert_eq!(&WHOLE.as_bytes()[header.data_offset_bytes..], b"rest");
        assert_eq!(header.data_line, 12);
        let fields: Vec<_> = header.fields.iter().map(|f| (f.name.as_str(), f.kind, f.count, f.offset_bytes)).collect();
        assert_eq!(fields, [("x", PcdType::F32, 1, 0), ("normal", PcdType::F64, 3, 4), ("id", PcdType::U8, 1, 28)]);
        assert_eq!(header.point_step_bytes, 29);
        assert_eq!(header.total_bytes(), 174);
    }

    #[test]
    fn old_and_short_headers_get_their_defaults() {
        let text = "COLUMNS x y\r\nSIZE 4 4\r\nTYPE F F\r\nPOINTS 7\r\nDATA ascii\r\n";
        let header = PcdHeader::parse(text.as_bytes()).unwrap();
        assert_eq!((header.width, header.height), (7, 1));
        assert!(header.fields.iter().all(|field| field.count == 1));
    }

    #[test]
    fn errors_name_the_line_and_the_entry() {
        let cases = [
            ("SIZE 4 8 1", "SIZE 4 8", Some(4), "SIZE"),
            ("SIZE 4 8 1", "SIZE 3 8 1", Some(5), "'x'"),
            ("TYPE F F u", "TYPE F X u", Some(5), "'normal'"),
            ("COUNT 1 3 1", "COUNT 1 -1 1", Some(6), "'normal'"),
            ("COUNT 1 3 1", "COUNT 0 0 0", None, "COUNT is 0"),
            ("TYPE F F u\n", "", Some(4), "no type F of SIZE 1"),
            ("WIDTH 3", "WIDTH -3", Some(7), "WIDTH -3"),
            ("WIDTH 3", "WIDTH 3 3", Some(7), "WIDTH"),
            ("POINTS 6", "POINTS 5", Some(10), "POINTS 5"),
            ("DATA binary", "DATA gzip", Some(11), "gzip"),
            ("FIELDS x normal id", "FIELDS", Some(3), "no field"),
            ("HEIGHT 2", "HIGHT 2", Some(8), "HIGHT"),
            ("FIELDS x normal id\n", "", None, "FIELDS"),
            ("DATA binary\n", "", Some(11), "rest"),
        ];
        for (from, to, line, word) in cases {
            let error = error(from, to);
            assert_eq!(error.line, line, "{error}");
            assert!(error.reason.contains(word), "{error}");
        }
    }

    #[test]
    fn a_field_with_count_0_takes_no_place() {
        let header = PcdHeader::parse(WHOLE.replace("COUNT 1 3 1", "COUNT 1 0 1").as_bytes()).unwrap();
        let fields: Vec<_> = header.fields.iter().map(|f| (f.name.as_str(), f.offset_bytes)).collect();
        assert_eq!((fields, header.point_step_bytes), (vec![("x", 0), ("id", 4)], 5));
    }

    #[test]
    fn fields_without_size_and_type_are_floats_of_4_bytes() {
        let kinds = |text: &str| {
            let header = PcdHeader::parse(text.as_bytes()).unwrap();
            header.fields.iter().map(|field| field.kind).collect::<Vec<_>>()
        };
        assert_eq!(kinds("FIELDS x y\nWIDTH 1\nHEIGHT 1\nDATA ascii\n"), [PcdType::F32; 2]);
        assert_eq!(kinds("FIELDS x y\nSIZE 4 8\nWIDTH 1\nDATA ascii\n"), [PcdType::F32, PcdType::F64]);
        assert_eq!(kinds("FIELDS x y\nTYPE F U\nWIDTH 1\nDATA ascii\n"), [PcdType::F32, PcdType::U32]);
    }

    #[test]
    fn comments_may_be_latin_1_and_a_byte_order_mark_may_come_first() {
        let marked = [b"\xef\xbb\xbf# Gr\xf6\xdfe\n", WHOLE.as_bytes()].concat();
        let header = PcdHeader::parse(&marked).unwrap();
        assert_eq!((header.points(), &marked[header.data_offset_bytes..]), (6, &b"rest"[..]));
        let marked = [b"\xef\xbb\xbf", WHOLE.as_bytes()].concat();
        assert_eq!(&marked[PcdHeader::parse(&marked).unwrap().data_offset_bytes..], b"rest");
        let error = PcdHeader::parse(b"# comment\n\xff\xfe\x01 binary\n").unwrap_err();
        assert_eq!((error.line, error.reason.starts_with("not text")), (Some(2), true));
    }

    #[test]
    fn a_cloud_that_no_message_can_hold_is_refused() {
        let text = WHOLE
            .replace("WIDTH 3", "WIDTH 4000000000")
            .replace("POINTS 6\n", "")
            .replace("COUNT 1 3 1", "COUNT 1 4000000000 1");
        assert!(PcdHeader::parse(text.as_bytes()).is_err());
        let text = WHOLE
            .replace("WIDTH 3", "WIDTH 4000000000")
            .replace("POINTS 6\n", "")
            .replace("HEIGHT 2", "HEIGHT 4000000000");
        let error = PcdHeader::parse(text.as_bytes()).unwrap_err();
        assert!(error.reason.contains("PointCloud2"), "{error}");
    }
}
