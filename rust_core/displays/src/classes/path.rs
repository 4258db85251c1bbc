//! `rviz/Path`: a line through poses, with axes or arrows at them.
//!
//! A path stays where its frame was at its stamp. Its opacity has no effect: rviz sets the colour's alpha, but its
//! line's material replaces the background.

use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, Vector3};
use rcs_messages::geometry_msgs::PoseStamped;
use rcs_messages::nav_msgs::Path;
use rcs_messages::{AnyMessage, MessageKind, PlainTransform};
use rcs_rviz_config::{LineStyle, PathSettings, PoseStyle};
use rcs_scene::{Blending, DisplayId, Drawable, Geometry, LineTopology, Lines, Rgba, RibbonElement, Ribbons};
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::message_display::InvalidFloats;
use crate::framework::waiting_messages::WaitingMessages;
use crate::framework::world::isometry;
use crate::parts::history::MessageHistory;
use crate::parts::pose_symbol::{all_axes, arrows};
use crate::parts::solids::{arrow_pose, drawable, ArrowSize};
use crate::{Level, Statuses, World};

#[derive(Debug)]
pub(crate) struct PathDisplay {
    display: DisplayId,
    settings: PathSettings,
    incoming: WaitingMessages<Path>,
    history: MessageHistory,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &PathSettings) -> PathDisplay {
    PathDisplay {
        display,
        incoming: WaitingMessages::new(settings.queue_size),
        history: MessageHistory::new(Some(settings.buffer_length)),
        settings: settings.clone(),
        statuses: Statuses::default(),
    }
}

impl PathDisplay {
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

impl Display for PathDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        TopicRequest::new(&self.settings.topic, MessageKind::Path, self.settings.queue_size).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        if let AnyMessage::Path(path) = message {
            self.incoming.push(&path.header, path.clone(), &mut self.statuses);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.incoming.is_waiting(stamp)
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let ready = self.incoming.take_ready(world, &mut self.statuses);
        let mut changed = false;
        for path in ready {
            let Ok(fixed_from_path) = world.fixed_from_header(&path.header) else { continue };
            let drawn: Vec<Drawable> = match self.poses(&path, &fixed_from_path) {
                Some(poses) => {
                    self.statuses.remove("Message");
                    std::iter::once(self.line(&poses)).chain(self.symbols(&path, &poses)).collect()
                }
                None => {
                    self.statuses.set(Level::Error, "Message", InvalidFloats.to_string());
                    // rviz clears the line that the path replaces before it looks at the numbers, the symbols after.
                    self.history.next_to_go().iter().filter(|drawable| !is_line(drawable)).cloned().collect()
                }
            };
            self.history.push(drawn);
            changed = true;
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        self.history.drawables()
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.history.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
