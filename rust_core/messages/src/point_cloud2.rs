//! `sensor_msgs/PointCloud2` as a view of the received bytes.
//!
//! A cloud of a depth camera is some ten megabytes thirty times a second, so its points are never decoded one by one:
//! the message keeps the bytes that came from the wire in one shared buffer and remembers where in them the points lie.
//! [`PointCloud2::from_bytes`] copies nothing, reading it from a slice copies that slice's points once, and a clone
//! shares the buffer.

use crate::sensor_msgs::PointField;
use crate::std_msgs::Header;
use crate::wire::{write_count, DecodeError, Reader, Wire};
use crate::Message;
use std::ops::Range;
use std::sync::Arc;

/// ROS message `sensor_msgs/PointCloud2`.
///
/// Lengths inside the message are checked (a field or the data reaching past the end is an error); whether the data is
/// as long as [`height`](Self::height), [`row_step`](Self::row_step) and [`point_step`](Self::point_step) claim is not,
/// see [`PointCloud2::claimed_len`].
#[derive(Clone, Debug, Default)]
pub struct PointCloud2 {
    /// Sequence number, stamp and frame.
    pub header: Header,
    /// Rows of an organised cloud; 1 for an unorganised one.
    pub height: u32,
    /// Points in a row.
    pub width: u32,
    /// The channels of a point.
    pub fields: Vec<PointField>,
    /// Whether the numbers are big endian.
    pub is_bigendian: bool,
    /// Bytes from one point to the next.
    pub point_step: u32,
    /// Bytes from one row to the next.
    pub row_step: u32,
    /// Whether no point has a NaN coordinate.
    pub is_dense: bool,
    buffer: Arc<Vec<u8>>,
    data: Range<usize>,
}

impl PointCloud2 {
    /// Reads a message whose bytes become the cloud's own; nothing is copied.
    pub fn from_bytes(bytes: Arc<Vec<u8>>) -> Result<Self, DecodeError> {
        let mut reader = Reader::new(&bytes);
        let mut cloud = Self::read_around_data(&mut reader)?;
        reader.finish()?;
        cloud.buffer = bytes;
        Ok(cloud)
    }

    /// The bytes of the points, row by row.
    pub fn data(&self) -> &[u8] {
        self.buffer.get(self.data.clone()).unwrap_or_default()
    }

    /// Puts `data` in the place of the points' bytes.
    pub fn set_data(&mut self, data: Vec<u8>) {
        self.data = 0..data.len();
        self.buffer = Arc::new(data);
    }

    /// The same cloud with these bytes as its points.
    #[must_use]
    pub fn with_data(mut self, data: Vec<u8>) -> Self {
        self.set_data(data);
        self
    }

    /// How many bytes of data the header speaks of: `row_step * height`.
    pub fn claimed_len(&self) -> u64 {
        u64::from(self.row_step) * u64::from(self.height)
    }

    /// Reads all but the data, and leaves its place in `data`.
    fn read_around_data(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let mut cloud = Self {
            header: Header::read(reader)?,
            height: u32::read(reader)?,
            width: u32::read(reader)?,
            fields: Vec::read(reader)?,
            is_bigendian: bool::read(reader)?,
            point_step: u32::read(reader)?,
            row_step: u32::read(reader)?,
            ..Self::default()
        };
        let len = reader.count(1, "point data")?;
        let start = reader.position();
        reader.take(len, "point data")?;
        cloud.data = start..start + len;
        cloud.is_dense = bool::read(reader)?;
        Ok(cloud)
    }
}

impl PartialEq for PointCloud2 {
    fn eq(&self, other: &Self) -> bool {
        self.header == other.header
            && (self.height, self.width) == (other.height, other.width)
            && self.fields == other.fields
            && (self.is_bigendian, self.is_dense) == (other.is_bigendian, other.is_dense)
            && (self.point_step, self.row_step) == (other.point_step, other.row_step)
            && self.data() == other.data()
    }
}

impl Wire for PointCloud2 {
    const MIN_LEN: usize = Header::MIN_LEN + 4 + 4 + 4 + 1 + 4 + 4 + 4 + 1;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let mut points = reader.clone();
        let mut cloud = Self::read_around_data(reader)?;
        points.take(cloud.data.start - points.position(), "point data")?;
        cloud.set_data(points.take(cloud.data.len(), "point data")?.to_vec());
        Ok(cloud)
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.reserve(self.data().len() + 256);
        self.header.write(out);
        self.height.write(out);
        self.width.write(out);
        self.fields.write(out);
        self.is_bigendian.write(out);
        self.point_step.write(out);
        self.row_step.write(out);
        write_count(self.data().len(), out);
        out.extend_from_slice(self.data());
        self.is_dense.write(out);
    }

    fn ros_type() -> String {
        Self::TYPE.to_owned()
    }

    fn collect_definitions(found: &mut Vec<(String, String)>) {
        let text = "Header header\nuint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\n\
                    uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n";
        found.push((Self::TYPE.to_owned(), text.to_owned()));
        Header::collect_definitions(found);
        PointField::collect_definitions(found);
    }
}

impl Message for PointCloud2 {
    const TYPE: &'static str = "sensor_msgs/PointCloud2";
    const MD5SUM: &'static str = "1158d486dd51d683ce2f1be655c3c181";
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{decode, encode};
    use proptest::prelude::*;

    fn cloud() -> PointCloud2 {
        PointCloud2 {
            header: Header { seq: 7, frame_id: "map".to_owned(), ..Header::default() },
            height: 1,
            width: 2,
            fields: vec![PointField { name: "x".to_owned(), offset: 0, datatype: PointField::FLOAT32, count: 1 }],
            point_step: 4,
            row_step: 8,
            is_dense: true,
            ..PointCloud2::default()
        }
        .with_data(vec![0, 0, 128, 63, 0, 0, 0, 64])
    }

    #[test]
    fn a_cloud_survives_the_wire_both_ways_of_reading() {
        let bytes = encode(&cloud());
        assert_eq!(decode::<PointCloud2>(&bytes).unwrap(), cloud());
        let shared = Arc::new(bytes);
        let view = PointCloud2::from_bytes(Arc::clone(&shared)).unwrap();
        assert_eq!(view, cloud());
        assert_eq!(Arc::strong_count(&shared), 2, "the view shares the bytes");
    }

    #[test]
    fn every_truncation_is_an_error() {
        let bytes = encode(&cloud());
        for len in 0..bytes.len() {
            assert!(decode::<PointCloud2>(&bytes[..len]).is_err(), "{len} bytes");
            assert!(PointCloud2::from_bytes(Arc::new(bytes[..len].to_vec())).is_err(), "{len} bytes");
        }
    }

    #[test]
    fn bytes_after_the_message_are_an_error() {
        let mut bytes = encode(&cloud());
        bytes.push(0);
        assert_eq!(decode::<PointCloud2>(&bytes), Err(DecodeError::TrailingBytes(1)));
    }

    proptest! {
        #[test]
        fn changed_bytes_never_panic(at in 0..80usize, value: u8, cut in 0..90usize) {
            let mut bytes = encode(&cloud());
            bytes.truncate(cut);
            if let Some(byte) = bytes.get_mut(at) {
                *byte = value;
            }
            let by_slice = decode::<PointCloud2>(&bytes);
            let by_buffer = PointCloud2::from_bytes(Arc::new(bytes));
            prop_assert_eq!(by_slice, by_buffer);
        }
    }
}
