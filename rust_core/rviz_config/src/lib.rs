//! `.rviz` files as typed settings.
//!
//! A `.rviz` file is YAML: a tree of displays, each with a class and properties, and beside it the window's
//! layout, which has no bearing on the picture. [`load`] reads the part that decides what is drawn:
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

mod camera_problems;
mod config;
mod displays;
mod error;
mod finding;
mod frame_filter;
mod global_options;
pub mod headless;
mod insert;
mod node;
mod plugin_displays;
mod qt_value;
mod section;
mod setting_problems;
mod time_panel;
mod view;
mod view_direction;

pub use camera_problems::camera_problems;
pub use config::{Config, PlacedDisplay};
pub use displays::covariance::{
    CovarianceColorStyle, CovarianceFrame, CovarianceSettings, OrientationCovarianceSettings,
    PositionCovarianceSettings,
};
pub use displays::pose_symbol::{PoseShape, PoseSymbolSettings};
pub use displays::visibility::Visibility;
pub use displays::*;
pub use error::ConfigError;
pub use finding::{Finding, FindingKind};
pub use frame_filter::{FilterError, FrameFilter};
pub use global_options::GlobalOptions;
pub use insert::{insert_camera, InsertError, NewCamera};
pub use section::{Property, ENTRY};
pub use setting_problems::{setting_problems, SettingProblem};
pub use view::{FrameAxis, OrbitView, ViewConfig, ViewController};
pub use view_direction::FollowedRotation;

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The largest file that is read, in bytes; those that rviz saves have a hundredth of it.
pub const MAX_FILE_BYTES: u64 = 8 << 20;

/// Reads the `.rviz` file at `path`.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// let file = folder.path().join("scene.rviz");
/// std::fs::write(&file, "Visualization Manager: {Global Options: {Fixed Frame: map}}")?;
/// let config = rcs_rviz_config::load(&file)?;
/// assert_eq!(config.global.fixed_frame, "map");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`ConfigError::Unreadable`], [`ConfigError::TooLarge`], [`ConfigError::NotUtf8`], and those of [`parse`]; each names
/// the file.
pub fn load(path: &Path) -> Result<Config, ConfigError> {
    let source = path.display().to_string();
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes));
    read.map_err(|error| ConfigError::Unreadable { file: source.clone(), error })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(ConfigError::TooLarge { file: source });
    }
    parse_bytes(&bytes, &source)
}

/// [`parse`] of bytes that need not be text.
///
/// # Errors
///
/// [`ConfigError::NotUtf8`] and those of [`parse`].
pub fn parse_bytes(bytes: &[u8], source_name: &str) -> Result<Config, ConfigError> {
    match std::str::from_utf8(bytes) {
        Ok(text) => parse(text, source_name),
        Err(error) => {
            let valid = bytes.get(..error.valid_up_to()).unwrap_or_default();
            let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
            Err(ConfigError::NotUtf8 { file: source_name.to_owned(), line })
        }
    }
}

/// Reads the text of a `.rviz` file; `source_name` is what errors and [`Config::source`] call it.
///
/// ```
/// use rcs_rviz_config::DisplaySettings;
///
/// let text = "
/// Visualization Manager:
///   Displays:
///   - {Class: rviz/Grid, Name: floor, Enabled: true, Cell Size: 0.5, Colour: red}
/// ";
/// let config = rcs_rviz_config::parse(text, "scene.rviz")?;
/// let DisplaySettings::Grid(grid) = &config.displays[0].settings else { panic!("a grid") };
/// assert_eq!(grid.cell_size_m, 0.5);
/// // rviz spells it Color.
/// assert_eq!(config.findings[0].to_string(), "line 4: Displays / floor / Colour: unknown key");
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
///
/// # Errors
///
/// [`ConfigError::NotYaml`] and [`ConfigError::NoVisualizationManager`].
pub fn parse(text: &str, source_name: &str) -> Result<Config, ConfigError> {
    config::read(text, source_name)
}

/// The colour of a text as rviz writes and reads it, red, green and blue: `r; g; b` with each from 0 to 255, `#rrggbb`,
/// or a name of SVG's. None for anything else.
///
/// ```
/// assert_eq!(rcs_rviz_config::color("0; 120; 255"), Some([0, 120, 255]));
/// assert_eq!(rcs_rviz_config::color("steelblue"), rcs_rviz_config::color("#4682b4"));
/// assert_eq!(rcs_rviz_config::color("0; 0; 300"), None);
/// ```
pub fn color(text: &str) -> Option<[u8; 3]> {
    qt_value::to_color(text).filter(|(_, is_in_range)| *is_in_range).map(|(rgb, _)| rgb)
}
