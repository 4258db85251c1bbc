//! Points as text.

use std::str::FromStr;

use super::{BodyReader, PcdType};
use crate::FileError;

impl BodyReader<'_> {
    /// Parses a line for each point and a word for each element. Lines with another number of words are skipped.
    /// Returns the points and the number of skipped lines, empty ones not counted.
    pub(super) fn ascii(&self, body: &[u8]) -> Result<(Vec<u8>, u32), FileError> {
        let points = self.header.points();
        let wanted: usize = self.header.fields.iter().map(|field| field.count).sum();
        let mut data = Vec::with_capacity(self.header.total_bytes().min(body.len().saturating_mul(8)));
        let mut found = 0usize;
        let mut last_line = self.header.data_line;
        let (mut skipped, mut first_skipped) = (0, None);
        let line_error = |line, reason: String| FileError::new(self.path, format_args!("line {line}: {reason}"));
        for (index, text) in body.split(|byte| *byte == b'\n').enumerate() {
            let line = self.header.data_line + index;
            if text.trim_ascii().is_empty() {
                continue;
            }
            if found == points {
                log::warn!("{}: line {line}: more points than the header's {points}; ignored", self.path.display());
                break;
            }
            let text = std::str::from_utf8(text).map_err(|_| line_error(line, "not text".to_owned()))?;
            let values = text.split_ascii_whitespace().count();
            if values == wanted {
                self.ascii_point(text, &mut data).map_err(|reason| line_error(line, reason))?;
            } else {
                self.skip_point(&mut data);
                first_skipped.get_or_insert((line, values));
                skipped += 1;
            }
            found += 1;
            last_line = line;
        }
        if found < points {
            return Err(line_error(last_line, format!("the file ends after {found} of {points} points")));
        }
        if let Some((line, values)) = first_skipped {
            let reason = format!("{values} values for the {wanted} of the header's fields");
            if skipped as usize == points {
                return Err(line_error(line, format!("{reason}, and no line has as many")));
            }
            log::warn!("{}: {skipped} of {points} points skipped: line {line}: {reason}", self.path.display());
        }
        Ok((data, skipped))
    }

    /// Appends the point of a line with the right number of values.
    fn ascii_point(&self, text: &str, data: &mut Vec<u8>) -> Result<(), String> {
        let fields = self.header.fields.iter().flat_map(|field| std::iter::repeat_n(field, field.count));
        for (field, word) in fields.zip(text.split_ascii_whitespace()) {
            push_value(field.kind, word, data).ok_or_else(|| {
                let word: String = word.chars().take(40).collect();
                format!("field '{}': '{word}' is no value of type {:?}", field.name, field.kind)
            })?;
        }
        Ok(())
    }

    /// Appends an invalid point, which keeps the place in an organised cloud.
    fn skip_point(&self, data: &mut Vec<u8>) {
        if self.header.height == 1 {
            return;
        }
        for field in &self.header.fields {
            for _ in 0..field.count {
                match field.kind {
                    PcdType::F32 => data.extend(f32::NAN.to_le_bytes()),
                    PcdType::F64 => data.extend(f64::NAN.to_le_bytes()),
                    kind => data.resize(data.len() + kind.size_bytes(), 0),
                }
            }
        }
    }
}

/// Appends the bytes of a value. An integer's decimals are dropped, as in PCL.
fn push_value(kind: PcdType, word: &str, data: &mut Vec<u8>) -> Option<()> {
    fn float<T: FromStr, const N: usize>(word: &str, bytes: fn(T) -> [u8; N], data: &mut Vec<u8>) -> Option<()> {
        data.extend_from_slice(&bytes(word.parse().ok()?));
        Some(())
    }
    fn integer<T: FromStr + TryFrom<i128>, const N: usize>(
        word: &str,
        bytes: fn(T) -> [u8; N],
        data: &mut Vec<u8>,
    ) -> Option<()> {
        let whole = || {
            let number = word.parse::<f64>().ok().filter(|number| number.is_finite() && number.abs() < 1e20)?;
            T::try_from(number as i128).ok()
        };
        data.extend_from_slice(&bytes(word.parse().ok().or_else(whole)?));
        Some(())
    }
    match kind {
        PcdType::I8 => integer(word, i8::to_le_bytes, data),
        PcdType::U8 => integer(word, u8::to_le_bytes, data),
        PcdType::I16 => integer(word, i16::to_le_bytes, data),
        PcdType::U16 => integer(word, u16::to_le_bytes, data),
        PcdType::I32 => integer(word, i32::to_le_bytes, data),
        PcdType::U32 => integer(word, u32::to_le_bytes, data),
        PcdType::I64 => integer(word, i64::to_le_bytes, data),
        PcdType::U64 => integer(word, u64::to_le_bytes, data),
        PcdType::F32 => float(word, f32::to_le_bytes, data),
        PcdType::F64 => float(word, f64::to_le_bytes, data),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::PcdCloud;
    use crate::FileError;

    fn parse(bytes: &[u8]) -> Result<PcdCloud, FileError> {
        PcdCloud::parse(Path::new("cloud.pcd"), bytes)
    }

    #[test]
    fn integers_may_be_written_with_a_point() {
        let file = "FIELDS x ring\nSIZE 4 2\nTYPE F U\nWIDTH 2\nDATA ascii\n1 12.0\n2 1.3e1\n";
        let cloud = parse(file.as_bytes()).unwrap();
        let rings: Vec<u8> = cloud.data.chunks_exact(6).map(|point| point[4]).collect();
        assert_eq!(rings, [12, 13]);
    }

    #[test]
    fn rows_with_too_few_or_too_many_numbers_are_skipped() {
        let file = "FIELDS x\nSIZE 2\nTYPE I\nWIDTH 4\nHEIGHT 1\nDATA ascii\n1\n2 2\n3\n4\n";
        let cloud = parse(file.as_bytes()).unwrap();
        assert_eq!((cloud.width, cloud.data), (3, vec![1, 0, 3, 0, 4, 0]));
        let file = "FIELDS x y\nWIDTH 3\nHEIGHT 1\nDATA ascii\n1 2\n3\n5 6\n";
        let cloud = parse(file.as_bytes()).unwrap();
        assert_eq!((cloud.width, cloud.is_dense), (2, true));
        assert_eq!(cloud.data, [1.0_f32, 2.0, 5.0, 6.0].map(f32::to_le_bytes).concat());
    }

    #[test]
    fn a_row_that_is_skipped_keeps_its_place_in_an_organised_cloud() {
        let file = "FIELDS x ring\nSIZE 4 1\nTYPE F U\nWIDTH 2\nHEIGHT 2\nDATA ascii\n1 1\n2\n3 3\n4 4\n";
        let cloud = parse(file.as_bytes()).unwrap();
        assert_eq!((cloud.width, cloud.height, cloud.is_dense, cloud.data.len()), (2, 2, false, 20));
        let x = |point: usize| f32::from_le_bytes(cloud.data[5 * point..][..4].try_into().unwrap());
        assert!(x(1).is_nan());
        assert_eq!([x(0), x(2), x(3)], [1.0, 3.0, 4.0]);
    }
}
