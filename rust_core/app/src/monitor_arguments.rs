//! The arguments of all programs with a full-screen window.

use std::path::PathBuf;

use clap::Args;
use rcs_window::{self as window, list_lines, MonitorChoice, WindowError, WindowOptions};

/// Which monitor, and what to do beside showing.
#[derive(Debug, Clone, Args)]
pub struct MonitorArguments {
    /// The monitor's name, or its number in the list [default: the last that is not primary, else the only one]
    #[arg(long, value_name = "NAME|INDEX", default_value = "", hide_default_value = true)]
    pub monitor: MonitorChoice,
    /// List the monitors and exit
    #[arg(long)]
    pub list_monitors: bool,
    /// Save what the window shows once the first picture has arrived
    #[arg(long, value_name = "FILE.png")]
    pub screenshot: Option<PathBuf>,
}

impl MonitorArguments {
    /// Prints the monitors if that is asked for, and whether it is.
    ///
    /// # Errors
    /// [`WindowError`] when there is no display.
    pub fn print_list(&self) -> Result<bool, WindowError> {
        if self.list_monitors {
            for line in list_lines(&window::list_monitors()?) {
                println!("{line}");
            }
        }
        Ok(self.list_monitors)
    }

    /// The window's options; `source` says what is shown.
    pub fn window_options(&self, source: &str) -> WindowOptions {
        let (monitor, screenshot) = (self.monitor.clone(), self.screenshot.clone());
        WindowOptions { source: source.to_owned(), monitor, screenshot }
    }
}
