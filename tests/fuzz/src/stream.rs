//! Several messages in one input: what a display's topics deliver one after the other.
//!
//! Each has three bytes before it: which topic it is on, and its length (little-endian). A length that reaches past the
//! end means all that is left, so that any bytes are a stream.

/// Bytes that a topic delivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record<'a> {
    /// Which of the topics.
    pub topic: u8,
    /// The message.
    pub bytes: &'a [u8],
}

impl<'a> Record<'a> {
    /// The records of an input.
    pub fn read_all(data: &'a [u8]) -> impl Iterator<Item = Self> {
        let mut rest = data;
        std::iter::from_fn(move || {
            let ([topic, low, high], behind) = rest.split_first_chunk::<3>()?;
            let len = usize::from(u16::from_le_bytes([*low, *high])).min(behind.len());
            let (bytes, next) = behind.split_at(len);
            rest = next;
            Some(Self { topic: *topic, bytes })
        })
    }

    /// Appends the record to an input; what is longer than 65535 bytes can only be the last.
    pub fn write(&self, data: &mut Vec<u8>) {
        let len = u16::try_from(self.bytes.len()).unwrap_or(u16::MAX);
        data.push(self.topic);
        data.extend_from_slice(&len.to_le_bytes());
        data.extend_from_slice(self.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_read_as_they_were_written_and_a_length_past_the_end_means_the_rest() {
        let records =
            [Record { topic: 3, bytes: b"abc" }, Record { topic: 0, bytes: b"" }, Record { topic: 9, bytes: b"z" }];
        let mut data = Vec::new();
        records.iter().for_each(|record| record.write(&mut data));
        assert!(Record::read_all(&data).eq(records));
        data[1] = 200;
        assert_eq!(Record::read_all(&data).collect::<Vec<_>>(), [Record { topic: 3, bytes: &data[3..] }]);
    }
}
