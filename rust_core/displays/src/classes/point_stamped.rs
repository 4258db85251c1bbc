//! `rviz/PointStamped`: the last points of a topic as spheres.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Translation3, Vector3};
use rcs_messages::geometry_msgs::PointStamped;
use rcs_messages::point_xyz;
use rcs_rviz_config::PointStampedSettings;
use rcs_scene::{DisplayId, Drawable, Material, Rgba};

use crate::framework::display::Display;
use crate::framework::message_display::{InvalidFloats, MessageDisplay, MessageVisual};
use crate::parts::history::History;
use crate::parts::solids::solid;
use crate::Shape;

/// A PointStamped display.
pub(crate) type PointStampedDisplay = MessageDisplay<PointStampedVisual>;

/// What a PointStamped display draws.
#[derive(Debug)]
pub(crate) struct PointStampedVisual {
    display: DisplayId,
    material: Arc<Material>,
    diameter_m: f64,
    /// The spheres of the last points.
    history: History,
}

/// Makes a PointStamped display.
pub(crate) fn create(display: DisplayId, settings: &PointStampedSettings) -> Box<dyn Display> {
    Box::new(PointStampedDisplay::of(display, settings))
}

impl PointStampedDisplay {
    /// A display that has no message yet.
    pub(crate) fn of(display: DisplayId, settings: &PointStampedSettings) -> Self {
        let visual = PointStampedVisual {
            display,
            material: Arc::new(Material::lit(Rgba::from_rgb8(settings.color, settings.alpha))),
            diameter_m: 2.0 * f64::from(settings.radius_m),
            history: History::new(Some(settings.history_length)),
        };
        Self::new(&settings.topic, settings.queue_size, visual)
    }
}

impl MessageVisual for PointStampedVisual {
    type Message = PointStamped;

    fn show(&mut self, message: &PointStamped, fixed_from_frame: &Isometry3<f64>) -> Result<bool, InvalidFloats> {
        let point = point_xyz(&message.point);
        if point.iter().any(|coordinate| !coordinate.is_finite()) {
            return Err(InvalidFloats);
        }
        let frame_from_sphere = Translation3::from(point).to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector3::repeat(self.diameter_m));
        let fixed_from_sphere = fixed_from_frame.to_homogeneous() * frame_from_sphere;
        self.history.push([solid(self.display, Shape::Sphere, fixed_from_sphere, &self.material)]);
        Ok(true)
    }

    fn drawables(&self) -> &[Drawable] {
        self.history.drawables()
    }

    fn clear(&mut self) {
        self.history.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_history_has_the_last_points() {
        let settings = PointStampedSettings { history_length: 3, ..PointStampedSettings::default() };
        let mut visual = PointStampedDisplay::of(0, &settings).into_visual();
        for i in 0..8 {
            let mut message = PointStamped::default();
            message.point.x = f64::from(i);
            assert_eq!(visual.show(&message, &Isometry3::identity()), Ok(true));
            message.point.z = f64::NAN;
            assert_eq!(visual.show(&message, &Isometry3::identity()), Err(InvalidFloats));
        }
        let shown: Vec<f64> = visual.drawables().iter().map(|sphere| sphere.sort_point.x).collect();
        assert_eq!(shown, [5.0, 6.0, 7.0]);
    }
}
