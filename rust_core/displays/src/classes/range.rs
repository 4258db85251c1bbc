//! `rviz/Range`: a cone from the sensor to its measurement, as wide as its field of view.
//!
//! A cone stands where its frame was at the message's stamp. A measurement out of the sensor's range shows nothing,
//! except that a sensor of one fixed distance shows that distance for minus infinity ("something is there").

use std::cmp::Ordering;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Translation3, UnitQuaternion, Vector3};
use rcs_messages::sensor_msgs::Range;
use rcs_rviz_config::RangeSettings;
use rcs_scene::{DisplayId, Drawable, Material, Rgba};

use crate::framework::message_display::{DrawResult, MessageDisplay, MessageVisual};
use crate::parts::solids::solid;
use crate::SolidShape;

/// Share of its length by which rviz draws a cone nearer to the sensor than its middle.
const FUDGE: f64 = 0.008824;

#[derive(Debug)]
pub(crate) struct RangeVisual {
    display: DisplayId,
    material: Arc<Material>,
}

pub(crate) fn create(display: DisplayId, settings: &RangeSettings) -> MessageDisplay<RangeVisual> {
    let material = Arc::new(Material::lit(Rgba::from_rgb8(settings.color, settings.alpha)));
    let visual = RangeVisual { display, material };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(settings.buffer_length), visual)
}

impl RangeVisual {
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
        Some(solid(self.display, SolidShape::Cone, fixed_from_cone, &self.material))
    }
}

/// Displayed distance in metres, if any.
fn shown_range_m(range: &Range) -> Option<f32> {
    if (range.min_range..=range.max_range).contains(&range.range) {
        Some(range.range)
    } else {
        let is_detection = range.min_range == range.max_range && range.range == f32::NEG_INFINITY;
        is_detection.then_some(range.min_range)
    }
}

impl MessageVisual for RangeVisual {
    type Message = Range;

    fn draw(&mut self, message: &Range, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        Ok(Some(self.cone(message, fixed_from_frame).into_iter().collect()))
    }

    fn fault(&self, range: &Range) -> Option<String> {
        let Range { min_range, max_range, field_of_view, .. } = range;
        if min_range.partial_cmp(max_range).is_none_or(Ordering::is_gt) {
            Some(format!("No range is shown: min_range is {min_range} and max_range {max_range}."))
        } else if *field_of_view == 0.0 || !field_of_view.is_finite() {
            Some(format!("Field of view is {field_of_view}, cones will be invisible."))
        } else {
            None
        }
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

    #[test]
    fn a_sensor_without_limits_or_field_of_view_is_an_error() {
        let visual = RangeVisual { display: 0, material: Arc::new(Material::lit(Rgba::from_rgb8([0; 3], 1.0))) };
        let fault = |min_range, max_range, field_of_view| {
            let text = visual.fault(&Range { min_range, max_range, field_of_view, range: 1.0, ..Range::default() });
            text.map(|text| text.split([':', ',']).next().map(str::to_owned).unwrap())
        };
        for (min_range, max_range) in [(0.1, 3.0), (0.5, 0.5), (0.0, f32::INFINITY), (f32::NEG_INFINITY, 9.0)] {
            assert_eq!(fault(min_range, max_range, 0.2), None, "{min_range} {max_range}");
        }
        for (min_range, max_range) in [(3.0, 0.1), (f32::NAN, 3.0), (0.1, f32::NAN)] {
            assert_eq!(fault(min_range, max_range, 0.2).as_deref(), Some("No range is shown"));
        }
        for (field_of_view, text) in [(0.0, "Field of view is 0"), (f32::NAN, "Field of view is NaN")] {
            assert_eq!(fault(0.1, 3.0, field_of_view).as_deref(), Some(text));
        }
    }
}
