//! `rviz/Path`: a line through poses, with axes or arrows at them.
//!
//! A path stays where its frame was at its stamp. Its opacity has no effect: rviz sets the colour's alpha, but its
//! line's material replaces the background.

use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, Vector3};
use rcs_messages::geometry_msgs::PoseStamped;
use rcs_messages::nav_msgs::Path;
use rcs_messages::PlainTransform;
use rcs_rviz_config::{LineStyle, PathSettings, PoseStyle};
use rcs_scene::{Blending, DisplayId, Drawable, Geometry, LineTopology, Lines, Rgba, RibbonElement, Ribbons};

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::isometry;
use crate::parts::pose_symbol::{all_axes, arrows};
use crate::parts::solids::{arrow_pose, drawable, ArrowSize};

#[derive(Debug)]
pub(crate) struct PathVisual {
    display: DisplayId,
    settings: PathSettings,
}

pub(crate) fn create(display: DisplayId, settings: &PathSettings) -> MessageDisplay<PathVisual> {
    let visual = PathVisual { display, settings: settings.clone() };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(settings.buffer_length), visual)
}

impl PathVisual {
    /// Poses in the fixed frame with the display's offset; `None` where a number is NaN or infinite.
    fn poses(&self, path: &Path, fixed_from_path: &Isometry3<f64>) -> Option<Vec<Isometry3<f64>>> {
        let offset = Translation3::from(Vector3::from(self.settings.offset_m).cast::<f64>());
        let poses = path.poses.iter().map(|stamped| {
            let path_from_pose = isometry(&PlainTransform::from(&stamped.pose))?;
            Some(offset * fixed_from_path * path_from_pose)
        });
        poses.collect()
    }

    fn line(&self, poses: &[Isometry3<f64>]) -> Drawable {
        let color = Rgba::from_rgb8(self.settings.color, self.settings.alpha).to_rgba8();
        // Positions are kept relative to the first pose, so that single precision does for a path far away.
        let origin = poses.first().map_or_else(Vector3::zeros, |pose| pose.translation.vector);
        let positions = poses.iter().map(|pose| (pose.translation.vector - origin).cast::<f32>().into());
        let geometry = match self.settings.line_style {
            LineStyle::Lines => Geometry::Lines(Arc::new(Lines {
                positions: positions.collect(),
                colors: vec![color],
                topology: LineTopology::Strip,
                blending: Blending::Replace,
            })),
            LineStyle::Billboards => Geometry::Ribbons(Arc::new(Ribbons {
                chains: vec![positions.map(|position| RibbonElement { position, color }).collect()],
                width_m: self.settings.line_width_m,
                blending: Blending::Replace,
            })),
        };
        drawable(self.display, Translation3::from(origin).to_homogeneous(), geometry)
    }

    fn symbols(&self, path: &Path, poses: &[Isometry3<f64>]) -> Vec<Drawable> {
        let settings = &self.settings;
        match settings.pose_style {
            PoseStyle::None => Vec::new(),
            PoseStyle::Axes => {
                let (length_m, diameter_m) = (settings.axes_length_m.into(), settings.axes_radius_m.into());
                all_axes(self.display, length_m, diameter_m, poses.iter().copied())
            }
            PoseStyle::Arrows => {
                let arrow = &settings.arrow;
                let color = Rgba::from_rgb8(arrow.color, 1.0);
                let size = ArrowSize {
                    shaft_length_m: arrow.shaft_length_m.into(),
                    shaft_diameter_m: arrow.shaft_diameter_m.into(),
                    head_length_m: arrow.head_length_m.into(),
                    head_diameter_m: arrow.head_diameter_m.into(),
                };
                let pose = |(pose, stamped): (&Isometry3<f64>, &PoseStamped)| {
                    arrow_pose(pose.translation.vector, &direction(pose, &PlainTransform::from(&stamped.pose)))
                };
                arrows(self.display, &size, color, poses.iter().zip(&path.poses).map(pose))
            }
        }
    }
}

/// Direction of an arrow: the pose's x, except that rviz rotates by the quaternion as it is. One that is too long turns
/// too far, one that is too short not far enough.
fn direction(fixed_from_pose: &Isometry3<f64>, path_from_pose: &PlainTransform) -> Vector3<f64> {
    let squared: f64 = path_from_pose.rotation_xyzw.iter().map(|part| part * part).sum();
    let turned = fixed_from_pose.rotation * Vector3::x();
    Vector3::x() + (turned - Vector3::x()) * squared
}

fn is_line(drawable: &Drawable) -> bool {
    matches!(drawable.geometry, Geometry::Lines(_) | Geometry::Ribbons(_))
}

impl MessageVisual for PathVisual {
    type Message = Path;
    const STATUS: &'static str = "Message";

    fn draw(&mut self, path: &Path, fixed_from_path: &Isometry3<f64>) -> DrawResult {
        let poses = self.poses(path, fixed_from_path).ok_or(InvalidFloats)?;
        Ok(Some(std::iter::once(self.line(&poses)).chain(self.symbols(path, &poses)).collect()))
    }

    /// rviz clears the line that the path replaces before it looks at the numbers, the symbols after.
    fn instead(&self, next_to_go: &[Drawable]) -> Option<Vec<Drawable>> {
        Some(next_to_go.iter().filter(|drawable| !is_line(drawable)).cloned().collect())
    }
}
