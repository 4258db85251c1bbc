//! `sensor_msgs/PointCloud2` as a view of the received bytes.
//!
//! A depth camera sends some ten megabytes thirty times a second, so points are not decoded one by one: the message
//! keeps the received bytes in a shared buffer. [`PointCloud2::from_bytes`] copies nothing, decoding a slice copies it
//! once, and a clone shares the buffer.

use crate::big_message::big_message;
use crate::sensor_msgs::PointField;
use crate::std_msgs::Header;
use crate::wire::{write_count, write_header, write_string, write_u32, DecodeError, WireReader};
use std::ops::Range;
use std::sync::Arc;

/// ROS message `sensor_msgs/PointCloud2`.
///
/// Decoding checks the lengths inside the message, but not that the data are as long as [`height`](Self::height),
/// [`row_step`](Self::row_step) and [`point_step`](Self::point_step) announce.
///
/// ```
/// use rcs_messages::PointCloud2;
/// use std::sync::Arc;
///
/// let mut cloud = PointCloud2::default().with_data(vec![1, 2, 3, 4]);
/// (cloud.width, cloud.height, cloud.point_step, cloud.row_step) = (1, 1, 4, 4);
/// let received = Arc::new(rcs_messages::encode(&cloud));
/// let view = PointCloud2::from_bytes(received)?;
/// assert_eq!(view.data(), [1, 2, 3, 4]);
/// # Ok::<(), rcs_messages::DecodeError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct PointCloud2 {
    /// Header.
    pub header: Header,
    /// Rows of an organised cloud; 1 for an unorganised one.
    pub height: u32,
    /// Points in a row.
    pub width: u32,
    /// Channels of a point.
    pub fields: Vec<PointField>,
    /// Claims big-endian numbers. Clouds are read as little endian all the same, as by rviz.
    pub is_bigendian: bool,
    /// Bytes from one point to the next.
    pub point_step: u32,
    /// Bytes from one row to the next.
    pub row_step: u32,
    /// `true` if no point has a NaN coordinate.
    pub is_dense: bool,
    buffer: Arc<Vec<u8>>,
    data: Range<usize>,
}

impl PointCloud2 {
    /// Reads a message without copying: the cloud keeps the bytes.
    ///
    /// # Errors
    /// [`DecodeError`].
    pub fn from_bytes(bytes: Arc<Vec<u8>>) -> Result<Self, DecodeError> {
        let mut reader = WireReader::new(&bytes);
        let mut cloud = Self::read_around_data(&mut reader)?;
        reader.finish()?;
        cloud.buffer = bytes;
        Ok(cloud)
    }

    /// Bytes of the points, row by row.
    pub fn data(&self) -> &[u8] {
        self.buffer.get(self.data.clone()).unwrap_or_default()
    }

    /// Replaces the bytes of the points.
    pub fn set_data(&mut self, data: Vec<u8>) {
        self.data = 0..data.len();
        self.buffer = data.into();
    }

    /// Replaces the bytes of the points.
    #[must_use]
    pub fn with_data(mut self, data: Vec<u8>) -> Self {
        self.set_data(data);
        self
    }

    /// Reads all but the data, whose range is noted.
    fn read_around_data(reader: &mut WireReader<'_>) -> Result<Self, DecodeError> {
        let mut cloud = Self {
            header: reader.header()?,
            height: reader.u32("height")?,
            width: reader.u32("width")?,
            fields: read_fields(reader)?,
            is_bigendian: reader.u8("is_bigendian")? != 0,
            point_step: reader.u32("point_step")?,
            row_step: reader.u32("row_step")?,
            ..Self::default()
        };
        let len = reader.count(1, "point data")?;
        let start = reader.position();
        reader.take(len, "point data")?;
        cloud.data = start..start + len;
        cloud.is_dense = reader.u8("is_dense")? != 0;
        Ok(cloud)
    }
}

impl AsRef<[u8]> for PointCloud2 {
    fn as_ref(&self) -> &[u8] {
        self.data()
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

/// Least length of a field: a name's length, offset, datatype and count.
const MIN_FIELD_LEN: usize = 13;

fn read_fields(reader: &mut WireReader<'_>) -> Result<Vec<PointField>, DecodeError> {
    let count = reader.count(MIN_FIELD_LEN, "fields")?;
    let mut fields = Vec::with_capacity(count);
    for _ in 0..count {
        fields.push(PointField {
            name: reader.string("field name")?,
            offset: reader.u32("field offset")?,
            datatype: reader.u8("field datatype")?,
            count: reader.u32("field count")?,
        });
    }
    Ok(fields)
}

impl PointCloud2 {
    fn write(&self, out: &mut Vec<u8>) {
        write_header(&self.header, out);
        write_u32(self.height, out);
        write_u32(self.width, out);
        write_count(self.fields.len(), out);
        for field in &self.fields {
            write_string(&field.name, out);
            write_u32(field.offset, out);
            out.push(field.datatype);
            write_u32(field.count, out);
        }
        out.push(u8::from(self.is_bigendian));
        write_u32(self.point_step, out);
        write_u32(self.row_step, out);
        write_count(self.data().len(), out);
        out.extend_from_slice(self.data());
        out.push(u8::from(self.is_dense));
    }

    /// Approximate length of the message, bytes.
    fn len_hint(&self) -> usize {
        self.data().len() + 256
    }
}

big_message!(PointCloud2: rosrust_msg::sensor_msgs::PointCloud2);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{decode, encode};
    use proptest::prelude::*;
    use rosrust::RosMsg;

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
    fn the_bytes_are_those_of_the_generated_type() {
        let frame = cloud().encode_vec().unwrap();
        let generated = rosrust_msg::sensor_msgs::PointCloud2::decode_slice(&frame).unwrap();
        assert_eq!(generated.data, cloud().data());
        assert_eq!(generated.fields, cloud().fields);
        assert_eq!(generated.encode_vec().unwrap(), frame);
        assert_eq!(PointCloud2::decode_slice(&frame).unwrap(), cloud());
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
        let error = PointCloud2::from_bytes(Arc::new(bytes)).unwrap_err();
        assert_eq!(error, DecodeError::TrailingBytes(1));
    }

    proptest! {
        #[test]
        fn changed_bytes_never_panic(at in 0..80usize, value: u8, cut in 0..90usize) {
            let mut bytes = encode(&cloud());
            bytes.truncate(cut);
            if let Some(byte) = bytes.get_mut(at) {
                *byte = value;
            }
            let by_slice = decode::<PointCloud2>(&bytes).ok();
            let by_buffer = PointCloud2::from_bytes(Arc::new(bytes)).ok();
            prop_assert_eq!(by_slice, by_buffer);
        }
    }
}
