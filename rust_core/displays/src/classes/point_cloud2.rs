//! `rviz/PointCloud2`: a `sensor_msgs/PointCloud2`, whose points without a finite position are left out.

use std::sync::Arc;

use rcs_messages::PointCloud2;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::parts::cloud::{CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::{StatusText, World};

/// `sensor_msgs/PointCloud2` as it is.
#[derive(Debug)]
pub(crate) struct PointCloud2Source;

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> CloudDisplay<PointCloud2Source> {
    CloudDisplay::new(display, settings.clone())
}

impl CloudSource for PointCloud2Source {
    type Message = PointCloud2;
    const NON_FINITE: NonFinite = NonFinite::LeftOut;

    fn place(cloud: &Arc<PointCloud2>, world: &World<'_>) -> Result<PlacedCloud, StatusText> {
        PlacedCloud::at_stamp(cloud.clone(), world)
    }
}

#[cfg(test)]
mod tests {
    use rcs_messages::sensor_msgs::PointField;
    use rcs_messages::AnyMessage;
    use rcs_rviz_config::ColorTransformer;
    use rcs_scene::{Drawable, Geometry};
    use rcs_transforms::Time;

    use super::*;
    use crate::framework::display::Display;
    use crate::framework::test_world::TestWorld;
    use crate::Level;

    /// Three points with a colour, the second one without a finite position.
    fn cloud() -> PointCloud2 {
        let points = [([1.0, 2.0, 3.0], 0x0a_14_1e), ([f32::NAN, 0.0, 0.0], 0), ([4.0, 5.0, 6.0_f32], 0x00_80_ff_u32)];
        let point = |(position, rgb): &([f32; 3], u32)| {
            position.map(f32::to_le_bytes).into_iter().chain([rgb.to_le_bytes()]).collect::<Vec<_>>().concat()
        };
        let mut cloud = PointCloud2::default().with_data(points.iter().flat_map(point).collect());
        (cloud.height, cloud.width, cloud.point_step, cloud.row_step) = (1, 3, 16, 48);
        let field = |(name, offset): (&str, u32)| PointField {
            name: name.to_owned(),
            offset,
            datatype: PointField::FLOAT32,
            count: 1,
        };
        cloud.fields = [("x", 0), ("y", 4), ("z", 8), ("rgb", 12)].map(field).to_vec();
        cloud.header.frame_id = "map".to_owned();
        cloud
    }

    fn show(cloud: &Arc<PointCloud2>, settings: &CloudSettings, packs_points: bool) -> (Drawable, String) {
        let world = TestWorld::at(Time::ZERO);
        let mut world = world.get();
        world.packs_points = packs_points;
        let mut display = create(0, settings);
        display.take(&AnyMessage::PointCloud2(Arc::clone(cloud)), &world);
        assert!(display.update(&world));
        let status = display.statuses().get("Points").unwrap().text.clone();
        (display.drawables()[0].clone(), status)
    }

    #[test]
    fn a_renderer_that_decodes_points_gets_the_message_s_bytes() {
        let cloud = Arc::new(cloud());
        let transformers = [ColorTransformer::Rgb8, ColorTransformer::FlatColor, ColorTransformer::AxisColor];
        for transformer in transformers {
            let mut settings = CloudSettings { color_transformer: Some(transformer), alpha: 1.0, ..Default::default() };
            settings.axis_color.auto_bounds = false;
            let (drawable, status) = show(&cloud, &settings, true);
            let Geometry::Packed(packed) = &drawable.geometry else { panic!("{transformer:?}: {drawable:?}") };
            assert_eq!(packed.bytes().as_ptr(), cloud.data().as_ptr(), "nothing is copied");
            let (other, other_status) = show(&cloud, &settings, false);
            let Geometry::Points(points) = &other.geometry else { panic!("{transformer:?}: {other:?}") };
            assert_eq!(packed.points().buffer, points.buffer);
            assert_eq!(packed.look(), points.look());
            assert_eq!(status, "Showing 2 points, 1 without a finite position left out");
            assert_eq!(status, other_status);
        }
    }

    #[test]
    fn what_is_drawn_otherwise_than_the_message_says_has_a_warning() {
        let statuses = |change: fn(&mut PointCloud2)| {
            let mut changed = cloud();
            change(&mut changed);
            let world = TestWorld::at(Time::ZERO);
            let mut display = create(0, &CloudSettings::default());
            display.take(&AnyMessage::PointCloud2(Arc::new(changed)), &world.get());
            display.update(&world.get());
            let worst = display.statuses().worst().map(|(name, status)| (status.level, name.to_owned()));
            (worst.unwrap(), display.drawables().len())
        };
        assert_eq!(statuses(|_| {}).0 .0, Level::Ok);
        assert_eq!(statuses(|cloud| cloud.is_bigendian = true), ((Level::Warn, "Message".to_owned()), 1));
        let nowhere = |cloud: &mut PointCloud2| cloud.set_data([0xff; 48].to_vec());
        assert_eq!(statuses(nowhere), ((Level::Warn, "Points".to_owned()), 1));
        let without_step = |cloud: &mut PointCloud2| {
            cloud.point_step = 0;
            cloud.set_data(Vec::new());
        };
        assert_eq!(statuses(without_step), ((Level::Error, "Message".to_owned()), 0));
    }

    #[test]
    fn points_whose_values_must_all_be_known_first_are_decoded_by_the_display() {
        let cloud = Arc::new(cloud());
        let opaque = CloudSettings { alpha: 1.0, ..CloudSettings::default() };
        let of = |transformer| CloudSettings { color_transformer: Some(transformer), ..opaque.clone() };
        let auto_axis = of(ColorTransformer::AxisColor);
        assert!(auto_axis.axis_color.auto_bounds);
        let faint = CloudSettings { alpha: 0.5, ..of(ColorTransformer::Rgb8) };
        for settings in [auto_axis, faint, of(ColorTransformer::Intensity), of(ColorTransformer::Mono8)] {
            assert!(matches!(show(&cloud, &settings, true).0.geometry, Geometry::Points(_)), "{settings:?}");
        }
    }
}
