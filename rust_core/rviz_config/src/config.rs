//! A whole `.rviz` file.
//!
//! Of the file's sections only `Visualization Manager` decides the picture. The others lay out rviz's windows and are
//! passed over, as are the mouse tools but for which is the first.

use crate::displays::{self, DisplayConfig, DisplaySettings};
use crate::error::ConfigError;
use crate::finding::Finding;
use crate::global_options::GlobalOptions;
use crate::node::{self, Content};
use crate::section::{Report, Section};
use crate::view::ViewConfig;

/// The part of a `.rviz` file that decides the picture.
///
/// ```
/// let text = "
/// Visualization Manager:
///   Displays:
///   - Class: rviz/Group
///     Name: robot
///     Enabled: true
///     Displays:
///     - {Class: rviz/TF, Name: frames, Enabled: true}
/// ";
/// let config = rcs_rviz_config::parse(text, "scene.rviz")?;
/// let paths: Vec<String> = config.placed_displays().iter().map(|placed| placed.path.join("/")).collect();
/// assert_eq!(paths, ["robot", "robot/frames"]);
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Name of the file, for messages.
    pub source: String,
    /// What holds for the whole scene.
    pub global: GlobalOptions,
    /// Whether the tree of displays is enabled at all. True unless someone unticked its root.
    pub enabled: bool,
    /// The displays in the file's order. Those inside groups are inside their group's settings.
    pub displays: Vec<DisplayConfig>,
    /// rviz's main view, which the default light follows.
    pub view: ViewConfig,
    /// What was not understood, in the order of lines.
    pub findings: Vec<Finding>,
}

/// A display and its place among the groups.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedDisplay<'a> {
    /// The display.
    pub display: &'a DisplayConfig,
    /// The names of the groups around it from the outermost in, then its own: what
    /// [`Visibility::shows`](crate::Visibility::shows) asks for.
    pub path: Vec<&'a str>,
    /// Whether the display, all groups around it and the tree itself are enabled.
    pub enabled: bool,
}

impl Config {
    /// All displays, each group followed by its own, in the file's order.
    pub fn placed_displays(&self) -> Vec<PlacedDisplay<'_>> {
        let mut placed = Vec::new();
        place(&self.displays, &[], self.enabled, &mut placed);
        placed
    }
}

fn place<'a>(
    displays: &'a [DisplayConfig],
    group_path: &[&'a str],
    group_enabled: bool,
    placed: &mut Vec<PlacedDisplay<'a>>,
) {
    for display in displays {
        let mut path = group_path.to_vec();
        path.push(&display.name);
        let enabled = group_enabled && display.enabled;
        placed.push(PlacedDisplay { display, path: path.clone(), enabled });
        if let DisplaySettings::Group(group) = &display.settings {
            place(&group.displays, &path, enabled, placed);
        }
    }
}

/// The sections that are about rviz's windows, of the present and of old versions.
const WINDOW_SECTIONS: [&str; 5] = ["Panels", "Custom Panels", "Preferences", "Toolbars", "Window Geometry"];

const MANAGER: &str = "Visualization Manager";

/// Reads a file's text; see [`parse`](crate::parse).
pub(crate) fn read(text: &str, source: &str) -> Result<Config, ConfigError> {
    let file = || source.to_owned();
    let root = node::parse(text).map_err(|error| ConfigError::NotYaml {
        file: file(),
        line: error.line,
        column: error.column,
        reason: error.reason,
    })?;
    let manager = match root.get(MANAGER) {
        Some(manager) if matches!(manager.content, Content::Map(_)) => manager,
        _ => return Err(ConfigError::NoVisualizationManager { file: file() }),
    };
    let report = Report::default();
    let mut top = Section::new(&root, String::new(), &report);
    top.skip(&WINDOW_SECTIONS);
    top.skip(&[MANAGER]);
    top.finish();

    // What is reported inside the manager goes by paths without it: "Displays / cloud / Style".
    let mut manager = Section::new(manager, String::new(), &report);
    manager.skip(&["Class", "Name"]);
    let mut enabled = true;
    manager.bool("Value", &mut enabled);
    manager.bool("Enabled", &mut enabled);
    let global = GlobalOptions::read(manager.child("Global Options"));
    let mut displays = displays::read_list(&mut manager, "Displays");
    displays::interactive_markers::apply_tools(&mut displays, manager.node("Tools"));
    let mut views = manager.child("Views");
    let view = ViewConfig::read(views.child("Current"));
    views.skip(&["Saved"]);
    views.finish();
    manager.finish();

    Ok(Config { source: source.to_owned(), global, enabled, displays, view, findings: report.into_findings() })
}
