//! The programs that show the image, as the launch files' argument `viewer` names them.

use clap::ValueEnum;

/// Viewer of the launch files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Viewer {
    /// The node `projector_window`.
    #[value(name = "projector_window")]
    ProjectorWindow,
    /// The node `camera_stream` itself.
    #[value(name = "window")]
    Window,
    /// `image_view`, whose window is placed.
    #[value(name = "image_view")]
    ImageView,
    /// No window.
    #[value(name = "none")]
    None,
}

impl Viewer {
    /// Name of the node `projector_window`.
    pub(super) const PROJECTOR_WINDOW: &'static str = "projector_window";

    /// Name of the viewer's node.
    pub(super) fn node(self, checked_name: &str) -> Option<&str> {
        match self {
            Self::ProjectorWindow => Some(Self::PROJECTOR_WINDOW),
            Self::Window => Some(checked_name),
            Self::ImageView => Some("image_view"),
            Self::None => None,
        }
    }
}
