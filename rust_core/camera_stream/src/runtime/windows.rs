//! The node's windows, each of which shows one camera.

use std::sync::Arc;

use anyhow::{bail, Context, Result};
use rcs_ros::RosNode;
use rcs_window::{WindowOptions, WindowRole};

use crate::camera::plan::CameraPlan;
use crate::control::Control;
use crate::options::Options;
use crate::outputs::{WindowOutput, WindowThread};
use crate::safety::names::ForCamera;
use crate::safety::Safety;

/// The windows of all cameras. Closes them when dropped.
#[derive(Default)]
pub(crate) struct Windows(Vec<OpenWindow>);

struct OpenWindow {
    camera: String,
    output: WindowOutput,
    _thread: WindowThread,
}

impl Windows {
    /// Opens the windows for the cameras of a config.
    ///
    /// # Errors
    /// One line: no such camera, two windows for one camera, or several cameras and no name.
    pub(crate) fn open(
        ros: &RosNode,
        control: &Arc<Control>,
        options: &Options,
        safety: &Safety,
        plans: &[CameraPlan],
    ) -> Result<Self> {
        let names: Vec<_> = plans.iter().map(CameraPlan::name).collect();
        let mut windows = Self::default();
        for ForCamera { camera: wanted, value: monitor } in options.windows.iter().cloned() {
            let camera = camera(wanted, &names)?;
            if windows.0.iter().any(|window| window.camera == camera) {
                bail!("window: camera {camera} has two");
            }
            let source = format!("camera {camera}");
            let (set_mode, light_limit) = (options.node.windows.set_mode, Some(safety.light_limit(&camera)));
            let role = WindowRole::Guarded;
            let options = WindowOptions { source, monitor, set_mode, light_limit, role, ..WindowOptions::default() };
            windows.0.push(OpenWindow::open(ros, control, camera, options)?);
        }
        Ok(windows)
    }

    /// The window of a camera.
    pub(crate) fn of(&self, camera: &str) -> Option<WindowOutput> {
        self.0.iter().find(|window| window.camera == camera).map(|window| window.output.clone())
    }

    /// Blacks out windows whose cameras another config does not have.
    pub(crate) fn clear_those_without(&self, plans: &[CameraPlan]) {
        for window in self.0.iter().filter(|window| !plans.iter().any(|plan| plan.name() == window.camera)) {
            log::warn!("camera {} is not in the config any more: its window is black", window.camera);
            window.output.clear();
        }
    }
}

impl OpenWindow {
    fn open(ros: &RosNode, control: &Arc<Control>, camera: String, options: WindowOptions) -> Result<Self> {
        let (events, control, pressed) = (Arc::clone(ros.events()), Arc::clone(control), camera.clone());
        let press = move |key| control.press(&pressed, key);
        let opened = WindowOutput::open(options, move || events.wake(), press);
        let (output, thread) = opened.context("cannot open a window")?;
        Ok(Self { camera, output, _thread: thread })
    }
}

/// The camera of a window.
fn camera(wanted: Option<String>, cameras: &[&str]) -> Result<String> {
    match (wanted, cameras) {
        (Some(wanted), _) if cameras.contains(&&*wanted) => Ok(wanted),
        (Some(wanted), _) => bail!("window: camera {wanted} is not enabled; enabled: {}", cameras.join(", ")),
        (None, [camera]) => Ok((*camera).to_owned()),
        (None, []) => bail!("window: the config has no enabled camera"),
        (None, _) => bail!("window: name one of the cameras, CAMERA=MONITOR; cameras: {}", cameras.join(", ")),
    }
}
