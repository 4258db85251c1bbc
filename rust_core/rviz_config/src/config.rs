//! A whole `.rviz` file.
//!
//! Only the section `Visualization Manager` decides what is drawn. The others lay out rviz's windows and are skipped,
//! except for the Time panel's synchronization. Of the mouse tools only the first counts.

use std::path::Path;
use std::sync::Arc;

use crate::displays::{self, DisplayConfig, DisplaySettings};
use crate::error::{ConfigError, MAX_FILE_BYTES};
use crate::finding::Finding;
use crate::global_options::GlobalOptions;
use crate::node::{self, Content, Node, SyntaxError};
use crate::one_line::one_line;
use crate::report::Report;
use crate::section::Section;
use crate::view::ViewConfig;
use crate::{time_panel, unknown_displays};

/// The part of a `.rviz` file that decides what is drawn.
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
    /// The text that was read.
    pub text: Arc<str>,
    /// The settings of the whole scene.
    pub global: GlobalOptions,
    /// `true` unless the root of the tree of displays is unticked.
    pub enabled: bool,
    /// The displays in the file's order; displays inside groups are in their group's settings.
    pub displays: Vec<DisplayConfig>,
    /// rviz's main view, which the default light follows.
    pub view: ViewConfig,
    /// Problems in the file, in the order of lines.
    pub findings: Vec<Finding>,
}

/// A display and its place among the groups.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedDisplay<'a> {
    /// The display.
    pub display: &'a DisplayConfig,
    /// The names of the groups around it from the outermost in, then its own, as
    /// [`Visibility::shows`](crate::Visibility::shows) takes it.
    pub path: Vec<&'a str>,
    /// `true` if the display, all groups around it and the tree itself are enabled.
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

/// The sections about rviz's windows, of present and old versions.
const WINDOW_SECTIONS: [&str; 5] = ["Panels", "Custom Panels", "Preferences", "Toolbars", "Window Geometry"];

pub(crate) const MANAGER: &str = "Visualization Manager";

/// Prefixes of rviz's own classes in ROS 2.
const ROS2_PACKAGES: [&str; 2] = ["rviz_default_plugins/", "rviz_common/"];
/// Prefix of rviz's own classes in ROS 1.
const ROS1_PACKAGE: &str = "rviz/";

/// The first class of ROS 2's rviz, if the file has such classes and none of ROS 1's rviz.
fn ros2_class<'a>(root: &'a Node, manager: &'a Node) -> Option<&'a str> {
    let lists = [manager.get("Displays"), manager.get("Tools"), root.get("Panels")];
    let items = lists.into_iter().flatten().flat_map(Node::items).map(|item| &**item);
    let view = manager.get("Views").and_then(|views| views.get("Current"));
    let classes: Vec<&str> = items.chain(view).filter_map(|item| item.get("Class")?.scalar()).collect();
    let is_ros2 = |class: &&&str| ROS2_PACKAGES.iter().any(|package| class.starts_with(package));
    let found = classes.iter().find(is_ros2).copied()?;
    (!classes.iter().any(|class| class.starts_with(ROS1_PACKAGE))).then_some(found)
}

/// Reads the `.rviz` file at `path`, which may be a pipe of the shell.
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
/// [`ConfigError`], which names the file.
pub fn load(path: &Path) -> Result<Config, ConfigError> {
    let source = path.display().to_string();
    let read = rcs_user_files::read_once(path, MAX_FILE_BYTES);
    let bytes = read.map_err(|error| ConfigError::unreadable(path, &error))?;
    parse_bytes(&bytes, &source)
}

/// Reads the bytes of a `.rviz` file, as [`parse`] does its text.
///
/// # Errors
///
/// [`ConfigError`] as of [`parse`].
pub fn parse_bytes(bytes: &[u8], source_name: &str) -> Result<Config, ConfigError> {
    parse(&rcs_text::decode(bytes), source_name)
}

/// Reads the text of a `.rviz` file; `source_name` names it in errors and in [`Config::source`].
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
/// [`ConfigError`] if the text is no YAML, has no map `Visualization Manager`, or was written by ROS 2's rviz.
pub fn parse(text: &str, source_name: &str) -> Result<Config, ConfigError> {
    let root = node::parse(text).map_err(|SyntaxError { line, column, reason }| {
        ConfigError::new(format_args!("{source_name}:{line}:{column}"), format_args!("not YAML: {reason}"))
    })?;
    let manager = match root.get(MANAGER) {
        Some(manager) if matches!(manager.content, Content::Map(_)) => manager,
        _ => {
            let problem = "no \"Visualization Manager\" section, so this is not a .rviz file";
            return Err(ConfigError::new(source_name, problem));
        }
    };
    if let Some(ros2) = ros2_class(&root, manager) {
        let problem = format!(
            "this is a ROS 2 config ({}); save the scene with ROS 1's rviz, or name ROS 1's classes, such as rviz/Grid",
            one_line(ros2)
        );
        return Err(ConfigError::new(source_name, problem));
    }
    let report = Report::default();
    time_panel::check(root.get("Panels"), &report);
    let mut top = Section::new(&root, String::new(), &report);
    top.skip(&WINDOW_SECTIONS);
    top.skip(&[MANAGER]);
    top.finish();

    // Paths inside the manager leave it out: "Displays / cloud / Style".
    let mut manager = Section::new(manager, String::new(), &report);
    manager.skip(&["Class", "Name"]);
    let mut enabled = true;
    manager.bool("Value", &mut enabled);
    manager.bool("Enabled", &mut enabled);
    let mut global = GlobalOptions::default();
    manager.inside("Global Options", &mut global);
    let mut displays = displays::read_list(&mut manager, "Displays");
    apply_tools(&mut displays, manager.node("Tools"));
    unknown_displays::check_visibilities(manager.node("Displays"), &displays, &displays, "Displays", &report);
    let mut views = manager.child("Views");
    let view = ViewConfig::read(views.child("Current"));
    views.skip(&["Saved"]);
    // Of the views, only the current one's direction matters.
    report.with_notes(true, || views.finish());
    manager.finish();

    let (source, text, findings) = (source_name.to_owned(), text.into(), report.into_findings());
    Ok(Config { source, text, global, enabled, displays, view, findings })
}

/// The mouse tool with which rviz shows all controls.
const INTERACT: &str = "rviz/Interact";

/// Tells the InteractiveMarkers displays whether rviz starts with its Interact tool, by the list under `Tools`.
fn apply_tools(displays: &mut [DisplayConfig], tools: Option<&Node>) {
    let class = tools.and_then(|tools| tools.items().iter().find_map(|tool| tool.get("Class")?.scalar()));
    set_interaction(displays, class == Some(INTERACT));
}

fn set_interaction(displays: &mut [DisplayConfig], enabled: bool) {
    for display in displays {
        match &mut display.settings {
            DisplaySettings::InteractiveMarkers(settings) => settings.interaction_enabled = enabled,
            DisplaySettings::Group(group) => set_interaction(&mut group.displays, enabled),
            _ => {}
        }
    }
}
