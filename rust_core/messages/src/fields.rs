//! Messages written by hand, for packages that need not be installed where the programs are built: structs whose fields
//! are serialised one after the other.
//!
//! Such a message is read from the connection itself, whose end is unknown: a string or an array grows with the bytes
//! received, never by the count that announces them, and a message longer than [`MAX_BYTES`] is an error.

use crate::geometry_msgs::{Point, Pose, Quaternion};
use crate::std_msgs::Header;
use crate::wire::{write_count, write_string, write_u32};
use rosrust::{Duration, Time};
use std::io::{self, Read};

/// No node has settings or loggers that take more than a small part of this.
pub(crate) const MAX_BYTES: u64 = 4 << 20;

/// A value that can be a field of these messages.
pub(crate) trait Field: Sized {
    fn put(&self, out: &mut Vec<u8>);
    fn get(from: &mut dyn Read) -> io::Result<Self>;
}

fn bytes<const N: usize>(from: &mut dyn Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}

impl Field for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        Ok(bytes::<1>(from)? != [0])
    }
}

impl Field for u8 {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(*self);
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        bytes::<1>(from).map(Self::from_le_bytes)
    }
}

impl Field for i8 {
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        bytes(from).map(Self::from_le_bytes)
    }
}

impl Field for i32 {
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        bytes(from).map(Self::from_le_bytes)
    }
}

impl Field for u32 {
    fn put(&self, out: &mut Vec<u8>) {
        write_u32(*self, out);
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        bytes(from).map(Self::from_le_bytes)
    }
}

impl Field for f64 {
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }

    fn get(from: &mut dyn Read) -> io::Result<Self> {
        bytes(from).map(Self::from_le_bytes)
    }
}

impl Field for String {
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

impl<T: Field + Copy + Default, const N: usize> Field for [T; N] {
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

impl<T: Field> Field for Vec<T> {
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

/// Fields of types of other packages, one after the other.
macro_rules! field_of_fields {
    ($($type:ty { $($field:ident),* })*) => {
        $(impl Field for $type {
            fn put(&self, out: &mut Vec<u8>) {
                $(self.$field.put(out);)*
            }

            fn get(from: &mut dyn Read) -> io::Result<Self> {
                Ok(Self { $($field: Field::get(from)?,)* })
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

/// A definition followed by those that it is made of, each with its full name, as ROS writes them one after another.
pub(crate) fn with_parts(definition: &str, parts: &[(&str, &str)]) -> String {
    let mut text = definition.to_owned();
    for (name, part) in parts {
        text += &format!("\n{}\nMSG: {name}\n{part}", "=".repeat(80));
    }
    text
}

/// Structs whose fields are serialised in the order in which they are declared here.
macro_rules! fields_in_order {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Default, PartialEq)]
            pub struct $name {
                $($(#[$field_doc])* pub $field: $type,)*
            }

            impl $crate::fields::Field for $name {
                fn put(&self, out: &mut Vec<u8>) {
                    $($crate::fields::Field::put(&self.$field, out);)*
                }

                fn get(from: &mut dyn std::io::Read) -> std::io::Result<Self> {
                    Ok(Self { $($field: $crate::fields::Field::get(from)?,)* })
                }
            }

            impl rosrust::RosMsg for $name {
                fn encode<W: std::io::Write>(&self, mut w: W) -> std::io::Result<()> {
                    let mut out = Vec::new();
                    $crate::fields::Field::put(self, &mut out);
                    w.write_all(&out)
                }

                fn decode<R: std::io::Read>(mut r: R) -> std::io::Result<Self> {
                    $crate::fields::Field::get(&mut std::io::Read::take(std::io::Read::by_ref(&mut r), $crate::fields::MAX_BYTES))
                }
            }
        )*
    };
}

pub(crate) use fields_in_order;
