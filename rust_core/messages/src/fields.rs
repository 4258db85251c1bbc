//! Messages by their fields: hand-written ones, for packages that need not be installed where the programs are built,
//! and generated ones with arrays of numbers.
//!
//! The decoding of the generated types allocates whatever length an array of numbers announces, so a damaged message
//! would end the process; the types with such arrays are listed here and decoded by [`WireReader`]. Other arrays grow
//! with the bytes.

use crate::geometry_msgs::{Point, Point32, Pose, Quaternion};
use crate::map_msgs::OccupancyGridUpdate;
use crate::sensor_msgs::{
    CameraInfo, ChannelFloat32, CompressedImage, JointState, LaserScan, PointCloud, RegionOfInterest,
};
use crate::std_msgs::Header;
use crate::wire::{write_count, write_string, DecodeError, WireReader};
use rosrust::{Duration, Time};
use std::io::{self, Read};

/// Longest hand-written message; settings and loggers take a small part of this.
const MAX_BYTES: u64 = 4 << 20;

/// A field of a message.
pub(crate) trait WireField: Sized {
    fn put(&self, out: &mut Vec<u8>);
    fn get(from: &mut WireReader<'_>) -> Result<Self, DecodeError>;

    /// Elements of an array, whose count is not checked for their length.
    fn get_all(count: usize, from: &mut WireReader<'_>) -> Result<Vec<Self>, DecodeError> {
        (0..count).map(|_| Self::get(from)).collect()
    }
}

/// Decodes a whole message by its fields.
pub(crate) fn decode<T: WireField>(bytes: &[u8]) -> Result<T, DecodeError> {
    let mut reader = WireReader::new(bytes);
    let message = T::get(&mut reader)?;
    reader.finish()?;
    Ok(message)
}

/// Decodes a whole message from a stream.
pub(crate) fn decode_from<T: WireField>(from: impl Read) -> io::Result<T> {
    let mut bytes = Vec::new();
    from.take(MAX_BYTES).read_to_end(&mut bytes)?;
    Ok(decode(&bytes)?)
}

impl WireField for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn get(from: &mut WireReader<'_>) -> Result<Self, DecodeError> {
        Ok(from.u8("bool")? != 0)
    }
}

macro_rules! number_fields {
    ($($type:ty)*) => {
        $(impl WireField for $type {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            fn get(from: &mut WireReader<'_>) -> Result<Self, DecodeError> {
                from.array(stringify!($type)).map(Self::from_le_bytes)
            }

            fn get_all(count: usize, from: &mut WireReader<'_>) -> Result<Vec<Self>, DecodeError> {
                let bytes = from.take(count.saturating_mul(size_of::<Self>()), "array elements")?;
                Ok(bytes.as_chunks().0.iter().copied().map(Self::from_le_bytes).collect())
            }
        })*
    };
}

number_fields! { u8 i8 i32 u32 f32 f64 }

impl WireField for String {
    fn put(&self, out: &mut Vec<u8>) {
        write_string(self, out);
    }

    fn get(from: &mut WireReader<'_>) -> Result<Self, DecodeError> {
        from.string("string")
    }
}

impl<T: WireField + Copy + Default, const N: usize> WireField for [T; N] {
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|element| element.put(out));
    }

    fn get(from: &mut WireReader<'_>) -> Result<Self, DecodeError> {
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

    fn get(from: &mut WireReader<'_>) -> Result<Self, DecodeError> {
        let count = from.count(1, "array elements")?;
        T::get_all(count, from)
    }
}

/// Types of other packages as consecutive fields.
macro_rules! field_of_fields {
    ($($type:ty { $($field:ident),* })*) => {
        $(impl WireField for $type {
            fn put(&self, out: &mut Vec<u8>) {
                $(self.$field.put(out);)*
            }

            fn get(from: &mut WireReader<'_>) -> Result<Self, DecodeError> {
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
    Point32 { x, y, z }
    RegionOfInterest { x_offset, y_offset, height, width, do_rectify }
    CameraInfo { header, height, width, distortion_model, D, K, R, P, binning_x, binning_y, roi }
    ChannelFloat32 { name, values }
    CompressedImage { header, format, data }
    JointState { header, name, position, velocity, effort }
    LaserScan {
        header, angle_min, angle_max, angle_increment, time_increment, scan_time, range_min, range_max, ranges,
        intensities
    }
    OccupancyGridUpdate { header, x, y, width, height, data }
    PointCloud { header, points, channels }
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

                fn get(from: &mut $crate::wire::WireReader<'_>) -> Result<Self, $crate::DecodeError> {
                    Ok(Self { $($field: $crate::fields::WireField::get(from)?,)* })
                }
            }

            impl rosrust::RosMsg for $name {
                fn encode<W: std::io::Write>(&self, mut w: W) -> std::io::Result<()> {
                    let mut out = Vec::new();
                    $crate::fields::WireField::put(self, &mut out);
                    w.write_all(&out)
                }

                fn decode<R: std::io::Read>(r: R) -> std::io::Result<Self> {
                    $crate::fields::decode_from(r)
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
