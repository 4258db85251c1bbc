//! Frames of displays: following a reference frame (Grid, Axes), and rviz's status texts for frames that cannot be
//! found.

use nalgebra::Isometry3;
use rcs_transforms::{DropReason, Dropped, LookupError, LookupProblem, WaitingQueue};

use crate::framework::status::StatusText;
use crate::{Level, Statuses, World};

/// Pose of a reference frame (`None` is the fixed frame). While it cannot be found, its last pose stays, as in rviz;
/// before it was ever found, that is the fixed frame's origin.
pub(crate) fn follow(
    reference_frame: Option<&str>,
    world: &World<'_>,
    last: Option<Isometry3<f64>>,
    statuses: &mut Statuses,
) -> Isometry3<f64> {
    let frame = reference_frame.unwrap_or(world.fixed_frame);
    match world.fixed_from_moving(frame) {
        Ok(place) => {
            statuses.set(Level::Ok, Statuses::TRANSFORM, "Transform OK");
            place
        }
        Err(error) => {
            statuses.set(Level::Error, Statuses::TRANSFORM, problem(&error, world.fixed_frame));
            last.unwrap_or_default()
        }
    }
}

/// rviz's status text for a failed lookup; a frame that does not exist at all comes first.
pub(crate) fn problem(error: &LookupError, fixed_frame: &str) -> StatusText {
    let LookupError { source: frame, problem, .. } = error;
    let reason = match problem {
        LookupProblem::MissingFrame(missing) if missing == fixed_frame => {
            format!("Fixed Frame [{missing}] does not exist")
        }
        LookupProblem::MissingFrame(missing) => format!("Frame [{missing}] does not exist"),
        LookupProblem::EmptyName => "Frame [] does not exist".to_owned(),
        _ => format!("No transform to fixed frame [{fixed_frame}].  TF error: [{error}]"),
    };
    StatusText::about_frame(format!("For frame [{frame}]: {reason}"))
}

/// Sets the status of the newest waiting message of a queue, or removes it.
pub(crate) fn report_waiting<M>(queue: &WaitingQueue<M>, world: &World<'_>, statuses: &mut Statuses) {
    match queue.waiting_reason(world.transforms, world.fixed_frame) {
        Some(reason) => statuses.set(Level::Warn, Statuses::TRANSFORM, problem(&reason, world.fixed_frame)),
        None => statuses.remove(Statuses::TRANSFORM),
    }
}

/// rviz's status text for a cloud whose frame cannot be found at its stamp.
pub(crate) fn transform_failed(frame: &str, world: &World<'_>) -> StatusText {
    StatusText::about_frame(format!("Failed to transform from frame [{frame}] to frame [{}]", world.fixed_frame))
}

/// rviz's status text for a dropped message.
pub(crate) fn drop_reason(dropped: &Dropped, fixed_frame: &str) -> StatusText {
    let Dropped { frame, stamp, reason } = dropped;
    match reason {
        DropReason::TooOld { .. } => {
            format!("Message removed because it is too old (frame=[{frame}], stamp=[{stamp}])").into()
        }
        DropReason::QueueFull(Some(reason)) => problem(reason, fixed_frame),
        DropReason::EmptyFrame => StatusText::about_frame("For frame []: Frame [] does not exist".to_owned()),
        // Its frame was never looked up, as newer messages came too fast.
        DropReason::QueueFull(None) => "Unknown reason for transform failure".into(),
    }
}
