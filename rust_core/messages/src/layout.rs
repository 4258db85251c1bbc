//! Checks of a message's lengths against its type's definition before it is decoded.
//!
//! The generated types allocate whatever length an array announces, so a damaged message would end the process. A
//! [`MessageLayout`] walks the bytes first and checks each length against the bytes left.

use crate::wire::WireReader;
use crate::DecodeError;

/// A field, or consecutive fields of fixed size.
#[derive(Clone, Debug, PartialEq, Eq)]
enum LayoutField {
    /// Bytes of fixed number.
    Fixed(usize),
    /// A count and elements of this size.
    Elements(usize),
    /// A count and elements of varying size.
    Nested(Vec<LayoutField>),
    /// A fixed number of elements of varying size.
    Repeated(usize, Vec<LayoutField>),
}

/// The fields of a message type in its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MessageLayout {
    fields: Vec<LayoutField>,
}

impl MessageLayout {
    /// Layout by the whole text of a definition: the type's fields, then the definitions of its parts, each after a
    /// line of `=` and one with its name. Missing parts end the layout.
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
        let mut reader = WireReader::new(bytes);
        walk(&self.fields, &mut reader)?;
        reader.finish()
    }
}

fn walk(fields: &[LayoutField], reader: &mut WireReader<'_>) -> Result<(), DecodeError> {
    for field in fields {
        match field {
            LayoutField::Fixed(size) => {
                reader.take(*size, "fields")?;
            }
            LayoutField::Elements(size) => {
                let count = reader.count(*size, "array elements")?;
                reader.take(count * size, "array elements")?;
            }
            LayoutField::Nested(nested) => {
                let count = reader.count(least_size(nested), "array elements")?;
                for _ in 0..count {
                    walk(nested, reader)?;
                }
            }
            LayoutField::Repeated(count, nested) => {
                for _ in 0..*count {
                    walk(nested, reader)?;
                }
            }
        }
    }
    Ok(())
}

fn least_size(fields: &[LayoutField]) -> usize {
    let least = |field: &LayoutField| match field {
        LayoutField::Fixed(size) => *size,
        LayoutField::Elements(_) | LayoutField::Nested(_) => 4,
        LayoutField::Repeated(count, nested) => count * least_size(nested),
    };
    fields.iter().map(least).sum()
}

/// Deepest nesting, which ends a definition that contains itself.
const MAX_LEVELS: usize = 16;

fn read_fields(text: &str, others: &[(&str, &str)], level: usize, fields: &mut Vec<LayoutField>) {
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default();
        let Some((kind, name)) = line.trim().split_once(char::is_whitespace) else { continue };
        if name.contains('=') {
            continue; // a constant
        }
        let (element, count) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
            Some((element, "")) => (element, ElementCount::Any),
            Some((element, count)) => (element, ElementCount::Exactly(count.parse().unwrap_or(0))),
            None => (kind, ElementCount::Exactly(1)),
        };
        let mut inner = Vec::new();
        if let Some(size) = builtin_size(element) {
            inner.push(LayoutField::Fixed(size));
        } else if element == "string" {
            inner.push(LayoutField::Elements(1));
        } else if level < MAX_LEVELS {
            let is_named = |name: &str| name == element || name.rsplit_once('/').is_some_and(|(_, own)| own == element);
            if let Some((_, text)) = others.iter().find(|(name, _)| is_named(name)) {
                read_fields(text, others, level + 1, &mut inner);
            }
        }
        match (count, inner.as_slice()) {
            (ElementCount::Exactly(count), [LayoutField::Fixed(size)]) => push_fixed(fields, count * size),
            (ElementCount::Exactly(1), _) => {
                for field in inner {
                    match field {
                        LayoutField::Fixed(size) => push_fixed(fields, size),
                        other => fields.push(other),
                    }
                }
            }
            (ElementCount::Exactly(count), _) => fields.push(LayoutField::Repeated(count, inner)),
            (ElementCount::Any, [LayoutField::Fixed(size)]) => fields.push(LayoutField::Elements(*size)),
            (ElementCount::Any, _) => fields.push(LayoutField::Nested(inner)),
        }
    }
}

enum ElementCount {
    Exactly(usize),
    Any,
}

fn push_fixed(fields: &mut Vec<LayoutField>, size: usize) {
    match fields.last_mut() {
        Some(LayoutField::Fixed(before)) => *before += size,
        _ => fields.push(LayoutField::Fixed(size)),
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
        let layout = MessageLayout::of(
            "uint8 A=1\nHeader header # seq, stamp, frame\nfloat64[3] v\ntime t\nPoint[] points\n\
            ====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n\
            ====\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n",
        );
        assert_eq!(
            layout.fields,
            [LayoutField::Fixed(12), LayoutField::Elements(1), LayoutField::Fixed(32), LayoutField::Elements(24)]
        );
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
        let layout = MessageLayout::of(&PointCloud::msg_definition());
        assert_eq!(layout.check(&bytes), Ok(()));
        for len in 0..bytes.len() {
            assert!(layout.check(&bytes[..len]).is_err(), "{len} bytes");
        }
        bytes.push(0);
        assert_eq!(layout.check(&bytes), Err(DecodeError::TrailingBytes(1)));
    }
}
