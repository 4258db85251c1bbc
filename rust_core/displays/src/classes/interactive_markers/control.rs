//! A control of an interactive marker: its markers, and how they turn with the marker, the frame or the camera.

use nalgebra::{Isometry3, Matrix4, UnitQuaternion, Vector3};
use rcs_messages::std_msgs::Header;
use rcs_messages::visualization_msgs::{InteractiveMarkerControl, Marker};
use rcs_messages::{quaternion_xyzw, PlainTransform};
use rcs_scene::{DisplayId, Drawable, Facing, FacingPart};
use rcs_transforms::Time;

use crate::classes::marker::{ControlMarker, NotShown, SortPoint};
use crate::framework::world::stamp;
use crate::World;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    WithMarker,
    WithFrame,
    /// To the camera: these axes of the control point forward and up on the image.
    ToCamera {
        forward: Vector3<f64>,
        up: Vector3<f64>,
    },
}

#[derive(Clone, Debug)]
pub(super) struct PlacedControl {
    pub(super) always_visible: bool,
    turn: Turn,
    /// Markers with poses in the control's frame.
    markers: Vec<ControlMarker>,
}

impl PlacedControl {
    /// Builds a completed control. A marker with a frame of its own is placed there and then moves with the control;
    /// those whose files are missing are added to `missing`.
    pub(super) fn new(
        control: &InteractiveMarkerControl,
        reference_from_marker: &Isometry3<f64>,
        fixed_from_reference: &Isometry3<f64>,
        world: &World<'_>,
        missing: &mut Vec<NotShown>,
    ) -> Self {
        let inherits = control.orientation_mode == InteractiveMarkerControl::INHERIT;
        let rotation = if inherits { reference_from_marker.rotation } else { UnitQuaternion::identity() };
        let fixed_from_control =
            fixed_from_reference * Isometry3::from_parts(reference_from_marker.translation, rotation);
        let place = |marker: &Marker| {
            let (mut parts, not_shown) = ControlMarker::of(marker, world.meshes)?;
            missing.extend(not_shown);
            if !marker.header.frame_id.is_empty() {
                let frame = &marker.header.frame_id;
                let fixed_from_frame = match time(marker, world) {
                    // Like the frame of the interactive marker.
                    time if time.is_zero() => world.fixed_from_now(frame).ok()?,
                    time => world.fixed_from(frame, time).ok()?,
                };
                let fixed_from_marker = fixed_from_frame * parts.frame_from_marker;
                parts.frame_from_marker = fixed_from_control.inv_mul(&fixed_from_marker);
            }
            Some(parts)
        };
        let markers = control.markers.iter().filter_map(place).collect();
        Self { always_visible: control.always_visible, turn: turn(control), markers }
    }

    /// Rebuilds markers whose meshes were missing, and adds those that still are to `missing`. Returns whether there
    /// were any.
    pub(super) fn rebuild(&mut self, world: &World<'_>, missing: &mut Vec<NotShown>) -> bool {
        let mut had_missing = false;
        for marker in self.markers.iter_mut().filter(|marker| marker.is_missing()) {
            had_missing = true;
            missing.extend(marker.rebuild(world.meshes));
        }
        had_missing
    }

    pub(super) fn drawables(
        &self,
        display: DisplayId,
        reference_from_marker: &Isometry3<f64>,
        fixed_from_reference: &Isometry3<f64>,
    ) -> Vec<Drawable> {
        let fixed_from_marker = fixed_from_reference * reference_from_marker;
        let rotation = match self.turn {
            Turn::WithMarker => fixed_from_marker.rotation,
            Turn::WithFrame => fixed_from_reference.rotation,
            Turn::ToCamera { forward, up } => {
                let parts = self.markers.iter().flat_map(facing_parts).collect();
                let place = fixed_from_marker.translation.vector;
                return vec![Facing { forward, up, parts }.into_drawable(display, place)];
            }
        };
        let fixed_from_control = Isometry3::from_parts(fixed_from_marker.translation, rotation);
        let placed = |marker: &ControlMarker| {
            let fixed_from_marker = fixed_from_control * marker.frame_from_marker;
            marker.parts.iter().map(|part| part.placed(display, &fixed_from_marker)).collect::<Vec<_>>()
        };
        self.markers.iter().flat_map(placed).collect()
    }
}

fn turn(control: &InteractiveMarkerControl) -> Turn {
    match control.orientation_mode {
        InteractiveMarkerControl::INHERIT => Turn::WithMarker,
        InteractiveMarkerControl::VIEW_FACING if control.independent_marker_orientation => Turn::WithMarker,
        InteractiveMarkerControl::VIEW_FACING => {
            let pose = PlainTransform { translation: [0.0; 3], rotation_xyzw: quaternion_xyzw(&control.orientation) };
            let rotation = crate::framework::world::isometry(&pose).unwrap_or_default().rotation;
            Turn::ToCamera { forward: rotation * Vector3::x(), up: rotation * Vector3::z() }
        }
        _ => Turn::WithFrame,
    }
}

/// The time at which a marker's own frame is looked up. A marker with a stamp is in the fixed frame already.
fn time(marker: &Marker, world: &World<'_>) -> Time {
    let Header { frame_id, .. } = &marker.header;
    if marker.frame_locked || frame_id == world.fixed_frame {
        return Time::ZERO;
    }
    stamp(&marker.header)
}

fn facing_parts(marker: &ControlMarker) -> impl Iterator<Item = FacingPart> + '_ {
    let group_from_marker: Matrix4<f64> = marker.frame_from_marker.to_homogeneous();
    marker.parts.iter().map(move |part| FacingPart {
        group_from_part: group_from_marker * part.marker_from_part,
        sort_point: match part.sort_point {
            SortPoint::Origin => None,
            SortPoint::Fixed(point) => Some(point),
        },
        geometry: part.geometry.clone(),
    })
}
