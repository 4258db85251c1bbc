//! The node's windows, each of which shows one camera.

use std::sync::Arc;
use std::time::Duration;

use anyhow::{bail, Context, Result};
use rcs_ros::RosNode;
use rcs_window::WindowOptions;

use super::camera_plan::CameraPlan;
use crate::camera_stream::outputs::{WindowOutput, WindowThread};
use crate::camera_stream::private_parameters;
use crate::camera_stream::window_arguments::ScreenArgs;

/// A window becomes black after this at the earliest when the node stops: it is told less often that all is well.
const LEAST_STALE_TIMEOUT: Duration = Duration::from_secs(1);

/// The windows, as long as the node runs. Dropped, it closes them.
#[derive(Default)]
pub(super) struct Windows(Vec<Window>);

struct Window {
    camera: String,
    output: WindowOutput,
    _thread: WindowThread,
}

impl Windows {
    /// Opens those of `--window` and `~window` for the cameras of a config. They become black when the node has neither
    /// drawn nor confirmed a picture for `stale_timeout`.
    ///
    /// # Errors
    /// One line that names what is wrong: no such camera, or a window for none of several.
    pub(super) fn open(
        ros: &RosNode,
        given: &ScreenArgs,
        stale_timeout: Option<Duration>,
        plans: &[CameraPlan],
    ) -> Result<Self> {
        // The scene's thread confirms pictures at least twice a second.
        let stale_timeout = stale_timeout.map(|timeout| timeout.max(LEAST_STALE_TIMEOUT));
        let args = private_parameters::windows(ros, given)?;
        let mut windows = Self::default();
        for wanted in args.windows {
            let Some(monitor) = wanted.monitor else { continue };
            let camera = camera(wanted.camera.as_deref(), plans)?;
            if windows.0.iter().any(|window| window.camera == camera) {
                bail!("--window: camera {camera} has two windows");
            }
            let source = format!("camera {camera}");
            let options =
                WindowOptions { source, monitor, set_mode: args.set_mode, stale_timeout, ..WindowOptions::default() };
            windows.0.push(Window::open(ros, camera, options)?);
        }
        Ok(windows)
    }

    /// The window of a camera.
    pub(super) fn of(&self, camera: &str) -> Option<WindowOutput> {
        self.0.iter().find(|window| window.camera == camera).map(|window| window.output.clone())
    }

    /// Makes the windows black whose cameras another config does not have.
    pub(super) fn clear_those_without(&self, plans: &[CameraPlan]) {
        for window in self.0.iter().filter(|window| !plans.iter().any(|plan| plan.name() == window.camera)) {
            log::warn!("camera {} is not in the config any more: its window is black", window.camera);
            window.output.clear();
        }
    }
}

impl Window {
    fn open(ros: &RosNode, camera: String, options: WindowOptions) -> Result<Self> {
        let events = Arc::clone(ros.events());
        let (output, thread) = WindowOutput::open(options, move || events.wake()).context("cannot open a window")?;
        Ok(Self { camera, output, _thread: thread })
    }
}

/// The camera that a window is for.
fn camera(wanted: Option<&str>, plans: &[CameraPlan]) -> Result<String> {
    let names = || plans.iter().map(CameraPlan::name).collect::<Vec<_>>().join(", ");
    match (wanted, plans) {
        (Some(wanted), plans) => match plans.iter().find(|plan| plan.name() == wanted) {
            Some(plan) => Ok(plan.name().to_owned()),
            None => bail!("--window: the config has no enabled camera {wanted}; there are: {}", names()),
        },
        (None, [plan]) => Ok(plan.name().to_owned()),
        (None, []) => bail!("--window: the config has no enabled camera"),
        (None, _) => bail!("--window: which camera? Give CAMERA=MONITOR; there are: {}", names()),
    }
}
