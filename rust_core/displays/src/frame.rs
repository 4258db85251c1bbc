//! Displays that stand in a frame and follow it: Grid and Axes.

use nalgebra::Isometry3;
use rcs_transforms::Time;

use crate::{Level, Statuses, World};

/// Where a reference frame (`None` is the fixed frame) is now. While it cannot be found, the place where it was last
/// stays: rviz leaves such a display where it is. Before it was ever found, that is the fixed frame's origin.
pub(crate) fn follow(
    reference_frame: Option<&str>,
    world: &World<'_>,
    last: Option<Isometry3<f64>>,
    statuses: &mut Statuses,
) -> Option<Isometry3<f64>> {
    let frame = reference_frame.unwrap_or(world.fixed_frame);
    match world.fixed_from(frame, Time::ZERO) {
        Ok(place) => {
            statuses.set(Level::Ok, "Transform", "Transform OK");
            Some(place)
        }
        Err(error) => {
            statuses.set(Level::Error, "Transform", error.to_string());
            last.or_else(|| Some(Isometry3::identity()))
        }
    }
}
