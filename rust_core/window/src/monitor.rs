//! Choice of the monitor.
//!
//! A projector is one more monitor of the computer. By default [`MonitorChoice`] is the last monitor that is not the
//! primary one, which is the projector on a robot with a screen; else a number from the list, or a name such as
//! `HDMI-1`. [`MonitorInfo`] describes a monitor in physical pixels of the whole desktop.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

/// One monitor as the window system describes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MonitorInfo {
    /// Name of the output, such as `HDMI-1`; may be empty where the window system gives none.
    pub name: String,
    /// Left and top edge in the desktop, physical pixels.
    pub position_px: (i32, i32),
    /// Width and height, physical pixels.
    pub size_px: (u32, u32),
    /// `true` for the window system's primary monitor.
    pub is_primary: bool,
    /// `true` for a name of a part of the desktop, given with `xrandr --setmonitor`.
    pub is_virtual: bool,
}

impl fmt::Display for MonitorInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (x, y) = self.position_px;
        let (width, height) = self.size_px;
        let name = if self.name.is_empty() { "(no name)" } else { &self.name };
        write!(f, "{name} {width}x{height}{x:+}{y:+}")?;
        if self.is_primary {
            write!(f, " primary")?;
        }
        if self.is_virtual {
            write!(f, " virtual")?;
        }
        Ok(())
    }
}

/// The user's choice of a monitor.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum MonitorChoice {
    /// The last monitor that is neither the primary one nor virtual, or the only one.
    #[default]
    Secondary,
    /// A name, or a number counted from 0 in the order of the list. A monitor whose name is that number wins.
    NameOrIndex(String),
}

impl FromStr for MonitorChoice {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text.trim() {
            "" | "auto" => Self::Secondary,
            given => Self::NameOrIndex(given.to_owned()),
        })
    }
}

/// Error of choosing a monitor.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MonitorError {
    /// The window system reports no monitor at all.
    #[error("the window system reports no monitor")]
    None,
    /// No monitor has this name or number.
    #[error("no monitor '{wanted}'; monitors: {present}")]
    Unknown {
        /// The user's choice.
        wanted: String,
        /// The monitors that exist, each with its number.
        present: String,
    },
}

impl MonitorChoice {
    /// The index of the chosen monitor.
    ///
    /// # Errors
    /// [`MonitorError`] without monitors, or for an unknown name or number.
    pub fn resolve(&self, monitors: &[MonitorInfo]) -> Result<usize, MonitorError> {
        if monitors.is_empty() {
            return Err(MonitorError::None);
        }
        let wanted = match self {
            Self::Secondary => {
                return Ok(monitors.iter().rposition(|m| !m.is_primary && !m.is_virtual).unwrap_or(0));
            }
            Self::NameOrIndex(wanted) => wanted,
        };
        let by_name = monitors
            .iter()
            .position(|m| m.name == *wanted)
            .or_else(|| monitors.iter().position(|m| m.name.eq_ignore_ascii_case(wanted)));
        let by_index = || wanted.parse().ok().filter(|index| *index < monitors.len());
        by_name
            .or_else(by_index)
            .ok_or_else(|| MonitorError::Unknown { wanted: wanted.clone(), present: list(monitors).join(", ") })
    }
}

/// One line for each monitor, `INDEX: NAME WIDTHxHEIGHT+X+Y [primary] [virtual]`.
pub fn list(monitors: &[MonitorInfo]) -> Vec<String> {
    monitors.iter().enumerate().map(|(index, monitor)| format!("{index}: {monitor}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor(name: &str, x: i32, is_primary: bool) -> MonitorInfo {
        MonitorInfo { name: name.to_owned(), position_px: (x, 0), size_px: (1280, 800), is_primary, is_virtual: false }
    }

    fn choice(text: &str) -> MonitorChoice {
        text.parse().unwrap()
    }

    #[test]
    fn by_default_the_last_monitor_that_is_not_primary_is_chosen() {
        let all = [monitor("eDP-1", 0, true), monitor("HDMI-1", 1280, false), monitor("DP-2", 2560, false)];
        for text in ["", "auto"] {
            assert_eq!(choice(text).resolve(&all), Ok(2));
        }
        let primary_last = [monitor("HDMI-1", 0, false), monitor("eDP-1", 1280, true)];
        assert_eq!(MonitorChoice::default().resolve(&primary_last), Ok(0));
    }

    #[test]
    fn the_only_monitor_is_chosen_even_when_it_is_primary() {
        assert_eq!(choice("").resolve(&[monitor("screen", 0, true)]), Ok(0));
        assert_eq!(choice("").resolve(&[]), Err(MonitorError::None));
    }

    #[test]
    fn a_virtual_monitor_is_chosen_only_by_name_or_number() {
        let half = MonitorInfo { is_virtual: true, ..monitor("left half", 0, false) };
        let all = [monitor("eDP-1", 0, true), half.clone()];
        assert_eq!(choice("").resolve(&all), Ok(0));
        assert_eq!(choice("left half").resolve(&all), Ok(1));
        assert_eq!(half.to_string(), "left half 1280x800+0+0 virtual");
    }

    #[test]
    fn a_name_or_a_number_chooses_and_a_name_wins() {
        let all = [monitor("1", 0, true), monitor("HDMI-1", 1280, false)];
        assert_eq!(choice("hdmi-1").resolve(&all), Ok(1));
        assert_eq!(choice("0").resolve(&all), Ok(0));
        assert_eq!(choice("1").resolve(&all), Ok(0));
    }

    #[test]
    fn an_unknown_monitor_is_named_with_those_that_exist() {
        let error = choice("VGA-1").resolve(&[monitor("HDMI-1", -1280, false)]).unwrap_err();
        assert_eq!(error.to_string(), "no monitor 'VGA-1'; monitors: 0: HDMI-1 1280x800-1280+0");
        assert!(choice("7").resolve(&[monitor("HDMI-1", 0, false)]).is_err());
    }
}
