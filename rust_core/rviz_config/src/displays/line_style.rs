//! How lines are drawn by Grid and Path.

/// How lines are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LineStyle {
    /// One pixel wide at any distance.
    #[default]
    Lines,
    /// Strips that face the camera, of a width in metres.
    Billboards,
}

/// The names of line styles in a config.
pub(crate) const LINE_STYLES: [(&str, LineStyle); 2] =
    [("Lines", LineStyle::Lines), ("Billboards", LineStyle::Billboards)];
