//! What makes a struct a ROS message: its type's name, its checksum and the text of its definition.
//!
//! `ros_message!` writes a struct and its serialisation from one list of fields, in the order of the ROS definition.
//! The definition's text, which a publisher sends to each subscriber and which recorders write into bags, is made from
//! the same list, so it cannot differ from what is serialised.

use crate::wire::{DecodeError, Reader, Wire};

/// A message that may be sent on a topic.
pub trait Message: Wire + Clone + Send + Sync + 'static {
    /// `package/Name`.
    const TYPE: &'static str;
    /// The checksum that ROS computes from the definition, in hexadecimal.
    const MD5SUM: &'static str;

    /// The definition with those of all messages that it is made of, in the form of a connection header.
    fn definition() -> String {
        let mut found = Vec::new();
        Self::collect_definitions(&mut found);
        let mut text = String::new();
        for (index, (name, fields)) in found.iter().enumerate() {
            if index > 0 {
                text.push_str(&"=".repeat(80));
                text.push_str("\nMSG: ");
                text.push_str(name);
                text.push('\n');
            }
            text.push_str(fields);
        }
        text
    }
}

/// A service's pair of messages.
pub trait Service {
    /// `package/Name`.
    const TYPE: &'static str;
    /// The checksum that ROS computes from the definition, in hexadecimal.
    const MD5SUM: &'static str;
    /// What the caller sends.
    type Request: Wire;
    /// What the caller gets.
    type Response: Wire;
}

/// Reads a whole message; bytes left over are an error.
pub fn decode<T: Wire>(bytes: &[u8]) -> Result<T, DecodeError> {
    let mut reader = Reader::new(bytes);
    let value = T::read(&mut reader)?;
    reader.finish()?;
    Ok(value)
}

/// The bytes of a message, without the length that TCPROS puts before them.
pub fn encode<T: Wire>(value: &T) -> Vec<u8> {
    let mut out = Vec::with_capacity(T::MIN_LEN.max(64));
    value.write(&mut out);
    out
}

/// Defines messages: `"package/Name" "md5sum" struct Name { [constants] fields }`.
macro_rules! ros_message {
    ($(
        $(#[$meta:meta])*
        $ros:literal $md5:literal struct $name:ident {
            $([$($constant:ident: $constant_type:ty = $value:expr,)*])?
            $($field:ident: $type:ty,)*
        }
    )*) => {$(
        $(#[$meta])*
        #[doc = concat!("\n\nROS message `", $ros, "`; its fields have the names, units and order of the definition.")]
        #[derive(Clone, Debug, Default, PartialEq)]
        #[allow(missing_docs, reason = "the ROS definition documents the fields")]
        #[allow(non_snake_case, reason = "fields have the names of the ROS definition")]
        pub struct $name {
            $(pub $field: $type,)*
        }

        #[allow(missing_docs, reason = "the ROS definition documents the constants")]
        impl $name {
            $($(pub const $constant: $constant_type = $value;)*)?
        }

        impl $crate::Wire for $name {
            const MIN_LEN: usize = 0 $(+ <$type as $crate::Wire>::MIN_LEN)*;

            #[allow(unused_variables, reason = "a message may have no field")]
            fn read(reader: &mut $crate::Reader<'_>) -> Result<Self, $crate::DecodeError> {
                Ok(Self { $($field: $crate::Wire::read(reader)?,)* })
            }

            #[allow(unused_variables, reason = "a message may have no field")]
            fn write(&self, out: &mut Vec<u8>) {
                $($crate::Wire::write(&self.$field, out);)*
            }

            fn ros_type() -> String {
                $ros.to_owned()
            }

            #[allow(unused_mut, reason = "a message may have no field")]
            fn collect_definitions(found: &mut Vec<(String, String)>) {
                if found.iter().any(|(name, _)| name == $ros) {
                    return;
                }
                let mut text = String::new();
                $($(
                    let constant_type = <$constant_type as $crate::Wire>::ros_type();
                    text.push_str(&format!("{constant_type} {}={}\n", stringify!($constant), Self::$constant));
                )*)?
                $(
                    let field_type = <$type as $crate::Wire>::ros_type();
                    text.push_str(&format!("{field_type} {}\n", stringify!($field).trim_end_matches('_')));
                )*
                found.push(($ros.to_owned(), text));
                $(<$type as $crate::Wire>::collect_definitions(found);)*
            }
        }

        impl $crate::Message for $name {
            const TYPE: &'static str = $ros;
            const MD5SUM: &'static str = $md5;
        }
    )*};
}

pub(crate) use ros_message;
