//! `nav_msgs/OccupancyGrid` as a view of the received bytes.
//!
//! A map of tens of millions of cells keeps its bytes, as [`crate::PointCloud2`] does.

use crate::big_message::big_message;
use crate::nav_msgs::MapMetaData;
use crate::std_msgs::Header;
use crate::wire::{write_count, write_header, DecodeError, WireReader};
use rosrust::Time;
use std::ops::Range;
use std::sync::Arc;

/// ROS message `nav_msgs/OccupancyGrid`.
#[derive(Clone, Debug, Default)]
pub struct OccupancyGrid {
    /// Header.
    pub header: Header,
    /// Size in cells, metres a cell, and the pose of cell (0, 0).
    pub info: MapMetaData,
    buffer: Arc<Vec<u8>>,
    data: Range<usize>,
}

impl OccupancyGrid {
    /// Reads a message without copying: the map keeps the bytes.
    ///
    /// # Errors
    /// [`DecodeError`].
    pub fn from_bytes(bytes: Arc<Vec<u8>>) -> Result<Self, DecodeError> {
        let mut reader = WireReader::new(&bytes);
        let mut grid = Self { header: reader.header()?, info: read_info(&mut reader)?, ..Self::default() };
        let len = reader.count(1, "cells")?;
        let start = reader.position();
        reader.take(len, "cells")?;
        reader.finish()?;
        grid.data = start..start + len;
        grid.buffer = bytes;
        Ok(grid)
    }

    /// Cells row by row as unsigned bytes: 255 is −1.
    pub fn data(&self) -> &[u8] {
        self.buffer.get(self.data.clone()).unwrap_or_default()
    }

    /// Replaces the cells.
    #[must_use]
    pub fn with_data(mut self, data: Vec<u8>) -> Self {
        self.data = 0..data.len();
        self.buffer = data.into();
        self
    }

    fn len_hint(&self) -> usize {
        self.data().len() + 128
    }

    fn write(&self, out: &mut Vec<u8>) {
        write_header(&self.header, out);
        out.extend_from_slice(&crate::encode(&self.info));
        write_count(self.data().len(), out);
        out.extend_from_slice(self.data());
    }
}

fn read_info(reader: &mut WireReader<'_>) -> Result<MapMetaData, DecodeError> {
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

big_message!(OccupancyGrid: rosrust_msg::nav_msgs::OccupancyGrid);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{decode, encode};
    use rosrust::RosMsg;

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
