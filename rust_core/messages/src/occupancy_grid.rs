//! `nav_msgs/OccupancyGrid` as a view of the received bytes.
//!
//! A map may have tens of millions of cells; it keeps its bytes as [`crate::PointCloud2`] does.

use crate::bytes::{copy_of, Bytes};
use crate::nav_msgs::MapMetaData;
use crate::std_msgs::Header;
use crate::wire::{framed, write_count, write_header, DecodeError, Reader, LENGTH_PREFIX};
use rosrust::{Message, RosMsg, Time};
use std::io;
use std::ops::Range;
use std::sync::Arc;

/// ROS message `nav_msgs/OccupancyGrid`.
#[derive(Clone, Debug, Default)]
pub struct OccupancyGrid {
    /// Sequence number, stamp and frame.
    pub header: Header,
    /// Size in cells, metres a cell, and where the corner of cell (0, 0) lies.
    pub info: MapMetaData,
    buffer: Bytes,
    data: Range<usize>,
}

impl OccupancyGrid {
    /// Reads a message whose bytes become the map's own; nothing is copied.
    pub fn from_bytes(bytes: Arc<Vec<u8>>) -> Result<Self, DecodeError> {
        let mut reader = Reader::new(&bytes);
        let mut grid = Self { header: reader.header()?, info: read_info(&mut reader)?, ..Self::default() };
        let len = reader.count(1, "cells")?;
        let start = reader.position();
        reader.take(len, "cells")?;
        reader.finish()?;
        grid.data = start..start + len;
        grid.buffer = bytes.into();
        Ok(grid)
    }

    /// The cells row by row, as the bytes that they were sent as: 255 is −1.
    pub fn data(&self) -> &[u8] {
        self.buffer.get(self.data.clone()).unwrap_or_default()
    }

    /// The same map with these cells.
    #[must_use]
    pub fn with_data(mut self, data: Vec<u8>) -> Self {
        self.data = 0..data.len();
        self.buffer = data.into();
        self
    }

    fn write(&self, out: &mut Vec<u8>) {
        write_header(&self.header, out);
        out.extend_from_slice(&crate::encode(&self.info));
        write_count(self.data().len(), out);
        out.extend_from_slice(self.data());
    }
}

fn read_info(reader: &mut Reader<'_>) -> Result<MapMetaData, DecodeError> {
    let mut info = MapMetaData {
        map_load_time: Time { sec: reader.u32("map_load_time")?, nsec: reader.u32("map_load_time")? },
        resolution: f32::from_le_bytes(reader.array("resolution")?),
        width: reader.u32("width")?,
        height: reader.u32("height")?,
        ..MapMetaData::default()
    };
    let (position, orientation) = (&mut info.origin.position, &mut info.origin.orientation);
    for number in [&mut position.x, &mut position.y, &mut position.z] {
        *number = f64::from_le_bytes(reader.array("origin")?);
    }
    for number in [&mut orientation.x, &mut orientation.y, &mut orientation.z, &mut orientation.w] {
        *number = f64::from_le_bytes(reader.array("origin")?);
    }
    Ok(info)
}

impl PartialEq for OccupancyGrid {
    fn eq(&self, other: &Self) -> bool {
        self.header == other.header && self.info == other.info && self.data() == other.data()
    }
}

impl RosMsg for OccupancyGrid {
    fn encode<W: io::Write>(&self, mut w: W) -> io::Result<()> {
        let mut out = Vec::with_capacity(self.data().len() + 128);
        self.write(&mut out);
        w.write_all(&out)
    }

    /// Reads to the end of `r`: a map is always a message of its own here.
    fn decode<R: io::Read>(mut r: R) -> io::Result<Self> {
        let mut bytes = Vec::new();
        r.read_to_end(&mut bytes)?;
        Ok(Self::from_bytes(Arc::new(bytes))?)
    }

    fn encode_vec(&self) -> io::Result<Vec<u8>> {
        framed(self.data().len() + 128, |out| self.write(out))
    }

    fn decode_slice(bytes: &[u8]) -> io::Result<Self> {
        let message = bytes.get(LENGTH_PREFIX..).ok_or(io::ErrorKind::UnexpectedEof)?;
        Ok(Self::from_bytes(Arc::new(copy_of(message)))?)
    }
}

impl Message for OccupancyGrid {
    fn msg_definition() -> String {
        rosrust_msg::nav_msgs::OccupancyGrid::msg_definition()
    }

    fn md5sum() -> String {
        rosrust_msg::nav_msgs::OccupancyGrid::md5sum()
    }

    fn msg_type() -> String {
        rosrust_msg::nav_msgs::OccupancyGrid::msg_type()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{decode, encode};

    fn grid() -> OccupancyGrid {
        let mut grid = OccupancyGrid {
            header: Header { seq: 5, frame_id: "map".to_owned(), ..Header::default() },
            ..OccupancyGrid::default()
        }
        .with_data(vec![0, 100, 255, 50, 1, 128]);
        (grid.info.width, grid.info.height, grid.info.resolution) = (3, 2, 0.05);
        grid.info.map_load_time = Time { sec: 3, nsec: 4 };
        grid.info.origin.position.y = -7.5;
        (grid.info.origin.orientation.z, grid.info.origin.orientation.w) = (0.6, 0.8);
        grid
    }

    #[test]
    fn the_bytes_are_those_of_the_generated_type() {
        let frame = grid().encode_vec().unwrap();
        let generated = rosrust_msg::nav_msgs::OccupancyGrid::decode_slice(&frame).unwrap();
        assert_eq!(generated.info, grid().info);
        assert_eq!(generated.data, [0, 100, -1, 50, 1, -128]);
        assert_eq!(generated.encode_vec().unwrap(), frame);
        assert_eq!(OccupancyGrid::decode_slice(&frame).unwrap(), grid());
        assert_eq!(decode::<OccupancyGrid>(&encode(&grid())).unwrap(), grid());
    }

    #[test]
    fn every_truncation_is_an_error_and_so_is_a_byte_too_many() {
        let mut bytes = encode(&grid());
        for len in 0..bytes.len() {
            assert!(decode::<OccupancyGrid>(&bytes[..len]).is_err(), "{len} bytes");
        }
        bytes.push(0);
        assert!(decode::<OccupancyGrid>(&bytes).is_err());
    }
}
