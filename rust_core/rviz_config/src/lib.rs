//! `.rviz` files as typed settings.
//!
//! A `.rviz` file is YAML: a tree of displays, each with a class and properties, and beside it the window's
//! layout, which says nothing about the picture. [`load`] reads the part that decides what is drawn:
//!
//! ```text
//! text --(node: YAML tree with lines)--> sections --(section: rviz's conversions)--> Config
//!                                           |
//!                                           +--> Finding: line, path, what was not understood
//! ```
//!
//! Nothing inside a readable file is fatal. A key that rviz 1.14 would not read, a class that is not known and a
//! value that cannot be taken as it stands each become a [`Finding`] with its line, and reading goes on with the
//! value that rviz would have used. Only a file that is no such YAML at all is a [`ConfigError`].
//!
//! Defaults, ranges and conversions are those of rviz 1.14.19: a missing key leaves the display's default, a number
//! out of range is clamped, text that is no number counts as 0, an unknown choice is the first of the list.
#![forbid(unsafe_code)]

mod config;
mod displays;
mod error;
mod finding;
mod global_options;
mod node;
mod qt_value;
mod section;
mod view;
mod view_direction;

pub use config::{Config, PlacedDisplay};
pub use displays::axes::AxesSettings;
pub use displays::camera_pub::{CameraPubSettings, ImageEncoding};
pub use displays::cloud::{Axis, AxisColorSettings, CloudSettings, ColorTransformer, IntensitySettings, PointStyle};
pub use displays::covariance::{
    CovarianceColorStyle, CovarianceFrame, CovarianceSettings, OrientationCovarianceSettings,
    PositionCovarianceSettings,
};
pub use displays::depth_cloud::DepthCloudSettings;
pub use displays::effort::EffortSettings;
pub use displays::grid::{GridPlane, GridSettings};
pub use displays::grid_cells::GridCellsSettings;
pub use displays::image::ImageSettings;
pub use displays::interactive_markers::InteractiveMarkersSettings;
pub use displays::map::{MapPalette, MapSettings};
pub use displays::marker::MarkerSettings;
pub use displays::odometry::OdometrySettings;
pub use displays::path::{PathSettings, PoseStyle};
pub use displays::point_stamped::PointStampedSettings;
pub use displays::polygon::PolygonSettings;
pub use displays::pose::PoseSettings;
pub use displays::pose_array::{PoseArraySettings, PoseArrayShape};
pub use displays::pose_symbol::{PoseShape, PoseSymbolSettings};
pub use displays::pose_with_covariance::PoseWithCovarianceSettings;
pub use displays::range::RangeSettings;
pub use displays::robot_model::{LinkSettings, RobotModelSettings};
pub use displays::screw::ScrewSettings;
pub use displays::tf::TfSettings;
pub use displays::visibility::Visibility;
pub use displays::{DisplayConfig, DisplaySettings, LineStyle};
pub use error::ConfigError;
pub use finding::{Finding, FindingKind};
pub use global_options::GlobalOptions;
pub use view::{FrameAxis, OrbitView, ViewConfig, ViewController};
pub use view_direction::FollowedRotation;

use std::path::Path;

/// Reads the `.rviz` file at `path`.
///
/// # Errors
///
/// [`ConfigError::Unreadable`], [`ConfigError::NotUtf8`], and those of [`parse`]; each names the file.
pub fn load(path: &Path) -> Result<Config, ConfigError> {
    let source = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|error| ConfigError::Unreadable { file: source.clone(), error })?;
    match std::str::from_utf8(&bytes) {
        Ok(text) => parse(text, &source),
        Err(error) => {
            let valid = bytes.get(..error.valid_up_to()).unwrap_or_default();
            let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
            Err(ConfigError::NotUtf8 { file: source, line })
        }
    }
}

/// Reads the text of a `.rviz` file; `source_name` is what errors and [`Config::source`] call it.
///
/// # Errors
///
/// [`ConfigError::NotYaml`] and [`ConfigError::NoVisualizationManager`].
pub fn parse(text: &str, source_name: &str) -> Result<Config, ConfigError> {
    config::read(text, source_name)
}
