//! `.rviz` files as typed settings.
//!
//! A `.rviz` file is YAML: a tree of displays, each with a class and properties, and the layout of rviz's windows.
//! [`load`] reads what is drawn:
//!
//! ```text
//! text --(node: YAML tree with lines)--> sections --(section: rviz's conversions)--> Config
//!                                           |
//!                                           +--> Finding: line, path, problem
//! ```
//!
//! Nothing inside a readable file is fatal. A key that rviz 1.14 does not read, an unknown class and an invalid value
//! each become a [`Finding`] with its line, and reading goes on with the value that rviz would use. Only a file that is
//! no such YAML at all is a [`ConfigError`].
//!
//! Defaults, ranges and conversions are rviz 1.14.19's: a missing key leaves the display's default, a number out of
//! range is clamped, text that is no number counts as 0, an unknown choice is the first of the list.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

#[macro_use]
mod properties;

mod config;
mod displays;
mod error;
mod finding;
mod frame_filter;
mod global_options;
pub mod headless;
mod insert;
mod node;
mod one_line;
mod plugin_displays;
mod problems;
mod qt_value;
mod report;
mod save;
mod section;
mod time_panel;
mod unknown_displays;
mod view;
mod view_direction;

pub use config::{load, parse, parse_bytes, Config, PlacedDisplay};
pub use displays::covariance::{
    CovarianceColorStyle, CovarianceFrame, CovarianceSettings, OrientationCovarianceSettings,
    PositionCovarianceSettings,
};
pub use displays::line_style::LineStyle;
pub use displays::pose_symbol::{PoseShape, PoseSymbolSettings};
pub use displays::visibility::Visibility;
pub use displays::*;
pub use error::{ConfigError, MAX_FILE_BYTES};
pub use finding::{Finding, FindingKind};
pub use frame_filter::{FilterError, FrameFilter};
pub use global_options::GlobalOptions;
pub use insert::{insert_camera, InsertError, NewCamera};
pub use problems::{camera_problems, setting_problems, SettingProblem};
pub use qt_value::color;
pub use report::{Property, ENTRY};
pub use view::{FreeView, OrbitView, ViewConfig, ViewController};
