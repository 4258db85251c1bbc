//! `sensor_msgs/Image` as a view of received bytes or of shared pixels.
//!
//! A received image keeps its bytes, as [`crate::PointCloud2`] does. An image to be sent shares its pixels with the
//! renderer ([`Image::sharing`]) and with the connections that send it ([`Image::parts`]).

use crate::big_message::big_message;
use crate::bytes::{Bytes, SharedBytes};
use crate::std_msgs::Header;
use crate::wire::{write_count, write_header, write_string, write_u32, DecodeError, WireReader};
use std::ops::Range;
use std::sync::Arc;

/// ROS message `sensor_msgs/Image`.
///
/// ```
/// use rcs_messages::{std_msgs::Header, Image};
/// use std::sync::Arc;
///
/// let pixels = Arc::new(vec![255, 0, 0, 0, 0, 255]);
/// let image = Image::new(Header::default(), [2, 1], "rgb8", 6, Arc::clone(&pixels));
/// let received = Image::from_bytes(Arc::new(rcs_messages::encode(&image)))?;
/// assert_eq!((received.width, received.data()), (2, pixels.as_slice()));
/// # Ok::<(), rcs_messages::DecodeError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Header.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Pixels in a row.
    pub width: u32,
    /// Pixel encoding, such as `rgb8`.
    pub encoding: String,
    /// Not 0 if numbers of more than one byte are big endian.
    pub is_bigendian: u8,
    /// Bytes from one row to the next.
    pub step: u32,
    buffer: Bytes,
    data: Range<usize>,
}

impl Image {
    /// A little-endian image of width × height pixels with rows `step_bytes` apart, which shares the pixels.
    pub fn new(header: Header, size_px: [u32; 2], encoding: &str, step_bytes: u32, pixels: Arc<Vec<u8>>) -> Self {
        let [width, height] = size_px;
        Self {
            header,
            height,
            width,
            encoding: encoding.to_owned(),
            is_bigendian: 0,
            step: step_bytes,
            ..Self::default()
        }
        .with_data(pixels)
    }

    /// An image as by [`new`](Self::new) with pixels that belong to `owner`.
    pub fn sharing(header: Header, size_px: [u32; 2], encoding: &str, step_bytes: u32, owner: SharedBytes) -> Self {
        let mut image = Self::new(header, size_px, encoding, step_bytes, Arc::default());
        image.data = 0..(*owner).as_ref().len();
        image.buffer = Bytes::Foreign(owner);
        image
    }

    /// Reads a message without copying: the image keeps the bytes.
    ///
    /// # Errors
    /// [`DecodeError`].
    pub fn from_bytes(bytes: Arc<Vec<u8>>) -> Result<Self, DecodeError> {
        let mut reader = WireReader::new(&bytes);
        let mut image = Self::read_around_data(&mut reader)?;
        reader.finish()?;
        image.buffer = Bytes::Own(bytes);
        Ok(image)
    }

    /// Bytes of the pixels, row by row.
    pub fn data(&self) -> &[u8] {
        self.buffer.get(self.data.clone()).unwrap_or_default()
    }

    /// Rows of pixels of `pixel_bytes` each, without the padding between rows.
    ///
    /// # Errors
    /// Width or height is zero, a row is longer than the step, or the data are shorter than rows and step need.
    pub fn rows(&self, pixel_bytes: usize) -> Result<impl Iterator<Item = &[u8]>, String> {
        let (width, height, step) = (self.width as usize, self.height as usize, self.step as usize);
        let row_bytes = width.checked_mul(pixel_bytes).filter(|bytes| (1..=step).contains(bytes));
        let needed = row_bytes.and_then(|bytes| step.checked_mul(height.checked_sub(1)?)?.checked_add(bytes));
        match (row_bytes, needed) {
            (Some(bytes), Some(needed)) if needed <= self.data().len() => {
                Ok(self.data().chunks(step).take(height).map(move |row| row.get(..bytes).unwrap_or(row)))
            }
            _ => Err(format!(
                "{width}x{height} pixels in {} do not fit rows of {step} bytes and {} bytes of data",
                self.encoding,
                self.data().len()
            )),
        }
    }

    /// Number of two bytes in the image's byte order.
    pub fn u16_of(&self, bytes: [u8; 2]) -> u16 {
        if self.is_bigendian != 0 {
            u16::from_be_bytes(bytes)
        } else {
            u16::from_le_bytes(bytes)
        }
    }

    /// Number of four bytes in the image's byte order.
    pub fn f32_of(&self, bytes: [u8; 4]) -> f32 {
        if self.is_bigendian != 0 {
            f32::from_be_bytes(bytes)
        } else {
            f32::from_le_bytes(bytes)
        }
    }

    /// Replaces the pixels by shared ones.
    #[must_use]
    pub fn with_data(mut self, data: Arc<Vec<u8>>) -> Self {
        self.data = 0..data.len();
        self.buffer = Bytes::Own(data);
        self
    }

    /// The encoded message in two parts: the fields before the pixels, and the pixels, which are copied unless they are
    /// those of [`sharing`](Self::sharing).
    pub fn parts(&self) -> (Vec<u8>, SharedBytes) {
        let mut beginning = Vec::new();
        self.write_before_data(&mut beginning);
        let pixels = match &self.buffer {
            Bytes::Foreign(owner) => Arc::clone(owner),
            Bytes::Own(_) => Arc::new(self.data().to_vec()),
        };
        (beginning, pixels)
    }

    fn read_around_data(reader: &mut WireReader<'_>) -> Result<Self, DecodeError> {
        let mut image = Self {
            header: reader.header()?,
            height: reader.u32("height")?,
            width: reader.u32("width")?,
            encoding: reader.string("encoding")?,
            is_bigendian: reader.u8("is_bigendian")?,
            step: reader.u32("step")?,
            ..Self::default()
        };
        let len = reader.count(1, "pixel data")?;
        let start = reader.position();
        reader.take(len, "pixel data")?;
        image.data = start..start + len;
        Ok(image)
    }

    fn write_before_data(&self, out: &mut Vec<u8>) {
        write_header(&self.header, out);
        write_u32(self.height, out);
        write_u32(self.width, out);
        write_string(&self.encoding, out);
        out.push(self.is_bigendian);
        write_u32(self.step, out);
        write_count(self.data().len(), out);
    }

    fn write(&self, out: &mut Vec<u8>) {
        self.write_before_data(out);
        out.extend_from_slice(self.data());
    }

    /// Approximate length of the message, bytes.
    fn len_hint(&self) -> usize {
        self.data().len() + 128
    }
}

impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        self.header == other.header
            && (self.height, self.width, self.step) == (other.height, other.width, other.step)
            && self.encoding == other.encoding
            && self.is_bigendian == other.is_bigendian
            && self.data() == other.data()
    }
}

big_message!(Image: rosrust_msg::sensor_msgs::Image);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{decode, encode};
    use proptest::prelude::*;
    use rosrust::RosMsg;

    fn image() -> Image {
        Image {
            header: Header { seq: 3, frame_id: "projector".to_owned(), ..Header::default() },
            height: 2,
            width: 1,
            encoding: "rgb8".to_owned(),
            is_bigendian: 0,
            step: 3,
            ..Image::default()
        }
        .with_data(Arc::new(vec![1, 2, 3, 4, 5, 6]))
    }

    #[test]
    fn shared_pixels_are_those_of_their_owner_and_go_over_the_wire_as_own_ones_do() {
        let own = image();
        let owner = Arc::new(vec![1, 2, 3, 4, 5, 6]);
        let shared = Image::sharing(own.header.clone(), [1, 2], "rgb8", 3, Arc::clone(&owner) as SharedBytes);
        assert_eq!(shared.data().as_ptr(), owner.as_ptr());
        assert_eq!(shared.encode_vec().unwrap(), own.encode_vec().unwrap());
        for image in [&shared, &own] {
            let (beginning, pixels) = image.parts();
            assert_eq!([&beginning, (*pixels).as_ref()].concat(), encode(image));
        }
        assert_eq!((*shared.parts().1).as_ref().as_ptr(), owner.as_ptr());
        drop(shared);
        assert_eq!(*owner, [1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn an_image_survives_the_wire() {
        let bytes = encode(&image());
        assert_eq!(decode::<Image>(&bytes).unwrap(), image());
        assert_eq!(Image::from_bytes(Arc::new(bytes)).unwrap(), image());
    }

    #[test]
    fn the_bytes_are_those_of_the_generated_type() {
        let frame = image().encode_vec().unwrap();
        let generated = rosrust_msg::sensor_msgs::Image::decode_slice(&frame).unwrap();
        assert_eq!(generated.data, image().data());
        assert_eq!(generated.encode_vec().unwrap(), frame);
        assert_eq!(Image::decode_slice(&frame).unwrap(), image());
    }

    #[test]
    fn every_truncation_is_an_error() {
        let bytes = encode(&image());
        for len in 0..bytes.len() {
            assert!(decode::<Image>(&bytes[..len]).is_err(), "{len} bytes");
        }
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let by_slice = decode::<Image>(&bytes).ok();
            prop_assert_eq!(by_slice, Image::from_bytes(Arc::new(bytes)).ok());
        }
    }
}
