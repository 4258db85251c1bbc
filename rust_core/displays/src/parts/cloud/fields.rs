//! Layout of a cloud's channels in its bytes, validated once.

use rcs_messages::sensor_msgs::PointField;
use rcs_messages::PointCloud2;
use rcs_rviz_config::ColorTransformer;
use rcs_scene::{bytes_at, PositionLayout};
use thiserror::Error;

#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum LayoutError {
    #[error("Data size ({actual} bytes) does not match width ({width}) times height ({height}) times point_step ({point_step})")]
    Size { actual: usize, width: u32, height: u32, point_step: u32 },
    #[error("The cloud has no channel {0}")]
    NoPosition(&'static str),
    /// Positions that are not 32-bit floats, for which rviz has no transformer.
    #[error("No position transformer available for cloud: channel {name} has datatype {datatype}, not FLOAT32")]
    PositionType { name: &'static str, datatype: u8 },
    #[error("Channel {name} at offset {offset} reaches past point_step ({point_step})")]
    FieldOutside { name: String, offset: u32, point_step: u32 },
}

/// A channel whose bytes lie inside of every point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CloudChannel {
    pub(crate) name: String,
    pub(crate) offset: usize,
    pub(crate) datatype: u8,
}

impl CloudChannel {
    /// Value of a point as a float, integers unsigned, as in rviz; 0 for an unknown datatype.
    #[inline]
    pub(crate) fn value(&self, point: &[u8], big_endian: bool) -> f32 {
        macro_rules! read {
            ($type:ty) => {{
                let bytes = bytes_at(point, self.offset);
                (if big_endian { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) }) as f32
            }};
        }
        match self.datatype {
            PointField::INT8 | PointField::UINT8 => read!(u8),
            PointField::INT16 | PointField::UINT16 => read!(u16),
            PointField::INT32 | PointField::UINT32 => read!(u32),
            PointField::FLOAT32 => read!(f32),
            PointField::FLOAT64 => read!(f64),
            _ => 0.0,
        }
    }

    #[inline(always)]
    pub(crate) fn bits(&self, point: &[u8], big_endian: bool) -> u32 {
        let bytes = bytes_at(point, self.offset);
        if big_endian {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        }
    }
}

fn size_of(datatype: u8) -> usize {
    match datatype {
        PointField::INT8 | PointField::UINT8 => 1,
        PointField::INT16 | PointField::UINT16 => 2,
        PointField::FLOAT64 => 8,
        _ => 4,
    }
}

#[derive(Clone, Debug)]
pub(crate) struct CloudLayout {
    pub(crate) position: [CloudChannel; 3],
    pub(crate) point_step: usize,
    pub(crate) point_count: usize,
    channels: Vec<CloudChannel>,
}

impl CloudLayout {
    pub(crate) fn of(cloud: &PointCloud2) -> Result<Self, LayoutError> {
        let (width, height, point_step) = (cloud.width, cloud.height, cloud.point_step);
        let channels: Vec<CloudChannel> = cloud
            .fields
            .iter()
            .map(|field| CloudChannel {
                name: field.name.clone(),
                offset: field.offset as usize,
                datatype: field.datatype,
            })
            .collect();
        let find = |name: &str| channels.iter().find(|channel| channel.name == name);
        let position = |name: &'static str| find(name).cloned().ok_or(LayoutError::NoPosition(name));
        let position = [position("x")?, position("y")?, position("z")?];
        let claimed = u128::from(width) * u128::from(height) * u128::from(point_step);
        let actual = cloud.data().len();
        if claimed != actual as u128 {
            return Err(LayoutError::Size { actual, width, height, point_step });
        }
        if position[0].datatype != PointField::FLOAT32 {
            return Err(LayoutError::PositionType { name: "x", datatype: position[0].datatype });
        }
        let outside = |channel: &&CloudChannel| channel.offset + size_of(channel.datatype) > point_step as usize;
        if let Some(channel) = channels.iter().find(outside).filter(|_| actual > 0) {
            return Err(LayoutError::FieldOutside {
                name: channel.name.clone(),
                offset: channel.offset as u32,
                point_step,
            });
        }
        // A point step of 0 has no data, and no points either.
        let point_count = actual.checked_div(point_step as usize).unwrap_or(0);
        Ok(Self { position, point_step: point_step as usize, point_count, channels })
    }

    /// Layout of a position in a point's bytes.
    pub(super) fn positions(&self, is_big_endian: bool) -> PositionLayout {
        PositionLayout::new(self.position.each_ref().map(|channel| channel.offset), is_big_endian)
    }

    pub(crate) fn channel(&self, name: &str) -> Option<&CloudChannel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// `true` if each point has an opacity of its own.
    pub(crate) fn has_point_alpha(&self) -> bool {
        self.channel("rgba").is_some()
    }

    /// Channel of packed colours, and whether its alpha counts: `rgb` or `rgba`; where a cloud has both, rviz reads the
    /// later one, without alpha.
    pub(crate) fn packed_color(&self) -> Option<(&CloudChannel, bool)> {
        let index = self.channels.iter().position(|channel| channel.name == "rgb");
        let index_alpha = self.channels.iter().position(|channel| channel.name == "rgba");
        let channel = self.channels.get(index.max(index_alpha)?)?;
        Some((channel, index.is_none()))
    }

    /// Colour transformer that rviz uses: the chosen one if it fits, else RGB8 if that fits, else Intensity.
    pub(crate) fn fitting_transformer(&self, chosen: Option<ColorTransformer>) -> ColorTransformer {
        let packed = self.packed_color().is_some_and(|(channel, _)| {
            matches!(channel.datatype, PointField::INT32 | PointField::UINT32 | PointField::FLOAT32)
        });
        let fits = |transformer: &ColorTransformer| match transformer {
            ColorTransformer::Rgb8 | ColorTransformer::Mono8 => packed,
            ColorTransformer::Rgbf32 => {
                self.channel("r").is_some_and(|red| red.datatype == PointField::FLOAT32)
                    && self.channel("g").is_some()
                    && self.channel("b").is_some()
            }
            ColorTransformer::Intensity | ColorTransformer::FlatColor | ColorTransformer::AxisColor => true,
        };
        let automatic = if packed { ColorTransformer::Rgb8 } else { ColorTransformer::Intensity };
        chosen.filter(fits).unwrap_or(automatic)
    }
}
