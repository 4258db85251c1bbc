//! Hand-written messages, for packages that need not be installed where the programs are built.
//!
//! They are decoded from a stream of unknown length: a string or an array grows with the bytes received, never by the
//! announced count, and a message longer than [`MAX_BYTES`] is an error.

use crate::geometry_msgs::{Point, Pose, Quaternion};
use crate::std_msgs::Header;
use crate::wire::{write_count, write_string};
use rosrust::{Duration, Time};
use std::io::{self, Read};

/// Longest message; settings and loggers take a small part of this.
pub(crate) const MAX_BYTES: u64 = 4 << 20;

/// A field of a hand-written message.
pub(crate) trait WireField: Sized {
    fn put(&self, out: &mut Vec<u8>);
    fn get(from: &mut dyn Read) -> io::Result<Self>;
}

fn bytes<const N: usize>(from: &mut dyn Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}

impl WireField for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        Ok(bytes::<1>(from)? != [0])
    }
}

macro_rules! number_fields {
    ($($type:ty)*) => {
        $(impl WireField for $type {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            fn get(from: &mut dyn Read) -> io::Result<Self> {
                bytes(from).map(Self::from_le_bytes)
            }
        })*
    };
}

number_fields! { u8 i8 i32 u32 f64 }

impl WireField for String {
    fn put(&self, out: &mut Vec<u8>) {
        write_string(self, out);
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        let len = u64::from(u32::get(from)?);
        let mut text = Vec::new();
        from.take(len).read_to_end(&mut text)?;
        if text.len() as u64 != len {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(Self::from_utf8_lossy(&text).into_owned())
    }
}

impl<T: WireField + Copy + Default, const N: usize> WireField for [T; N] {
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|element| element.put(out));
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        let mut elements = [T::default(); N];
        for element in &mut elements {
            *element = T::get(from)?;
        }
        Ok(elements)
    }
}

impl<T: WireField> WireField for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        write_count(self.len(), out);
        self.iter().for_each(|element| element.put(out));
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        let mut elements = Self::new();
        for _ in 0..u32::get(from)? {
            elements.push(T::get(from)?);
        }
        Ok(elements)
    }
}

/// Types of other packages as consecutive fields.
macro_rules! field_of_fields {
    ($($type:ty { $($field:ident),* })*) => {
        $(impl WireField for $type {
            fn put(&self, out: &mut Vec<u8>) {
                $(self.$field.put(out);)*
            }

            fn get(from: &mut dyn Read) -> io::Result<Self> {
                Ok(Self { $($field: WireField::get(from)?,)* })
            }
        })*
    };
}

field_of_fields! {
    Time { sec, nsec }
    Duration { sec, nsec }
    Header { seq, stamp, frame_id }
    Point { x, y, z }
    Quaternion { x, y, z, w }
    Pose { position, orientation }
}

/// A definition followed by those of its parts, in ROS's format.
pub(crate) fn with_parts(definition: &str, parts: &[(&str, &str)]) -> String {
    let mut text = definition.to_owned();
    for (name, part) in parts {
        text += &format!("\n{}\nMSG: {name}\n{part}", "=".repeat(80));
    }
    text
}

/// Declares message structs, whose fields are serialised in this order.
macro_rules! fields_in_order {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Default, PartialEq)]
            pub struct $name {
                $($(#[$field_doc])* pub $field: $type,)*
            }

            impl $crate::fields::WireField for $name {
                fn put(&self, out: &mut Vec<u8>) {
                    $($crate::fields::WireField::put(&self.$field, out);)*
                }

                fn get(from: &mut dyn std::io::Read) -> std::io::Result<Self> {
                    Ok(Self { $($field: $crate::fields::WireField::get(from)?,)* })
                }
            }

            impl rosrust::RosMsg for $name {
                fn encode<W: std::io::Write>(&self, mut w: W) -> std::io::Result<()> {
                    let mut out = Vec::new();
                    $crate::fields::WireField::put(self, &mut out);
                    w.write_all(&out)
                }

                fn decode<R: std::io::Read>(mut r: R) -> std::io::Result<Self> {
                    $crate::fields::WireField::get(&mut std::io::Read::take(std::io::Read::by_ref(&mut r), $crate::fields::MAX_BYTES))
                }
            }
        )*
    };
}

/// Names, checksums and definitions of message types.
macro_rules! message_types {
    ($($name:ident: $ros_type:literal, $md5sum:literal, $definition:expr;)*) => {
        $(
            impl rosrust::Message for $name {
                fn msg_definition() -> String {
                    $definition.into()
                }

                fn md5sum() -> String {
                    $md5sum.to_owned()
                }

                fn msg_type() -> String {
                    $ros_type.to_owned()
                }
            }
        )*
    };
}

/// Declares service types, which are messages to rosrust, but never sent.
macro_rules! service_types {
    ($($(#[$doc:meta])* $name:ident($request:ty) -> $response:ty: $ros_type:literal, $md5sum:literal, $definition:expr;)*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Default, PartialEq)]
            pub struct $name;

            impl rosrust::ServicePair for $name {
                type Request = $request;
                type Response = $response;
            }

            impl rosrust::RosMsg for $name {
                fn encode<W: std::io::Write>(&self, _: W) -> std::io::Result<()> {
                    Ok(())
                }

                fn decode<R: std::io::Read>(_: R) -> std::io::Result<Self> {
                    Ok(Self)
                }
            }

            $crate::fields::message_types! { $name: $ros_type, $md5sum, $definition; }
        )*
    };
}

pub(crate) use {fields_in_order, message_types, service_types};
