//! `rviz/PointStamped`: the last points of a topic as spheres.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Translation3, Vector3};
use rcs_messages::geometry_msgs::PointStamped;
use rcs_messages::point_xyz;
use rcs_rviz_config::PointStampedSettings;
use rcs_scene::{DisplayId, Material, Rgba};

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::all_finite;
use crate::parts::solids::solid;
use crate::SolidShape;

#[derive(Debug)]
pub(crate) struct PointStampedVisual {
    display: DisplayId,
    material: Arc<Material>,
    diameter_m: f64,
}

pub(crate) fn create(display: DisplayId, settings: &PointStampedSettings) -> MessageDisplay<PointStampedVisual> {
    let visual = PointStampedVisual {
        display,
        material: Arc::new(Material::lit(Rgba::from_rgb8(settings.color, settings.alpha))),
        diameter_m: 2.0 * f64::from(settings.radius_m),
    };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(settings.history_length), visual)
}

impl MessageVisual for PointStampedVisual {
    type Message = PointStamped;

    fn draw(&mut self, message: &PointStamped, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        let point = point_xyz(&message.point);
        if !all_finite(&point) {
            return Err(InvalidFloats);
        }
        let frame_from_sphere = Translation3::from(point).to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector3::repeat(self.diameter_m));
        let fixed_from_sphere = fixed_from_frame.to_homogeneous() * frame_from_sphere;
        Ok(Some(vec![solid(self.display, SolidShape::Sphere, fixed_from_sphere, &self.material)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framework::display::Display;

    #[test]
    fn the_history_has_the_last_points() {
        let settings = PointStampedSettings { history_length: 3, ..PointStampedSettings::default() };
        let mut display = create(0, &settings);
        for i in 0..8 {
            let mut message = PointStamped::default();
            message.point.x = f64::from(i);
            assert_eq!(display.show(&message, &Isometry3::identity()), Ok(true));
            message.point.z = f64::NAN;
            assert_eq!(display.show(&message, &Isometry3::identity()), Err(InvalidFloats));
        }
        let shown: Vec<f64> = display.drawables().iter().map(|sphere| sphere.sort_point.x).collect();
        assert_eq!(shown, [5.0, 6.0, 7.0]);
    }
}
