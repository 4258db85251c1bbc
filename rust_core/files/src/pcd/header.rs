//! The header of a PCD file.
//!
//! A PCD file (Point Cloud Library, versions 0.5 to 0.7) begins with lines of text, one entry each, in any order
//! up to `DATA`, after which the points follow:
//!
//! ```text
//! # comment
//! VERSION 0.7
//! FIELDS x y z rgb
//! SIZE 4 4 4 4          bytes of one element of each field: 1, 2, 4 or 8
//! TYPE F F F F          float, signed (I) or unsigned (U)
//! COUNT 1 1 1 1         elements of each field; 1 each when the line is missing
//! WIDTH 640
//! HEIGHT 480            1 for a cloud without rows
//! VIEWPOINT 0 0 0 1 0 0 0
//! POINTS 307200         WIDTH * HEIGHT when the line is missing
//! DATA binary           ascii, binary or binary_compressed
//! ```
//!
//! `VIEWPOINT` is read and not used: a PointCloud2 has no place for it, and PCL's points are already in the frame of
//! the cloud.

use std::fmt;

/// How one element of a field is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PcdType {
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
    /// The type that a `TYPE` letter and a `SIZE` stand for.
    pub fn of(letter: &str, size_bytes: usize) -> Option<Self> {
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

    /// Bytes of one element.
    pub fn size_bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// One field of the points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PcdField {
    /// Name; `_` is PCL's name for padding.
    pub name: String,
    /// Type of each element.
    pub kind: PcdType,
    /// Elements in each point, at least 1.
    pub count: usize,
    /// Place in the point, bytes.
    pub offset_bytes: usize,
}

impl PcdField {
    /// Bytes of the field in each point.
    pub(super) fn size_bytes(&self) -> usize {
        self.kind.size_bytes() * self.count
    }
}

/// How the points are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PcdEncoding {
    /// One line of text for each point.
    Ascii,
    /// The points' bytes one after another, little-endian.
    Binary,
    /// All values of the first field, then all of the second, ..., compressed with LZF.
    BinaryCompressed,
}

/// A whole header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PcdHeader {
    /// Fields in the order of the file, without gaps.
    pub fields: Vec<PcdField>,
    /// Points in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How the points are stored.
    pub encoding: PcdEncoding,
    /// Where the points begin in the file, bytes.
    pub data_offset_bytes: usize,
    /// The line on which the points begin, counted from 1.
    pub data_line: usize,
    /// Bytes of one point.
    pub point_step_bytes: usize,
}

/// Why a header cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeaderError {
    /// The line, counted from 1; `None` when a line is missing.
    pub line: Option<usize>,
    /// What is wrong with it.
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

/// The most bytes that a `sensor_msgs/PointCloud2` can hold: its data's length is a `uint32`.
const MOST_BYTES: u64 = u32::MAX as u64;

/// The entries of the file, each with its line.
#[derive(Default)]
struct Entries<'a> {
    names: Option<(usize, Vec<&'a str>)>,
    sizes: Option<(usize, Vec<&'a str>)>,
    types: Option<(usize, Vec<&'a str>)>,
    counts: Option<(usize, Vec<&'a str>)>,
    width: Option<(usize, u32)>,
    height: Option<(usize, u32)>,
    points: Option<(usize, u64)>,
}

impl PcdHeader {
    /// Reads the header at the beginning of a file.
    ///
    /// # Errors
    /// [`HeaderError`] with the line that is wrong or the entry that is missing.
    pub(super) fn parse(file: &[u8]) -> Result<Self, HeaderError> {
        let mut entries = Entries::default();
        let mut offset = 0;
        for line_number in 1.. {
            let rest = file.get(offset..).unwrap_or(&[]);
            if rest.is_empty() {
                return Err(missing("there is no DATA line: not a PCD file, or cut off in its header"));
            }
            let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
            let text = rest.get(..length).unwrap_or(rest);
            offset += (length + 1).min(rest.len());
            let fail = |reason: String| HeaderError { line: Some(line_number), reason };
            let text = std::str::from_utf8(text)
                .map_err(|_| fail("not text: not a PCD file, or its DATA line is missing".to_owned()))?;
            let mut words = text.split_ascii_whitespace();
            let Some(entry) = words.next().filter(|word| !word.starts_with('#')) else {
                continue;
            };
            let values: Vec<&str> = words.collect();
            let one = || match values.as_slice() {
                [value] => Ok(*value),
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
                other => return Err(fail(format!("'{}' is no entry of a PCD header", shorten(other)))),
            }
        }
        Err(missing("there is no DATA line"))
    }

    /// How many points there are.
    pub(super) fn points(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Bytes of all points together; at most 4 GiB.
    pub(super) fn total_bytes(&self) -> usize {
        self.points() * self.point_step_bytes
    }
}

impl Entries<'_> {
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

    /// Width and height, from whichever of WIDTH, HEIGHT and POINTS there are.
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
        let (size_line, sizes) = self.sizes.as_ref().ok_or_else(|| missing("there is no SIZE line"))?;
        let (type_line, types) = self.types.as_ref().ok_or_else(|| missing("there is no TYPE line"))?;
        if names.is_empty() {
            return Err(HeaderError { line: Some(*names_line), reason: "FIELDS names no field".to_owned() });
        }
        let same_length = |line: usize, entry: &str, values: &[&str]| {
            if values.len() == names.len() {
                return Ok(());
            }
            Err(HeaderError {
                line: Some(line),
                reason: format!("{entry} has {} values for {} FIELDS", values.len(), names.len()),
            })
        };
        same_length(*size_line, "SIZE", sizes)?;
        same_length(*type_line, "TYPE", types)?;
        if let Some((line, counts)) = &self.counts {
            same_length(*line, "COUNT", counts)?;
        }
        let mut fields = Vec::with_capacity(names.len());
        let mut offset_bytes = 0usize;
        for (index, ((name, size), letter)) in names.iter().zip(sizes).zip(types).enumerate() {
            let kind = size.parse().ok().and_then(|size| PcdType::of(letter, size));
            let kind = kind.ok_or_else(|| HeaderError {
                line: Some(*type_line),
                reason: format!("field '{}': no type {letter} of SIZE {size} exists", shorten(name)),
            })?;
            let count = match &self.counts {
                None => 1,
                Some((line, counts)) => {
                    let text = counts.get(index).copied().unwrap_or_default();
                    let count = text.parse::<u32>().ok().filter(|count| *count > 0);
                    let count = count.ok_or_else(|| HeaderError {
                        line: Some(*line),
                        reason: format!("field '{}': COUNT {text} is not a number from 1", shorten(name)),
                    })?;
                    count as usize
                }
            };
            let field = PcdField { name: (*name).to_owned(), kind, count, offset_bytes };
            offset_bytes = offset_bytes
                .checked_add(field.size_bytes())
                .filter(|bytes| *bytes as u64 <= MOST_BYTES)
                .ok_or_else(|| missing("a point is larger than a PointCloud2 can hold"))?;
            fields.push(field);
        }
        Ok(fields)
    }
}

fn missing(reason: impl Into<String>) -> HeaderError {
    HeaderError { line: None, reason: reason.into() }
}

/// A word for a message, cut to a readable length.
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
            ("COUNT 1 3 1", "COUNT 1 0 1", Some(6), "'normal'"),
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
