//! Arguments of the node's windows.

use std::convert::Infallible;
use std::str::FromStr;

use clap::Args;
use rcs_window::MonitorChoice;

/// Which cameras are shown on monitors by the node itself.
#[derive(Args, Clone, Debug, Default)]
pub struct ScreenArgs {
    /// Show the picture full screen on a monitor, by name, number in the list of projector_window --list-monitors, or
    /// auto (the last that is not primary); with CAMERA= where the config has several cameras; may be given several
    /// times
    #[arg(long = "window", value_name = "[CAMERA=]MONITOR")]
    pub windows: Vec<CameraWindow>,
    /// Set a monitor that runs another mode to its native one
    #[arg(long)]
    pub set_mode: bool,
}

/// A window for one camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CameraWindow {
    /// The camera's name; `None` for the only one.
    pub camera: Option<String>,
    /// Where it is shown; `None` for nowhere.
    pub monitor: Option<MonitorChoice>,
}

impl FromStr for CameraWindow {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        let (camera, monitor) = match text.rsplit_once('=') {
            Some((camera, monitor)) => (Some(camera.trim().to_owned()), monitor.trim()),
            None => (None, text.trim()),
        };
        let monitor = match monitor {
            "" | "none" => None,
            monitor => Some(monitor.parse()?),
        };
        Ok(Self { camera, monitor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_is_a_monitor_with_or_without_its_camera() {
        let read = |text: &str| text.parse::<CameraWindow>().unwrap();
        let hdmi = MonitorChoice::NameOrIndex("HDMI-1".to_owned());
        assert_eq!(read("HDMI-1"), CameraWindow { camera: None, monitor: Some(hdmi.clone()) });
        assert_eq!(read("a=b=HDMI-1"), CameraWindow { camera: Some("a=b".to_owned()), monitor: Some(hdmi) });
        assert_eq!(read("auto").monitor, Some(MonitorChoice::Secondary));
        assert_eq!((read("").monitor, read("Left=none").monitor), (None, None));
    }
}
