//! Layout of a cloud's channels in its bytes, validated once.

use rcs_messages::sensor_msgs::PointField;
use rcs_messages::PointCloud2;
use rcs_rviz_config::{CloudSettings, ColorTransformer};
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
    FieldOutside { name: String, offset: usize, point_step: usize },
}

/// A channel of a cloud; its bytes need not lie inside of a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CloudChannel {
    pub(crate) name: String,
    pub(crate) offset: usize,
    pub(crate) datatype: u8,
}

impl CloudChannel {
    /// Value of a point as a float, integers unsigned, as in rviz; 0 for an unknown datatype.
    #[inline]
    pub(crate) fn value(&self, point: &[u8]) -> f32 {
        macro_rules! read {
            ($type:ty) => {
                <$type>::from_le_bytes(bytes_at(point, self.offset)) as f32
            };
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
    pub(crate) fn bits(&self, point: &[u8]) -> u32 {
        u32::from_le_bytes(bytes_at(point, self.offset))
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
    /// Layout of a cloud whose x, y and z lie inside of a point.
    pub(super) fn of(cloud: &PointCloud2) -> Result<Self, LayoutError> {
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
        let point_count = width as usize * height as usize;
        let layout = Self { position, point_step: point_step as usize, point_count, channels };
        layout.position.iter().try_for_each(|channel| layout.check_within(channel, 4))?;
        Ok(layout)
    }

    /// Layout of a cloud with the colour transformer that rviz uses. Only the channels that are read must lie inside of
    /// a point.
    pub(crate) fn colored(
        cloud: &PointCloud2,
        settings: &CloudSettings,
    ) -> Result<(Self, ColorTransformer), LayoutError> {
        let layout = Self::of(cloud)?;
        let transformer = layout.fitting_transformer(settings.color_transformer);
        let check = |channel: Option<&CloudChannel>, len: fn(u8) -> usize| {
            channel.map_or(Ok(()), |channel| layout.check_within(channel, len(channel.datatype)))
        };
        match transformer {
            ColorTransformer::FlatColor | ColorTransformer::AxisColor => {}
            ColorTransformer::Intensity => check(layout.intensity(&settings.intensity.channel_name), size_of)?,
            ColorTransformer::Rgb8 | ColorTransformer::Mono8 => {
                check(layout.packed_color().map(|(channel, _)| channel), |_| 4)?;
            }
            ColorTransformer::Rgbf32 => {
                ["r", "g", "b"].iter().try_for_each(|name| check(layout.channel(name), |_| 4))?;
            }
        }
        Ok((layout, transformer))
    }

    fn check_within(&self, channel: &CloudChannel, len: usize) -> Result<(), LayoutError> {
        let (offset, point_step) = (channel.offset, self.point_step);
        if self.point_count == 0 || offset + len <= point_step {
            return Ok(());
        }
        Err(LayoutError::FieldOutside { name: channel.name.clone(), offset, point_step })
    }

    /// Layout of a position in a point's bytes.
    pub(super) fn positions(&self) -> PositionLayout {
        PositionLayout::new(self.position.each_ref().map(|channel| channel.offset))
    }

    /// Channel of the intensity, by the name in the settings.
    pub(super) fn intensity(&self, name: &str) -> Option<&CloudChannel> {
        let other_name = if name == "intensity" { self.channel("intensities") } else { None };
        self.channel(name).or(other_name)
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
    pub(super) fn fitting_transformer(&self, chosen: Option<ColorTransformer>) -> ColorTransformer {
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
