//! The completed markers of one message, until they are in the fixed frame.
//!
//! A marker with a stamp is moved to the fixed frame as soon as its frame is known at that time; one without only waits
//! until its frame is known at all, and follows it later. A message is shown as a whole, when nothing in it waits.

use rcs_messages::geometry_msgs::Pose;
use rcs_messages::std_msgs::Header;
use rcs_messages::visualization_msgs::{
    InteractiveMarker, InteractiveMarkerInit, InteractiveMarkerPose, InteractiveMarkerUpdate,
};
use rcs_messages::PlainTransform;
use rcs_transforms::LookupProblem;

use super::complete::{complete, set_orientation};
use crate::framework::world::{isometry, stamp};
use crate::World;

#[derive(Clone, Debug)]
pub(super) struct MarkerBatch {
    pub(super) sequence: u64,
    pub(super) markers: Vec<InteractiveMarker>,
    pub(super) poses: Vec<InteractiveMarkerPose>,
    pub(super) erases: Vec<String>,
    /// Indices of the markers and poses whose frames are not known yet.
    waiting_markers: Vec<usize>,
    waiting_poses: Vec<usize>,
}

impl MarkerBatch {
    fn new(
        sequence: u64,
        mut markers: Vec<InteractiveMarker>,
        mut poses: Vec<InteractiveMarkerPose>,
        erases: Vec<String>,
        translucent: bool,
    ) -> Self {
        for marker in &mut markers {
            complete(marker, translucent);
        }
        for pose in &mut poses {
            set_orientation(&mut pose.pose.orientation);
        }
        let (waiting_markers, waiting_poses) = ((0..markers.len()).collect(), (0..poses.len()).collect());
        Self { sequence, markers, poses, erases, waiting_markers, waiting_poses }
    }

    pub(super) fn of_init(init: &InteractiveMarkerInit, translucent: bool) -> Self {
        Self::new(init.seq_num, init.markers.clone(), Vec::new(), Vec::new(), translucent)
    }

    pub(super) fn of_update(update: &InteractiveMarkerUpdate, translucent: bool) -> Self {
        let (markers, poses) = (update.markers.clone(), update.poses.clone());
        Self::new(update.seq_num, markers, poses, update.erases.clone(), translucent)
    }

    pub(super) fn is_ready(&self) -> bool {
        self.waiting_markers.is_empty() && self.waiting_poses.is_empty()
    }

    /// Moves the markers and poses whose frames are known to the fixed frame.
    ///
    /// # Errors
    /// Reason why waiting will not help.
    pub(super) fn place(&mut self, world: &World<'_>) -> Result<(), String> {
        let markers = &mut self.markers;
        retain_waiting(&mut self.waiting_markers, |index| match markers.get_mut(index) {
            Some(marker) => place_marker(marker, world),
            None => Ok(true),
        })?;
        let poses = &mut self.poses;
        retain_waiting(&mut self.waiting_poses, |index| match poses.get_mut(index) {
            Some(pose) => place(&mut pose.header, &mut pose.pose, world),
            None => Ok(true),
        })
    }
}

/// Removes the indices that are placed; those from the first error on stay.
fn retain_waiting(
    waiting: &mut Vec<usize>,
    mut place: impl FnMut(usize) -> Result<bool, String>,
) -> Result<(), String> {
    let mut result = Ok(());
    waiting.retain(|&index| {
        if result.is_err() {
            return true;
        }
        match place(index) {
            Ok(is_placed) => !is_placed,
            Err(error) => {
                result = Err(error);
                true
            }
        }
    });
    result
}

fn place_marker(marker: &mut InteractiveMarker, world: &World<'_>) -> Result<bool, String> {
    let mut is_placed = place(&mut marker.header, &mut marker.pose, world)?;
    for part in marker.controls.iter_mut().flat_map(|control| &mut control.markers) {
        if !part.header.frame_id.is_empty() {
            is_placed = is_placed && place(&mut part.header, &mut part.pose, world)?;
        }
    }
    Ok(is_placed)
}

/// Returns whether a frame is known at its stamp; with a stamp, the pose then moves to the fixed frame.
fn place(header: &mut Header, pose: &mut Pose, world: &World<'_>) -> Result<bool, String> {
    if header.frame_id == world.fixed_frame {
        return Ok(true);
    }
    match world.fixed_from_header(header) {
        Ok(fixed_from_frame) => {
            if !stamp(header).is_zero() {
                // A pose that is not finite stays so, and is refused where it would be shown.
                if let Some(frame_from_pose) = isometry(&PlainTransform::from(&*pose)) {
                    set_pose(pose, &(fixed_from_frame * frame_from_pose));
                }
                world.fixed_frame.clone_into(&mut header.frame_id);
            }
            Ok(true)
        }
        Err(error) if matches!(error.problem, LookupProblem::Extrapolation { .. }) => {
            let latest = world.transforms.latest_common_time(world.fixed_frame, &header.frame_id);
            // Transforms come in the order of time, so an old one will not come any more.
            if latest.is_ok_and(|latest| !latest.is_zero() && latest > stamp(header)) {
                return Err(format!("the stamp is too old: {error}"));
            }
            Ok(false)
        }
        Err(error) => Err(error.to_string()),
    }
}

fn set_pose(pose: &mut Pose, value: &nalgebra::Isometry3<f64>) {
    let (position, rotation) = (value.translation.vector, value.rotation.coords);
    (pose.position.x, pose.position.y, pose.position.z) = (position.x, position.y, position.z);
    let orientation = &mut pose.orientation;
    (orientation.x, orientation.y, orientation.z, orientation.w) = (rotation.x, rotation.y, rotation.z, rotation.w);
}
