//! A whole `.rviz` file.
//!
//! Of the file's sections only `Visualization Manager` decides the picture. The others lay out rviz's windows and are
//! passed over, except for the Time panel's synchronization, as are the mouse tools but for which is the first.

use crate::displays::{self, DisplayConfig, DisplaySettings};
use crate::error::ConfigError;
use crate::finding::{one_line, Finding};
use crate::global_options::GlobalOptions;
use crate::node::{self, Content, Node};
use crate::section::{Report, Section};
use crate::time_panel;
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

/// The beginnings of ROS 2's names of rviz's own classes.
const ROS2_PACKAGES: [&str; 2] = ["rviz_default_plugins/", "rviz_common/"];
/// The beginning of ROS 1's.
const ROS1_PACKAGE: &str = "rviz/";

/// The first class of ROS 2's rviz, if the file has such classes and none of ROS 1's rviz.
fn ros2_class<'a>(root: &'a Node, manager: &'a Node) -> Option<&'a str> {
    let lists = [manager.get("Displays"), manager.get("Tools"), root.get("Panels")];
    let items = lists.into_iter().flatten().filter_map(|list| match &list.content {
        Content::List(items) => Some(items.iter().map(|item| &**item)),
        _ => None,
    });
    let view = manager.get("Views").and_then(|views| views.get("Current"));
    let classes = items.flatten().chain(view).filter_map(|item| match &item.get("Class")?.content {
        Content::Scalar(class) => Some(class.as_str()),
        _ => None,
    });
    let classes: Vec<&str> = classes.collect();
    let is_ros2 = |class: &&&str| ROS2_PACKAGES.iter().any(|package| class.starts_with(package));
    let found = classes.iter().find(is_ros2).copied()?;
    (!classes.iter().any(|class| class.starts_with(ROS1_PACKAGE))).then_some(found)
}

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
    if let Some(ros2) = ros2_class(&root, manager) {
        return Err(ConfigError::Ros2 { file: file(), class: one_line(ros2) });
    }
    let report = Report::default();
    time_panel::check(root.get("Panels"), &report);
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
    displays::check_visibilities(manager.node("Displays"), &displays, &displays, "Displays", &report);
    let mut views = manager.child("Views");
    let view = ViewConfig::read(views.child("Current"));
    views.skip(&["Saved"]);
    // Of the views, only the current one's direction matters.
    report.with_notes(true, || views.finish());
    manager.finish();

    Ok(Config { source: source.to_owned(), global, enabled, displays, view, findings: report.into_findings() })
}
