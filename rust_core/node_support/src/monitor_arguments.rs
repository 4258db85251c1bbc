//! The arguments of all programs with a full-screen window.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use rcs_window::{self as window, list_lines, MonitorChoice, WindowError, WindowOptions};

/// The monitor of a full-screen window, and what to do instead of opening one.
#[derive(Debug, Clone, Args)]
pub struct MonitorArguments {
    /// The monitor's name, its number in the list, or auto [default: the last that is not primary, else the only one]
    #[arg(long, value_name = "NAME|INDEX", default_value = "auto", hide_default_value = true)]
    pub monitor: MonitorChoice,
    /// List the monitors and exit
    #[arg(long)]
    pub list_monitors: bool,
    /// Show on each monitor its number, name, resolution and place for some seconds, and exit
    #[arg(long, value_name = "SECS", num_args = 0..=1, default_missing_value = "8", value_parser = identify_secs)]
    pub identify: Option<Duration>,
    /// Set a monitor that runs another mode to its native one, which alone shows each pixel as one
    #[arg(long)]
    pub set_mode: bool,
    #[arg(long, hide = true, overrides_with = "set_mode")]
    no_set_mode: bool,
    /// Save what the window shows once the first image has arrived
    #[arg(long, value_name = "FILE.png")]
    pub screenshot: Option<PathBuf>,
}

impl MonitorArguments {
    /// Prints the monitors or shows which is which, if that is asked for, and returns whether it is.
    ///
    /// # Errors
    /// [`WindowError`] when there is no display.
    pub fn tell_monitors(&self) -> Result<bool, WindowError> {
        if self.list_monitors {
            for line in list_lines(&window::list_monitors()?) {
                println!("{line}");
            }
        }
        if let Some(duration) = self.identify {
            // A signal ends the process, and with it the windows.
            window::identify(duration, || false)?;
        }
        Ok(self.list_monitors || self.identify.is_some())
    }

    /// The window's options; `source` says what is shown.
    pub fn window_options(&self, source: &str) -> WindowOptions {
        let (monitor, screenshot, set_mode) = (self.monitor.clone(), self.screenshot.clone(), self.set_mode);
        WindowOptions { source: source.to_owned(), monitor, screenshot, set_mode, ..WindowOptions::default() }
    }
}

/// Time for which monitors show their names.
fn identify_secs(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.1..=3600.0).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| "it is a number of seconds from 0.1 to 3600".to_owned())
}
