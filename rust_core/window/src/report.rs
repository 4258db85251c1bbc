//! A monitor as a diagnosis sees it: its mode, and the projector's window on it.

use std::fmt;

/// A monitor's mode, and the projector's window.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MonitorReport {
    /// Native and current mode of a monitor that runs another mode than its native one.
    pub other_mode: Option<[MonitorMode; 2]>,
    /// `true` if the X server scales the image.
    pub is_scaled: bool,
    /// Place of the window.
    pub window: WindowPlace,
}

/// Size of a monitor's mode, and how its lines are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MonitorMode {
    /// Width and height, pixels.
    pub size_px: (u32, u32),
    /// How its lines are sent.
    pub scan: Scan,
}

/// How a mode's lines are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scan {
    /// Each line once in a refresh.
    Progressive,
    /// Every second line in a refresh.
    Interlaced,
    /// Each line twice in a refresh.
    Doubled,
}

impl fmt::Display for MonitorMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (width, height) = self.size_px;
        let scan = match self.scan {
            Scan::Progressive => "",
            Scan::Interlaced => " interlaced",
            Scan::Doubled => " with doubled lines",
        };
        write!(f, "{width}x{height}{scan}")
    }
}

/// Place of the projector's window.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum WindowPlace {
    /// It covers the monitor.
    Over,
    /// It is somewhere else; its rectangle as a text.
    Elsewhere(String),
    /// There is none on the screen.
    Missing,
    /// The window system tells nobody about windows of other programs.
    #[default]
    Unknown,
}
