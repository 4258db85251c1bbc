//! Arguments of the node's windows.

use clap::Args;
use rcs_window::MonitorChoice;

use rcs_node_support::key_value::split_at_known;

/// Which cameras are shown on monitors by the node itself.
#[derive(Args, Clone, Debug, Default)]
pub struct ScreenArgs {
    /// Show the picture full screen on a monitor, by name, number in the list of projector_window --list-monitors, or
    /// auto (the last that is not primary); with CAMERA= where the config has several cameras; may be given several
    /// times
    #[arg(long = "window", value_name = "[CAMERA=]MONITOR")]
    pub windows: Vec<String>,
    /// Set a monitor that runs another mode to its native one
    #[arg(long)]
    pub set_mode: bool,
}

/// A window for one camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CameraWindow {
    /// The camera's name; `None` for the only one.
    pub(crate) camera: Option<String>,
    /// Where it is shown; `None` for nowhere.
    pub(crate) monitor: Option<MonitorChoice>,
}

impl CameraWindow {
    /// Reads `CAMERA=MONITOR` or `MONITOR`, where the cameras are those of the config.
    ///
    /// # Errors
    /// The name of a camera that is none of these.
    pub(crate) fn read(text: &str, cameras: &[&str]) -> Result<Self, String> {
        let (camera, monitor) = match (split_at_known(text, cameras.iter().copied()), text.split_once('=')) {
            (Some((camera, monitor)), _) => (Some(camera.to_owned()), monitor),
            (None, Some((unknown, _))) => return Err(unknown.trim().to_owned()),
            (None, None) => (None, text.trim()),
        };
        let monitor = match monitor {
            "" | "none" => None,
            monitor => monitor.parse().ok(),
        };
        Ok(Self { camera, monitor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_is_a_monitor_with_or_without_its_camera() {
        let read = |text: &str| CameraWindow::read(text, &["a", "a=b", "Left"]).unwrap();
        let hdmi = MonitorChoice::NameOrIndex("HDMI-1".to_owned());
        assert_eq!(read("HDMI-1"), CameraWindow { camera: None, monitor: Some(hdmi.clone()) });
        assert_eq!(read("a=b=HDMI-1"), CameraWindow { camera: Some("a=b".to_owned()), monitor: Some(hdmi) });
        assert_eq!(read("auto").monitor, Some(MonitorChoice::Secondary));
        assert_eq!((read("").monitor, read("Left=none").monitor), (None, None));
        assert_eq!(CameraWindow::read("Lef=HDMI-1", &["Left"]), Err("Lef".to_owned()));
    }
}
