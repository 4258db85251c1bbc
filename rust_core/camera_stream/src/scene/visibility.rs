//! Status of displays that cameras do not show: because their Visibility hides them, or because they are out of view.
//!
//! A projector that stays black is often one of the two. The config asks for hidden displays, so that is no problem; a
//! display that is not empty and is in view of no camera that would show it gets a warning.

use rcs_displays::{CameraView, InView, Level, SceneState};
use rcs_scene::{Camera, DisplayId};

use crate::scene::status_tree::StatusEntry;

pub(crate) const VISIBILITY: &str = "Visibility";

/// A camera of the config, and its pose now; `None` while that is unknown.
#[derive(Debug)]
pub(crate) struct PlacedCamera<'a> {
    pub(crate) view: &'a CameraView,
    pub(crate) camera: Option<Camera>,
}

/// Adds the status to displays that some camera hides or does not have in view.
pub(crate) fn add(entries: &mut [StatusEntry<'_>], displays: &SceneState, cameras: &[PlacedCamera<'_>]) {
    for entry in entries {
        let Some(display) = entry.display else { continue };
        if let Some((level, text)) = status(display, displays, cameras) {
            entry.statuses.to_mut().set(level, VISIBILITY, text);
        }
    }
}

/// The status of a display; `None` where every camera may show it.
fn status(display: DisplayId, displays: &SceneState, cameras: &[PlacedCamera<'_>]) -> Option<(Level, String)> {
    let (showing, hiding): (Vec<_>, Vec<_>) = cameras.iter().partition(|camera| camera.view.visible.shows(display));
    let is_outside = |placed: &&&PlacedCamera<'_>| {
        placed.camera.as_ref().is_some_and(|camera| displays.in_view(display, camera) == InView::Outside)
    };
    let outside: Vec<&PlacedCamera<'_>> = showing.iter().filter(is_outside).copied().collect();
    let text = |before: &str, cameras: &[&PlacedCamera<'_>]| {
        let names: Vec<&str> = cameras.iter().map(|camera| camera.view.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("{before} {}", names.join(", ")))
    };
    let texts = [text("hidden in camera", &hiding), text("outside the view of camera", &outside)];
    let text = texts.into_iter().flatten().reduce(|all, text| format!("{all}; {text}"))?;
    let is_in_no_view = !outside.is_empty() && outside.len() == showing.len();
    Some((if is_in_no_view { Level::Warn } else { Level::Ok }, text))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion, Vector3};
    use rcs_resources::{MeshStore, PackageIndex};
    use rcs_scene::Intrinsics;
    use rcs_transforms::Time;

    use super::*;

    const CONFIG: &str = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz/Grid, Name: grid, Enabled: true}
  - {Class: rviz/Path, Name: path, Enabled: true, Topic: /path}
  - {Class: rviz_camera_stream/CameraPub, Name: Left, Enabled: true, Image Topic: /l, Visibility: {Value: true, grid: false}}
  - {Class: rviz_camera_stream/CameraPub, Name: Right, Enabled: true, Image Topic: /r, Visibility: {Value: true}}
";

    /// Ten metres above the grid, looking down; turned by this angle about its x axis.
    fn camera(turned: f64) -> Camera {
        let p = [50.0, 0.0, 50.0, 0.0, 0.0, 50.0, 50.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let looking_down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI + turned);
        let pose = Isometry3::from_parts(Vector3::new(0.0, 0.0, 10.0).into(), looking_down);
        Camera::new(Intrinsics::from_p(100, 100, &p).unwrap(), &pose, 0.01)
    }

    #[test]
    fn hidden_and_out_of_view_displays_are_reported_for_each_camera() {
        let config = rcs_rviz_config::parse(CONFIG, "test").unwrap();
        let mut displays = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])));
        displays.update(Time::ZERO);
        let ids: Vec<DisplayId> = displays.reports().map(|report| report.id).collect();
        let report = |id: DisplayId, left: Option<f64>, right: Option<f64>| {
            let cameras = displays.cameras().iter().zip([left, right]);
            let cameras: Vec<_> =
                cameras.map(|(view, turned)| PlacedCamera { view, camera: turned.map(camera) }).collect();
            status(id, &displays, &cameras)
        };
        let (down, away) = (Some(0.0), Some(std::f64::consts::PI));
        let hidden = "hidden in camera Left";
        assert_eq!(report(ids[0], down, down), Some((Level::Ok, hidden.to_owned())));
        assert_eq!(report(ids[0], away, None), Some((Level::Ok, hidden.to_owned())), "an unknown pose is no view");
        let both = format!("{hidden}; outside the view of camera Right");
        assert_eq!(report(ids[0], down, away), Some((Level::Warn, both)));
        assert_eq!(report(ids[1], away, away), None, "an empty display is in no view and outside of none");
    }
}
