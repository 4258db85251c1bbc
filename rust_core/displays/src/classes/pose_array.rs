//! `rviz/PoseArray`: all poses of the last message.
//!
//! Flat arrows are lines whose material replaces what is behind, so that their opacity has no effect.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use rcs_messages::geometry_msgs::PoseArray;
use rcs_messages::PlainTransform;
use rcs_rviz_config::{PoseArraySettings, PoseArrayShape};
use rcs_scene::{Blending, DisplayId, Geometry, LineTopology, Lines, Rgba};

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::isometry;
use crate::parts::pose_symbol::PoseSymbol;
use crate::parts::solids::{drawable, ArrowSize};

#[derive(Debug)]
enum ArraySymbol {
    FlatArrow { length_m: f64, color: [u8; 4] },
    Solid(PoseSymbol),
}

#[derive(Debug)]
pub(crate) struct PoseArrayVisual {
    display: DisplayId,
    symbol: ArraySymbol,
}

pub(crate) fn create(display: DisplayId, settings: &PoseArraySettings) -> MessageDisplay<PoseArrayVisual> {
    let symbol = match settings.shape {
        PoseArrayShape::ArrowFlat => ArraySymbol::FlatArrow {
            length_m: settings.flat_arrow_length_m.into(),
            color: Rgba::from_rgb8(settings.color, settings.alpha).to_rgba8(),
        },
        PoseArrayShape::Arrow3d => {
            // rviz hands its "radii" to something that takes diameters.
            let size = ArrowSize {
                shaft_length_m: settings.shaft_length_m.into(),
                shaft_diameter_m: settings.shaft_radius_m.into(),
                head_length_m: settings.head_length_m.into(),
                head_diameter_m: settings.head_radius_m.into(),
            };
            ArraySymbol::Solid(PoseSymbol::arrow(size, settings.color, settings.alpha))
        }
        PoseArrayShape::Axes => ArraySymbol::Solid(PoseSymbol::axes(settings.axes_length_m, settings.axes_radius_m)),
    };
    let visual = PoseArrayVisual { display, symbol };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(1), visual)
}

impl MessageVisual for PoseArrayVisual {
    type Message = PoseArray;

    fn draw(&mut self, message: &PoseArray, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        let poses: Option<Vec<Isometry3<f64>>> =
            message.poses.iter().map(|pose| isometry(&PlainTransform::from(pose))).collect();
        let poses = poses.ok_or(InvalidFloats)?;
        Ok(Some(match &self.symbol {
            ArraySymbol::FlatArrow { length_m, color } => {
                let lines = Lines {
                    positions: poses.iter().flat_map(|pose| flat_arrow(pose, *length_m)).collect(),
                    colors: vec![*color],
                    topology: LineTopology::List,
                    blending: Blending::Replace,
                };
                let fixed_from_frame = fixed_from_frame.to_homogeneous();
                vec![drawable(self.display, fixed_from_frame, Geometry::Lines(Arc::new(lines)))]
            }
            ArraySymbol::Solid(symbol) => symbol.at_all(self.display, poses.iter().map(|pose| fixed_from_frame * pose)),
        }))
    }
}

/// The ends of three lines in the pose's XY plane: shaft and both sides of the head.
fn flat_arrow(frame_from_pose: &Isometry3<f64>, length_m: f64) -> [[f32; 3]; 6] {
    let at = |x: f64, y: f64| {
        let point = frame_from_pose * Point3::from(Vector3::new(x, y, 0.0) * length_m);
        point.cast::<f32>().into()
    };
    let tip = at(1.0, 0.0);
    [at(0.0, 0.0), tip, tip, at(0.75, 0.2), tip, at(0.75, -0.2)]
}
