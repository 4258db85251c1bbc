//! `sensor_msgs/Image`, as a view of received bytes and as a frame to send whose pixels are never copied.
//!
//! A received image keeps its bytes as [`crate::PointCloud2`] does. An image to send is an [`ImageFrame`]: the message
//! ends with its pixels, so all that is before them is a short head of its own, and one buffer of pixels can be sent
//! again with another stamp.

use crate::std_msgs::Header;
use crate::wire::{write_count, DecodeError, Reader, Wire};
use crate::Message;
use std::ops::Range;
use std::sync::Arc;

/// ROS message `sensor_msgs/Image`.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Sequence number, stamp and frame.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Pixels in a row.
    pub width: u32,
    /// What a pixel is, such as `rgb8`.
    pub encoding: String,
    /// Whether numbers of more than one byte are big endian.
    pub is_bigendian: u8,
    /// Bytes from one row to the next.
    pub step: u32,
    buffer: Arc<Vec<u8>>,
    data: Range<usize>,
}

impl Image {
    /// Reads a message whose bytes become the image's own; nothing is copied.
    pub fn from_bytes(bytes: Arc<Vec<u8>>) -> Result<Self, DecodeError> {
        let mut reader = Reader::new(&bytes);
        let mut image = Self::read_around_data(&mut reader)?;
        reader.finish()?;
        image.buffer = bytes;
        Ok(image)
    }

    /// The bytes of the pixels, row by row.
    pub fn data(&self) -> &[u8] {
        self.buffer.get(self.data.clone()).unwrap_or_default()
    }

    /// The same image with these bytes as its pixels, shared and not copied.
    #[must_use]
    pub fn with_data(mut self, data: Arc<Vec<u8>>) -> Self {
        self.data = 0..data.len();
        self.buffer = data;
        self
    }

    fn read_around_data(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let mut image = Self {
            header: Header::read(reader)?,
            height: u32::read(reader)?,
            width: u32::read(reader)?,
            encoding: String::read(reader)?,
            is_bigendian: u8::read(reader)?,
            step: u32::read(reader)?,
            ..Self::default()
        };
        let len = reader.count(1, "pixel data")?;
        let start = reader.position();
        reader.take(len, "pixel data")?;
        image.data = start..start + len;
        Ok(image)
    }

    fn write_head(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        self.height.write(out);
        self.width.write(out);
        self.encoding.write(out);
        self.is_bigendian.write(out);
        self.step.write(out);
        write_count(self.data().len(), out);
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

impl Wire for Image {
    const MIN_LEN: usize = Header::MIN_LEN + 4 + 4 + 4 + 1 + 4 + 4;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let mut pixels = reader.clone();
        let image = Self::read_around_data(reader)?;
        pixels.take(image.data.start - pixels.position(), "pixel data")?;
        let data = pixels.take(image.data.len(), "pixel data")?.to_vec();
        Ok(image.with_data(Arc::new(data)))
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.reserve(self.data().len() + 128);
        self.write_head(out);
        out.extend_from_slice(self.data());
    }

    fn ros_type() -> String {
        Self::TYPE.to_owned()
    }

    fn collect_definitions(found: &mut Vec<(String, String)>) {
        let text = "Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n\
                    uint8[] data\n";
        found.push((Self::TYPE.to_owned(), text.to_owned()));
        Header::collect_definitions(found);
    }
}

impl Message for Image {
    const TYPE: &'static str = "sensor_msgs/Image";
    const MD5SUM: &'static str = "060021388200f6f0f447d0fcd9c64743";
}

/// A serialised image in two parts: `head` followed by `pixels` is the message.
#[derive(Clone, Debug)]
pub struct ImageFrame {
    /// All that is before the pixels.
    pub head: Vec<u8>,
    /// The pixels, shared.
    pub pixels: Arc<Vec<u8>>,
}

impl ImageFrame {
    /// The frame of `width_px` × `height_px` pixels of `encoding`, with rows `step_bytes` apart.
    pub fn new(
        header: Header,
        [width_px, height_px]: [u32; 2],
        encoding: &str,
        step_bytes: u32,
        pixels: Arc<Vec<u8>>,
    ) -> Self {
        let image = Image {
            header,
            height: height_px,
            width: width_px,
            encoding: encoding.to_owned(),
            is_bigendian: 0,
            step: step_bytes,
            ..Image::default()
        }
        .with_data(Arc::clone(&pixels));
        let mut head = Vec::with_capacity(128);
        image.write_head(&mut head);
        Self { head, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{decode, encode};
    use proptest::prelude::*;

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
    fn an_image_survives_the_wire() {
        let bytes = encode(&image());
        assert_eq!(decode::<Image>(&bytes).unwrap(), image());
        assert_eq!(Image::from_bytes(Arc::new(bytes)).unwrap(), image());
    }

    #[test]
    fn a_frame_is_the_serialised_image() {
        let pixels = Arc::new(vec![1, 2, 3, 4, 5, 6]);
        let frame = ImageFrame::new(image().header, [1, 2], "rgb8", 3, pixels);
        let joined = [frame.head.as_slice(), frame.pixels.as_slice()].concat();
        assert_eq!(joined, encode(&image()));
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
            let by_slice = decode::<Image>(&bytes);
            prop_assert_eq!(by_slice, Image::from_bytes(Arc::new(bytes)));
        }
    }
}
