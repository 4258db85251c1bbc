//! Checks whether bytes can be a message of a type, from the type's definition and before anything is allocated.
//!
//! The generated types allocate whatever length an array announces; a damaged message would end the process.
//! A [`Layout`] walks the bytes first: it skips what has a fixed size and checks each length against the bytes left.

use crate::wire::Reader;
use crate::DecodeError;

/// One field of a message, or several of fixed size one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Field {
    /// So many bytes.
    Fixed(usize),
    /// A length and so many bytes, each element of which has the size.
    Elements(usize),
    /// A length and so many elements of different sizes.
    Nested(Vec<Field>),
    /// A fixed number of elements of different sizes.
    Repeated(usize, Vec<Field>),
}

/// How the fields of a message type lie in its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    fields: Vec<Field>,
}

impl Layout {
    /// From the whole text of a definition: the type's own fields, and those of the types that it is made of, each
    /// after a line of `=` and one with its name. Types that the text lacks make the layout end before them.
    pub(crate) fn of(definition: &str) -> Self {
        let mut sections = definition.split("\n====");
        let own = sections.next().unwrap_or_default();
        let others: Vec<(&str, &str)> = sections
            .filter_map(|section| section.split_once("MSG: ")?.1.split_once('\n'))
            .map(|(name, text)| (name.trim(), text))
            .collect();
        let mut fields = Vec::new();
        read_fields(own, &others, 0, &mut fields);
        Self { fields }
    }

    /// Checks the bytes of one message.
    ///
    /// # Errors
    /// [`DecodeError`] if a length or a field reaches past the end, or bytes are left over.
    pub(crate) fn check(&self, bytes: &[u8]) -> Result<(), DecodeError> {
        let mut reader = Reader::new(bytes);
        walk(&self.fields, &mut reader)?;
        reader.finish()
    }
}

fn walk(fields: &[Field], reader: &mut Reader<'_>) -> Result<(), DecodeError> {
    for field in fields {
        match field {
            Field::Fixed(size) => {
                reader.take(*size, "fields")?;
            }
            Field::Elements(size) => {
                let count = reader.count(*size, "array elements")?;
                reader.take(count * size, "array elements")?;
            }
            Field::Nested(nested) => {
                let count = reader.count(least_size(nested), "array elements")?;
                for _ in 0..count {
                    walk(nested, reader)?;
                }
            }
            Field::Repeated(count, nested) => {
                for _ in 0..*count {
                    walk(nested, reader)?;
                }
            }
        }
    }
    Ok(())
}

fn least_size(fields: &[Field]) -> usize {
    let least = |field: &Field| match field {
        Field::Fixed(size) => *size,
        Field::Elements(_) | Field::Nested(_) => 4,
        Field::Repeated(count, nested) => count * least_size(nested),
    };
    fields.iter().map(least).sum()
}

/// No definition nests deeper; one that contains itself ends here.
const MOST_LEVELS: usize = 16;

fn read_fields(text: &str, others: &[(&str, &str)], level: usize, fields: &mut Vec<Field>) {
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default();
        let Some((kind, name)) = line.trim().split_once(char::is_whitespace) else { continue };
        if name.contains('=') {
            continue; // a constant
        }
        let (element, count) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
            Some((element, "")) => (element, Count::Any),
            Some((element, count)) => (element, Count::Exactly(count.parse().unwrap_or(0))),
            None => (kind, Count::Exactly(1)),
        };
        let mut inner = Vec::new();
        if let Some(size) = builtin_size(element) {
            inner.push(Field::Fixed(size));
        } else if element == "string" {
            inner.push(Field::Elements(1));
        } else if level < MOST_LEVELS {
            let is_named = |name: &str| name == element || name.rsplit_once('/').is_some_and(|(_, own)| own == element);
            if let Some((_, text)) = others.iter().find(|(name, _)| is_named(name)) {
                read_fields(text, others, level + 1, &mut inner);
            }
        }
        match (count, inner.as_slice()) {
            (Count::Exactly(count), [Field::Fixed(size)]) => push_fixed(fields, count * size),
            (Count::Exactly(1), _) => {
                for field in inner {
                    match field {
                        Field::Fixed(size) => push_fixed(fields, size),
                        other => fields.push(other),
                    }
                }
            }
            (Count::Exactly(count), _) => fields.push(Field::Repeated(count, inner)),
            (Count::Any, [Field::Fixed(size)]) => fields.push(Field::Elements(*size)),
            (Count::Any, _) => fields.push(Field::Nested(inner)),
        }
    }
}

enum Count {
    Exactly(usize),
    Any,
}

fn push_fixed(fields: &mut Vec<Field>, size: usize) {
    match fields.last_mut() {
        Some(Field::Fixed(before)) => *before += size,
        _ => fields.push(Field::Fixed(size)),
    }
}

fn builtin_size(kind: &str) -> Option<usize> {
    Some(match kind {
        "bool" | "int8" | "uint8" | "byte" | "char" => 1,
        "int16" | "uint16" => 2,
        "int32" | "uint32" | "float32" => 4,
        "int64" | "uint64" | "float64" | "time" | "duration" => 8,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rosrust::Message;

    #[test]
    fn fixed_fields_are_one_and_constants_none() {
        let layout = Layout::of(
            "uint8 A=1\nHeader header # seq, stamp, frame\nfloat64[3] v\ntime t\nPoint[] points\n\
            ====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n\
            ====\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n",
        );
        assert_eq!(layout.fields, [Field::Fixed(12), Field::Elements(1), Field::Fixed(32), Field::Elements(24)]);
    }

    #[test]
    fn a_message_passes_and_each_shorter_or_longer_one_does_not() {
        use crate::sensor_msgs::{ChannelFloat32, PointCloud};
        let channel = ChannelFloat32 { name: "intensity".to_owned(), values: vec![1.0, 2.0] };
        let cloud = PointCloud {
            points: vec![Default::default(); 2],
            channels: vec![channel.clone(), channel],
            ..PointCloud::default()
        };
        let mut bytes = crate::encode(&cloud);
        let layout = Layout::of(&PointCloud::msg_definition());
        assert_eq!(layout.check(&bytes), Ok(()));
        for len in 0..bytes.len() {
            assert!(layout.check(&bytes[..len]).is_err(), "{len} bytes");
        }
        bytes.push(0);
        assert_eq!(layout.check(&bytes), Err(DecodeError::TrailingBytes(1)));
    }
}
