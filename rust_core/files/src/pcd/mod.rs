//! PCD files in the layout of a PointCloud2.
//!
//! All three encodings (`ascii`, `binary`, `binary_compressed`) are read, with any fields, types, counts and sizes. A
//! PointCloud2 has no integers of 8 bytes, which become `FLOAT64` (exact up to 2^53), and no fields for padding (`_`).
//!
//! As in PCL, decimals are allowed in fields of integers, and a row of text with another number of values is skipped
//! with a warning. PCL leaves a point of zeros in its place; here an organised cloud has NaN there, and any other cloud
//! becomes shorter.
//!
//! Crates that read PCD files decode each point into a list of typed values, which would have to be encoded again.

mod ascii;
mod coordinates;
mod header;
mod lzf;

use std::fmt::Display;
use std::path::Path;

use rcs_messages::sensor_msgs::PointField;

use crate::FileError;
use header::{PcdEncoding, PcdField, PcdHeader, PcdType};

/// Largest file that is read: more than a message holds.
const MOST_FILE_BYTES: u64 = 8 << 30;

/// A point cloud: `height` rows of `width` points of `point_step_bytes`, little-endian, without padding between them.
///
/// ```
/// use rcs_files::pcd::PcdCloud;
/// use std::path::Path;
///
/// let file = b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n0.5 -1 2\n";
/// let cloud = PcdCloud::parse(Path::new("one.pcd"), file)?;
/// assert_eq!((cloud.width, cloud.height, cloud.point_step_bytes), (1, 1, 12));
/// assert_eq!(cloud.data[4..8], (-1.0_f32).to_le_bytes());
/// # Ok::<(), rcs_files::FileError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PcdCloud {
    /// Points in a row.
    pub width: u32,
    /// Rows; 1 for a cloud without order.
    pub height: u32,
    /// Fields without padding.
    pub fields: Vec<PointField>,
    /// Bytes of a point.
    pub point_step_bytes: u32,
    /// `true` if x, y and z of all points are finite.
    pub is_dense: bool,
    /// Points.
    pub data: Vec<u8>,
}

impl PcdCloud {
    /// Reads a file.
    ///
    /// # Errors
    /// [`FileError`] with the file and the line or offset.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let bytes = rcs_user_files::read(path, MOST_FILE_BYTES).map_err(|error| FileError::new(path, error))?;
        Self::parse(path, &bytes)
    }

    /// Parses the contents of a file; `path` is for errors.
    ///
    /// # Errors
    /// [`FileError`] with the file and the line or offset.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let header = PcdHeader::parse(bytes).map_err(|error| FileError::new(path, error))?;
        let body = bytes.get(header.data_offset_bytes..).unwrap_or(&[]);
        let reader = BodyReader { path, header: &header };
        let (mut data, skipped) = match header.encoding {
            PcdEncoding::Ascii => reader.ascii(body)?,
            PcdEncoding::Binary => (reader.binary(body)?, 0),
            PcdEncoding::BinaryCompressed => (reader.binary_compressed(body)?, 0),
        };
        integers_to_floats(&header, &mut data);
        Ok(Self {
            width: if header.height == 1 { header.width - skipped } else { header.width },
            height: header.height,
            is_dense: is_dense(&header, &data),
            fields: cloud_fields(&header),
            // The header's reader allows no cloud of more than 4 GiB.
            point_step_bytes: to_u32(header.point_step_bytes),
            data,
        })
    }
}

fn to_u32(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

fn cloud_fields(header: &PcdHeader) -> Vec<PointField> {
    let named = header.fields.iter().filter(|field| field.name != "_");
    let message = |field: &PcdField| PointField {
        name: field.name.clone(),
        offset: to_u32(field.offset_bytes),
        datatype: field.kind.datatype(),
        count: to_u32(field.count),
    };
    named.map(message).collect()
}

/// Calls `change` with each element of a field.
fn for_each_element(header: &PcdHeader, field: &PcdField, data: &mut [u8], mut change: impl FnMut(&mut [u8])) {
    for point in data.chunks_exact_mut(header.point_step_bytes.max(1)) {
        let bytes = point.get_mut(field.offset_bytes..field.offset_bytes + field.size_bytes());
        for element in bytes.unwrap_or_default().chunks_exact_mut(field.kind.size_bytes()) {
            change(element);
        }
    }
}

/// Converts integers of 8 bytes, for which a PointCloud2 has no type, to floats.
fn integers_to_floats(header: &PcdHeader, data: &mut [u8]) {
    for field in &header.fields {
        if !matches!(field.kind, PcdType::I64 | PcdType::U64) {
            continue;
        }
        for_each_element(header, field, data, |element| {
            let Ok(bytes) = <[u8; 8]>::try_from(&*element) else {
                return;
            };
            let value = match field.kind {
                PcdType::I64 => i64::from_le_bytes(bytes) as f64,
                _ => u64::from_le_bytes(bytes) as f64,
            };
            element.copy_from_slice(&value.to_le_bytes());
        });
    }
}

fn is_dense(header: &PcdHeader, data: &[u8]) -> bool {
    let coordinates: Vec<&PcdField> =
        header.fields.iter().filter(|field| ["x", "y", "z"].contains(&field.name.as_str())).collect();
    let is_finite = |point: &[u8], field: &PcdField| {
        let bytes = point.get(field.offset_bytes..field.offset_bytes + field.kind.size_bytes());
        match (field.kind, bytes) {
            (PcdType::F32, Some(&[a, b, c, d])) => f32::from_le_bytes([a, b, c, d]).is_finite(),
            (PcdType::F64, Some(&[a, b, c, d, e, f, g, h])) => f64::from_le_bytes([a, b, c, d, e, f, g, h]).is_finite(),
            _ => true,
        }
    };
    data.chunks_exact(header.point_step_bytes.max(1))
        .all(|point| coordinates.iter().all(|field| is_finite(point, field)))
}

/// Reads the points after the header.
struct BodyReader<'a> {
    path: &'a Path,
    header: &'a PcdHeader,
}

impl BodyReader<'_> {
    fn data_error(&self, offset_in_body: usize, reason: impl Display) -> FileError {
        let offset = self.header.data_offset_bytes + offset_in_body;
        FileError::new(self.path, format_args!("at byte {offset}: {reason}"))
    }

    /// Bytes after the last point are ignored, because PCL pads its files to whole pages.
    fn binary(&self, body: &[u8]) -> Result<Vec<u8>, FileError> {
        let needed = self.header.total_bytes();
        let points = body.get(..needed).ok_or_else(|| {
            let reason = format!(
                "the file ends: {} points of {} bytes need {needed} bytes, there are {}",
                self.header.points(),
                self.header.point_step_bytes,
                body.len()
            );
            self.data_error(body.len(), reason)
        })?;
        Ok(points.to_vec())
    }

    fn binary_compressed(&self, body: &[u8]) -> Result<Vec<u8>, FileError> {
        let Some((&[a, b, c, d, e, f, g, h], rest)) = body.split_first_chunk::<8>() else {
            return Err(self.data_error(body.len(), "the file ends before the sizes of its data"));
        };
        let compressed_bytes = u32::from_le_bytes([a, b, c, d]) as usize;
        let uncompressed_bytes = u32::from_le_bytes([e, f, g, h]) as usize;
        let total = self.header.total_bytes();
        if uncompressed_bytes != total {
            let reason = format!("the data claim {uncompressed_bytes} bytes, the header's points need {total}");
            return Err(self.data_error(4, reason));
        }
        let compressed = rest.get(..compressed_bytes).ok_or_else(|| {
            let reason =
                format!("the file ends: {compressed_bytes} compressed bytes are announced, there are {}", rest.len());
            self.data_error(body.len(), reason)
        })?;
        let by_field = lzf::decompress(compressed, total).map_err(|error| self.data_error(8, error))?;
        Ok(self.points_from_fields(&by_field))
    }

    /// Interleaves the fields: "all x, all y, all z" becomes "x y z, x y z".
    fn points_from_fields(&self, by_field: &[u8]) -> Vec<u8> {
        let step = self.header.point_step_bytes;
        let mut data = vec![0; by_field.len()];
        let mut rest = by_field;
        for field in &self.header.fields {
            let size = field.size_bytes();
            let (values, after) = rest.split_at((size * self.header.points()).min(rest.len()));
            rest = after;
            for (point, value) in data.chunks_exact_mut(step).zip(values.chunks_exact(size)) {
                if let Some(place) = point.get_mut(field.offset_bytes..field.offset_bytes + size) {
                    place.copy_from_slice(value);
                }
            }
        }
        data
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(bytes: &[u8]) -> Result<PcdCloud, FileError> {
        PcdCloud::parse(Path::new("cloud.pcd"), bytes)
    }

    const HEADER: &str = "VERSION 0.7\nFIELDS x y z rgb _ label\nSIZE 4 4 4 4 1 8\nTYPE F F F U U I\n\
                          COUNT 1 1 1 1 3 2\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ";

    /// Two points in HEADER's fields, as text and as bytes.
    const TEXT: &str = "1.5 -2 nan 16711680 0 0 0 -1 7\n\n0.25 1e-3 inf 255 0 0 0 9 4294967296\n";

    fn point_bytes(xyz: [f32; 3], rgb: u32, label: [i64; 2]) -> Vec<u8> {
        let mut bytes: Vec<u8> = xyz.iter().flat_map(|value| value.to_le_bytes()).collect();
        bytes.extend(rgb.to_le_bytes());
        bytes.extend([0; 3]);
        bytes.extend(label.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    fn points() -> [Vec<u8>; 2] {
        [
            point_bytes([1.5, -2.0, f32::NAN], 0xff0000, [-1, 7]),
            point_bytes([0.25, 1e-3, f32::INFINITY], 0xff, [9, 1 << 32]),
        ]
    }

    fn binary_file() -> Vec<u8> {
        [HEADER.as_bytes(), b"binary\n", &points().concat()].concat()
    }

    /// Literal runs only, which is valid LZF.
    fn compressed_file() -> Vec<u8> {
        let points = points();
        let mut by_field = Vec::new();
        for (start, end) in [(0, 4), (4, 8), (8, 12), (12, 16), (16, 19), (19, 35)] {
            for point in &points {
                by_field.extend_from_slice(&point[start..end]);
            }
        }
        let mut compressed = Vec::new();
        for run in by_field.chunks(32) {
            compressed.push(run.len() as u8 - 1);
            compressed.extend_from_slice(run);
        }
        [
            HEADER.as_bytes(),
            b"binary_compressed\n",
            &(compressed.len() as u32).to_le_bytes(),
            &(by_field.len() as u32).to_le_bytes(),
            &compressed,
        ]
        .concat()
    }

    fn ascii_file() -> Vec<u8> {
        [HEADER.as_bytes(), b"ascii\n", TEXT.as_bytes()].concat()
    }

    #[test]
    fn the_three_encodings_give_the_same_points() {
        let ascii = parse(&ascii_file()).unwrap();
        let binary = parse(&binary_file()).unwrap();
        let compressed = parse(&compressed_file()).unwrap();
        assert_eq!(ascii, binary);
        assert_eq!(binary, compressed);
        assert_eq!((ascii.width, ascii.height, ascii.point_step_bytes), (2, 1, 35));
        assert_eq!(ascii.data[..19], points()[0][..19]);
    }

    #[test]
    fn padding_is_unnamed_and_wide_integers_become_floats() {
        let cloud = parse(&binary_file()).unwrap();
        let names: Vec<&str> = cloud.fields.iter().map(|field| field.name.as_str()).collect();
        assert_eq!(names, ["x", "y", "z", "rgb", "label"]);
        let label = cloud.fields.last().unwrap();
        assert_eq!((label.datatype, label.offset, label.count), (PointField::FLOAT64, 19, 2));
        let second: [u8; 8] = cloud.data[35 + 27..].try_into().unwrap();
        assert_eq!(f64::from_le_bytes(second), 4294967296.0);
    }

    #[test]
    fn a_cloud_is_dense_only_when_all_coordinates_are_finite() {
        assert!(!parse(&binary_file()).unwrap().is_dense);
        let text = String::from_utf8(ascii_file()).unwrap().replace("nan", "0").replace("inf", "0");
        assert!(parse(text.as_bytes()).unwrap().is_dense);
    }

    #[test]
    fn an_organised_cloud_keeps_its_rows_and_an_empty_one_is_a_cloud() {
        let file = "FIELDS x\nSIZE 2\nTYPE I\nWIDTH 3\nHEIGHT 2\nDATA ascii\n1\n2\n3\n4\n5\n-6\n";
        let cloud = parse(file.as_bytes()).unwrap();
        assert_eq!((cloud.width, cloud.height), (3, 2));
        assert_eq!(cloud.data, [1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 250, 255]);
        let empty = parse(b"FIELDS x\nSIZE 4\nTYPE F\nWIDTH 0\nHEIGHT 1\nDATA binary\n").unwrap();
        assert!(empty.data.is_empty());
    }

    #[test]
    fn errors_name_the_file_and_the_line() {
        let text = String::from_utf8(ascii_file()).unwrap();
        let cases = [
            (text.replace("-2 nan", "two nan"), "cloud.pcd: line 10: field 'y': 'two'"),
            (text.replace("16711680", "-1"), "cloud.pcd: line 10: field 'rgb': '-1'"),
            (text.replace("16711680", "256e9"), "cloud.pcd: line 10: field 'rgb': '256e9'"),
            (text.replace("16711680", "nan"), "cloud.pcd: line 10: field 'rgb': 'nan'"),
            (text.replace(" 7\n", "\n").replace(" 4294967296", ""), "cloud.pcd: line 10: 8 values for the 9 of"),
            (text.replace("0.25", "\n#"), "cloud.pcd: line 13: field 'x'"),
            (text.split("0.25").next().unwrap().to_owned(), "cloud.pcd: line 10: the file ends after 1 of 2"),
            (text.replace("SIZE 4", "SIZE 5"), "cloud.pcd: line 4: field 'x'"),
        ];
        for (file, expected) in cases {
            let error = parse(file.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}\n{expected}");
        }
        let error = PcdCloud::read(Path::new("missing/cloud.pcd")).unwrap_err();
        assert!(error.to_string().starts_with("missing/cloud.pcd: "), "{error}");
    }

    #[test]
    fn fields_with_count_0_are_in_none_of_the_encodings() {
        for file in [binary_file(), compressed_file(), ascii_file()] {
            let place = file.windows(5).position(|bytes| bytes == b"DATA ").unwrap();
            let header = String::from_utf8(file[..place].to_vec()).unwrap();
            let header = header.replace(" label", " none label").replace("1 8", "1 8 8");
            let header = header.replace("U U I", "U U I I").replace("3 2", "3 0 2");
            let with_none = [header.as_bytes(), &file[place..]].concat();
            assert_ne!(with_none, file);
            assert_eq!(parse(&with_none).unwrap(), parse(&file).unwrap());
        }
    }

    #[test]
    fn binary_files_that_end_early_name_the_offset() {
        for file in [binary_file(), compressed_file()] {
            let start = parse(&file).map(|_| file.len()).unwrap();
            let error = parse(&file[..start - 1]).unwrap_err().to_string();
            assert!(error.contains(&format!("at byte {}", start - 1)), "{error}");
        }
    }

    #[test]
    fn bytes_and_lines_after_the_last_point_are_ignored() {
        for file in [binary_file(), compressed_file(), ascii_file()] {
            let longer = [file.as_slice(), b"1 2 3 4 0 0 0 0 0\n"].concat();
            assert_eq!(parse(&longer).unwrap(), parse(&file).unwrap());
        }
    }

    #[test]
    fn a_header_that_claims_gigabytes_is_refused_without_taking_them() {
        for encoding in ["ascii", "binary", "binary_compressed"] {
            let file = format!("FIELDS x\nSIZE 1\nTYPE U\nWIDTH 4000000000\nHEIGHT 1\nDATA {encoding}\n1234567890123");
            assert!(parse(file.as_bytes()).is_err());
        }
        let mut file = b"FIELDS x\nSIZE 1\nTYPE U\nWIDTH 4000000000\nHEIGHT 1\nDATA binary_compressed\n".to_vec();
        file.extend(3u32.to_le_bytes());
        file.extend(4_000_000_000u32.to_le_bytes());
        file.extend([1, 9, 9]);
        assert!(parse(&file).unwrap_err().to_string().contains("4000000000"));
    }

    proptest! {
        #[test]
        fn damaged_files_end_in_an_answer(
            which in 0usize..3,
            changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
            keep in any::<prop::sample::Index>(),
            cut in any::<bool>(),
        ) {
            let mut file = [ascii_file(), binary_file(), compressed_file()][which].clone();
            for (place, value) in changes {
                let place = place.index(file.len());
                file[place] = value;
            }
            if cut {
                file.truncate(keep.index(file.len() + 1));
            }
            if let Ok(cloud) = parse(&file) {
                let bytes = cloud.width as usize * cloud.height as usize * cloud.point_step_bytes as usize;
                prop_assert_eq!(cloud.data.len(), bytes);
            }
        }

        #[test]
        fn any_header_words_end_in_an_answer(
            words in proptest::collection::vec(
                prop_oneof!["FIELDS|SIZE|TYPE|COUNT|WIDTH|HEIGHT|POINTS|DATA ascii|DATA binary", "[0-9]{1,12}", "[FIU]", "\n", "x|_"],
                0..40,
            ),
        ) {
            let file = words.join(" ");
            if let Ok(cloud) = parse(file.as_bytes()) {
                prop_assert!(cloud.fields.len() <= words.len());
            }
        }
    }
}
