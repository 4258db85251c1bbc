//! `rviz/Range`: a cone from the sensor to what it measured, as wide as its field of view.
//!
//! A cone stands where its frame was at the message's stamp. A measurement out of the sensor's range shows nothing, except
//! that a sensor of one fixed distance shows that distance for minus infinity ("something is there").

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Translation3, UnitQuaternion, Vector3};
use rcs_messages::sensor_msgs::Range;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::RangeSettings;
use rcs_scene::{DisplayId, Drawable, Material, Rgba};
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::waiting_messages::WaitingMessages;
use crate::parts::solids::solid;
use crate::{Shape, Statuses, World};

/// By what share of its length rviz draws a cone nearer to the sensor than its middle.
const FUDGE: f64 = 0.008824;

/// A Range display.
#[derive(Debug)]
pub(crate) struct RangeDisplay {
    display: DisplayId,
    settings: RangeSettings,
    material: Arc<Material>,
    incoming: WaitingMessages<Range>,
    /// The last measurements, oldest first; `None` for those that show nothing.
    cones: VecDeque<Option<Drawable>>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

/// Makes a Range display.
pub(crate) fn create(display: DisplayId, settings: &RangeSettings) -> Box<dyn Display> {
    Box::new(RangeDisplay::new(display, settings.clone()))
}

impl RangeDisplay {
    pub(crate) fn new(display: DisplayId, settings: RangeSettings) -> Self {
        Self {
            display,
            material: Arc::new(Material::lit(Rgba::from_rgb8(settings.color, settings.alpha))),
            incoming: WaitingMessages::new(settings.queue_size),
            settings,
            cones: VecDeque::new(),
            drawables: Vec::new(),
            statuses: Statuses::default(),
        }
    }

    /// The cone of a measurement; `None` where it has no size.
    fn cone(&self, range: &Range, fixed_from_sensor: &Isometry3<f64>) -> Option<Drawable> {
        let length_m = f64::from(shown_range_m(range)?);
        let diameter_m = 2.0 * length_m * (f64::from(range.field_of_view) / 2.0).tan();
        if !(length_m.is_finite() && diameter_m.is_finite()) {
            return None;
        }
        // The cone's tip is at the end of its own y axis.
        let sensor_from_upright = Isometry3::from_parts(
            Translation3::new(length_m / 2.0 - FUDGE * length_m, 0.0, 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2),
        );
        let fixed_from_cone = (fixed_from_sensor * sensor_from_upright).to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector3::new(diameter_m, length_m, diameter_m));
        Some(solid(self.display, Shape::Cone, fixed_from_cone, &self.material))
    }
}

/// The distance that is shown, in metres; `None` for nothing.
fn shown_range_m(range: &Range) -> Option<f32> {
    if (range.min_range..=range.max_range).contains(&range.range) {
        Some(range.range)
    } else {
        let is_detection = range.min_range == range.max_range && range.range == f32::NEG_INFINITY;
        is_detection.then_some(range.min_range)
    }
}

impl Display for RangeDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        let settings = &self.settings;
        TopicRequest::new(&settings.topic, MessageKind::Range, settings.queue_size).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        if let AnyMessage::Range(range) = message {
            self.incoming.push(&range.header, range.clone(), &mut self.statuses);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.incoming.is_waiting(stamp)
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let mut changed = false;
        for range in self.incoming.take_ready(world, &mut self.statuses) {
            let Ok(fixed_from_sensor) = world.fixed_from_header(&range.header) else { continue };
            if self.cones.len() >= self.settings.buffer_length.max(1) as usize {
                self.cones.pop_front();
            }
            self.cones.push_back(self.cone(&range, &fixed_from_sensor));
            changed = true;
        }
        if changed {
            self.drawables = self.cones.iter().flatten().cloned().collect();
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.cones.clear();
        self.drawables.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_measurement_within_the_range_is_shown() {
        let shown =
            |min_range, max_range, range| shown_range_m(&Range { min_range, max_range, range, ..Range::default() });
        for (range, expected) in [(0.1, Some(0.1)), (3.0, Some(3.0)), (0.09, None), (3.1, None), (f32::NAN, None)] {
            assert_eq!(shown(0.1, 3.0, range), expected, "{range}");
        }
        // A sensor of one distance: minus infinity means that something is there, plus infinity that nothing is.
        let (no, yes) = (f32::INFINITY, f32::NEG_INFINITY);
        for (range, expected) in [(yes, Some(0.5)), (no, None), (f32::NAN, None), (0.5, Some(0.5)), (0.2, None)] {
            assert_eq!(shown(0.5, 0.5, range), expected, "{range}");
        }
        assert_eq!(shown(0.1, 3.0, yes), None);
    }
}
