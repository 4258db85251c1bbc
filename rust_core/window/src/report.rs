//! A monitor as a diagnosis sees it: its mode, and the projector's window on it.

/// A monitor's mode, and the projector's window.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MonitorReport {
    /// Native and current mode, pixels, of a monitor that runs another mode than its native one.
    pub other_mode_px: Option<[(u32, u32); 2]>,
    /// `true` if the X server scales the image.
    pub is_scaled: bool,
    /// Place of the window.
    pub window: WindowPlace,
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
