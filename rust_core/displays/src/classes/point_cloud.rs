//! `rviz/PointCloud`: a `sensor_msgs/PointCloud`, its channels as fields of 32-bit floats.
//!
//! A channel that does not have a value for each point counts as zero for all of them. Points without a finite position
//! take part in the bounds of colours; unlike PointCloud2, rviz does not leave them out but puts them far away.

use std::sync::Arc;

use rcs_messages::sensor_msgs::{PointCloud, PointField};
use rcs_messages::PointCloud2;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::parts::cloud::{one_row, CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::{StatusText, World};

/// `sensor_msgs/PointCloud` as `sensor_msgs/PointCloud2`.
#[derive(Debug)]
pub(crate) struct PointCloudSource;

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> CloudDisplay<PointCloudSource> {
    CloudDisplay::new(display, settings.clone())
}

impl CloudSource for PointCloudSource {
    type Message = PointCloud;
    const NON_FINITE: NonFinite = NonFinite::FarAway;

    fn place(cloud: &Arc<PointCloud>, world: &World<'_>) -> Result<PlacedCloud, StatusText> {
        PlacedCloud::at_stamp(Arc::new(converted(cloud)), world)
    }
}

/// Converts the points with those channels that fit them; the others share one column of zeros, so that many empty
/// channels do not make a large cloud.
fn converted(cloud: &PointCloud) -> PointCloud2 {
    let field = |name, column: usize| (name, column as u32 * 4, PointField::FLOAT32);
    let mut fields = vec![field("x", 0), field("y", 1), field("z", 2)];
    let mut columns: Vec<&[f32]> = Vec::new();
    let zeros_column = 3 + cloud.channels.iter().filter(|channel| channel.values.len() == cloud.points.len()).count();
    for channel in &cloud.channels {
        if channel.values.len() == cloud.points.len() {
            fields.push(field(&channel.name, 3 + columns.len()));
            columns.push(&channel.values);
        } else {
            fields.push(field(&channel.name, zeros_column));
        }
    }
    let column_count = zeros_column + usize::from(columns.len() < cloud.channels.len());
    let mut data = Vec::with_capacity(cloud.points.len() * column_count * 4);
    for (i, point) in cloud.points.iter().enumerate() {
        data.extend([point.x, point.y, point.z].iter().flat_map(|value| value.to_le_bytes()));
        data.extend(columns.iter().filter_map(|column| column.get(i)).flat_map(|value| value.to_le_bytes()));
        data.resize((i + 1) * column_count * 4, 0);
    }
    one_row(&cloud.header, &fields, column_count as u32 * 4, data)
}

#[cfg(test)]
mod tests {
    use rcs_messages::geometry_msgs::Point32;
    use rcs_messages::sensor_msgs::ChannelFloat32;

    use super::*;

    fn channel(name: &str, values: &[f32]) -> ChannelFloat32 {
        ChannelFloat32 { name: name.to_owned(), values: values.to_vec() }
    }

    #[test]
    fn a_channel_with_too_few_values_is_zero_for_every_point() {
        let points = vec![Point32 { x: 1.0, y: 2.0, z: 3.0 }, Point32 { x: 4.0, y: 5.0, z: 6.0 }];
        let channels = vec![channel("short", &[7.0]), channel("i", &[8.0, 9.0]), channel("none", &[])];
        let cloud = converted(&PointCloud { points, channels, ..PointCloud::default() });
        let floats: Vec<f32> =
            cloud.data().chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
        assert_eq!(floats, [1.0, 2.0, 3.0, 8.0, 0.0, 4.0, 5.0, 6.0, 9.0, 0.0]);
        let fields: Vec<(&str, u32)> = cloud.fields.iter().map(|field| (field.name.as_str(), field.offset)).collect();
        assert_eq!(fields, [("x", 0), ("y", 4), ("z", 8), ("short", 16), ("i", 12), ("none", 16)]);
        assert_eq!((cloud.width, cloud.point_step), (2, 20));
    }

    #[test]
    fn many_channels_without_values_do_not_make_a_large_cloud() {
        let channels = vec![channel("", &[]); 10_000];
        let cloud =
            converted(&PointCloud { points: vec![Point32::default(); 10_000], channels, ..PointCloud::default() });
        assert_eq!(cloud.data().len(), 160_000);
    }
}
