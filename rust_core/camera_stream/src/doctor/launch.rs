//! A launch file's arguments as arguments of the node, so that a launch line or a folder of `setup` can be examined.
//!
//! `camera_stream doctor FOLDER` and `camera_stream doctor NAME:=VALUE…` start again with what the launch file would
//! give the node: `-d`, `--viewer`, `--monitor`, remappings and private parameters (`_name:=value`).

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use rcs_node_support::node_options::parameter_names;
use rcs_ros::{ParameterValue, Parameters};

use crate::cli::Cli;

/// The launch file in a folder of `setup`, and its config.
const LAUNCH_FILE: &str = "projection.launch";
const CONFIG_FILE: &str = "scene.rviz";

const CONFIG: &str = "rviz_config";
const VIEWER: &str = "viewer";
const MONITOR: &str = "monitor";
const DEFAULT_VIEWER: &str = "projector_window";

/// Arguments of projection.launch and fetch.launch that remap a topic.
const TOPICS: [(&str, &str); 7] = [
    ("camera_info_topic", "/proj_view/camera_info"),
    ("image_topic", "/proj_view/image"),
    ("head_cloud_topic", "/head_camera/depth_registered/points"),
    ("clusters_topic", "/widget/clusters"),
    ("desired_object_topic", "/widget/desired_object"),
    ("path_topic", "/move_base/NavfnROS/plan"),
    ("markers_topic", "/visualization_marker_array"),
];
/// Their arguments that do not concern the node.
const OTHERS: [&str; 19] = [
    "projector",
    "respawn",
    "sample_scene",
    "clouds_frame",
    "clusters",
    "desired_object",
    "turret",
    "path_arrows",
    "line_of_sight",
    "turret_command",
    "pan_topic",
    "tilt_topic",
    "trajectory_topic",
    "moveit_msgs",
    "frame_id",
    "target",
    "turret_aim_parameters",
    "nav_path_markers_parameters",
    "line_of_sight_parameters",
];
/// Parameters that projection.launch sets to something else than the node's default.
const DEFAULTS: [(&str, &str); 3] = [("projection", "exact"), ("undistort", "true"), ("stale_timeout", "1")];
/// Topics that projection.launch shows as long as they have a publisher.
const HELD: [&str; 2] = ["/move_base/NavfnROS/plan", "/visualization_marker_array"];

/// Why a launch file cannot be read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LaunchError {
    /// The file cannot be read.
    #[error("cannot read {file}: {error}; name a folder that camera_stream setup wrote", file = .file.display())]
    Unreadable {
        file: PathBuf,
        #[source]
        error: io::Error,
    },
    /// The file is not XML.
    #[error("{file}: {error}", file = .file.display())]
    Xml {
        file: PathBuf,
        #[source]
        error: roxmltree::Error,
    },
}

type Arguments = BTreeMap<String, String>;

/// The process's arguments, without the program's name, with those of a launch file translated; `None` where there are
/// none. `folder` is one of the arguments.
///
/// # Errors
/// [`LaunchError`].
pub(crate) fn node_arguments(
    arguments: impl IntoIterator<Item = OsString>,
    folder: Option<&Path>,
) -> Result<Option<Vec<OsString>>, LaunchError> {
    let parameters = parameter_names::<Cli>();
    let (mut given, mut rest, mut folder_word) = (Arguments::new(), Vec::new(), folder);
    for argument in arguments {
        match argument.to_str().and_then(|text| text.split_once(":=")) {
            Some((name, value)) if is_launch_argument(name, &parameters) => {
                given.insert(name.to_owned(), value.to_owned());
            }
            _ if folder_word.is_some_and(|folder| folder.as_os_str() == argument) => folder_word = None,
            _ => rest.push(argument),
        }
    }
    let mut all = match folder {
        Some(folder) => of_folder(folder, &given)?,
        None if given.is_empty() => return Ok(None),
        None => Arguments::new(),
    };
    all.extend(given);
    rest.extend(translated(&all, &parameters));
    Ok(Some(rest))
}

/// Replaces the process by the same program with other arguments, because remappings and private parameters are read
/// from the process's. Returns only if that fails.
pub(crate) fn restart(arguments: Vec<OsString>) -> io::Error {
    let program = match std::env::current_exe() {
        Ok(program) => program,
        Err(error) => return error,
    };
    #[expect(clippy::disallowed_methods, reason = "this program again, without a shell")]
    let mut command = Command::new(program);
    // The file may hold several programs, chosen by this name.
    command.arg0(std::env::args_os().next().unwrap_or_default()).args(arguments).exec()
}

/// The parameters that a launch file gives the node by default.
pub(super) fn default_parameters() -> Parameters {
    let held = |topic: &&str| {
        let fields = [("topic", *topic), ("limit", "held")];
        ParameterValue::Struct(fields.map(|(name, value)| (name.to_owned(), value.into())).into())
    };
    let timeouts = ("stale_timeouts".to_owned(), ParameterValue::Array(HELD.iter().map(held).collect()));
    let texts = DEFAULTS.iter().map(|(name, value)| ((*name).to_owned(), ParameterValue::from(*value)));
    texts.chain([timeouts]).collect()
}

fn is_launch_argument(name: &str, parameters: &[String]) -> bool {
    let is_topic = TOPICS.iter().any(|(argument, _)| *argument == name);
    let is_parameter = parameters.iter().any(|parameter| parameter == name);
    is_topic || is_parameter || [CONFIG, VIEWER, MONITOR].contains(&name) || OTHERS.contains(&name)
}

/// A launch file's arguments as the node's.
fn translated(arguments: &Arguments, parameters: &[String]) -> Vec<OsString> {
    let viewer = arguments.get(VIEWER).map_or(DEFAULT_VIEWER, String::as_str);
    let mut words = vec![format!("--{VIEWER}={viewer}")];
    for (name, value) in arguments.iter().filter(|(_, value)| !value.is_empty()) {
        if name == CONFIG {
            words.extend(["-d".to_owned(), value.clone()]);
        } else if name == MONITOR {
            words.push(format!("--{MONITOR}={value}"));
        } else if let Some((_, topic)) = TOPICS.iter().find(|(argument, _)| argument == name) {
            words.push(format!("{topic}:={value}"));
        } else if parameters.contains(name) {
            words.push(format!("_{name}:={value}"));
        }
    }
    words.into_iter().map(OsString::from).collect()
}

/// Most bytes of a launch file.
const MAX_LAUNCH_FILE_BYTES: u64 = 4 << 20;

/// The arguments that the launch file of a folder gives the launch files that it includes.
fn of_folder(folder: &Path, given: &Arguments) -> Result<Arguments, LaunchError> {
    let file = folder.join(LAUNCH_FILE);
    let text = match rcs_user_files::read_text(&file, MAX_LAUNCH_FILE_BYTES) {
        Ok(text) => text,
        Err(error) => return Err(LaunchError::Unreadable { file, error }),
    };
    match of_launch_file(&text, folder, given) {
        Ok(arguments) => Ok(arguments),
        Err(error) => Err(LaunchError::Xml { file, error }),
    }
}

fn of_launch_file(text: &str, folder: &Path, given: &Arguments) -> Result<Arguments, roxmltree::Error> {
    let document = roxmltree::Document::parse(text)?;
    let elements = |node: roxmltree::Node<'_, '_>, tag: &str| -> Vec<_> {
        node.children().filter(|child| child.has_tag_name(tag)).map(|child| child.id()).collect()
    };
    let read = |element: roxmltree::NodeId, outer: &Arguments| {
        let element = document.get_node(element)?;
        let value = element.attribute("value").or_else(|| element.attribute("default"))?;
        Some((element.attribute("name")?.to_owned(), substituted(value, outer, folder)?))
    };
    let root = document.root_element();
    let mut own = Arguments::new();
    for argument in elements(root, "arg") {
        own.extend(read(argument, &own));
        own.extend(
            given
                .iter()
                .filter(|(name, _)| own.contains_key(*name))
                .map(|(n, v)| (n.clone(), v.clone()))
                .collect::<Vec<_>>(),
        );
    }
    let mut all = own.clone();
    for include in elements(root, "include").into_iter().filter_map(|id| document.get_node(id)) {
        all.extend(elements(include, "arg").into_iter().filter_map(|argument| read(argument, &own)));
    }
    let config = || folder.join(CONFIG_FILE).to_string_lossy().into_owned();
    all.entry(CONFIG.to_owned()).or_insert_with(config);
    Ok(all)
}

/// A value with `$(arg NAME)` and `$(dirname)` replaced; `None` if it has other substitutions, which only roslaunch
/// knows.
fn substituted(value: &str, arguments: &Arguments, folder: &Path) -> Option<String> {
    let mut parts = value.split("$(");
    let mut text = parts.next()?.to_owned();
    for part in parts {
        let (inner, rest) = part.split_once(')')?;
        match inner.split_whitespace().collect::<Vec<_>>()[..] {
            ["arg", name] => text.push_str(arguments.get(name)?),
            ["dirname"] => text.push_str(&folder.to_string_lossy()),
            _ => return None,
        }
        text.push_str(rest);
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(arguments: &[&str], folder: Option<&Path>) -> Vec<String> {
        let arguments = arguments.iter().map(OsString::from);
        let words = node_arguments(arguments, folder).unwrap().unwrap();
        words.into_iter().map(|word| word.into_string().unwrap()).collect()
    }

    #[test]
    fn launch_arguments_become_those_of_the_node() {
        let given = [
            "doctor",
            "rviz_config:=/a/scene.rviz",
            "projector:=/a/p.yaml",
            "monitor:=HDMI-1",
            "stale_timeouts:=[{topic: /plan, limit: held}]",
            "image_topic:=/wall/image",
            "--listen",
            "2",
            "/other:=/topic",
            "fixed_frame:=",
        ];
        let expected = [
            "doctor",
            "--listen",
            "2",
            "/other:=/topic",
            "--viewer=projector_window",
            "/proj_view/image:=/wall/image",
            "--monitor=HDMI-1",
            "-d",
            "/a/scene.rviz",
            "_stale_timeouts:=[{topic: /plan, limit: held}]",
        ];
        assert_eq!(words(&given, None), expected);
        let plain = ["doctor", "-d", "x.rviz", "/a:=/b", "__name:=x"].map(OsString::from);
        assert_eq!(node_arguments(plain, None).unwrap(), None, "nothing of a launch file");
    }

    #[test]
    fn a_folder_gives_what_its_launch_file_passes_on() {
        let folder = tempfile::tempdir().unwrap();
        let launch = r#"<launch>
          <arg name="monitor" default="HDMI-1"/>
          <include file="$(find rviz_camera_stream)/launch/projection.launch">
            <arg name="rviz_config" value="$(dirname)/scene.rviz"/>
            <arg name="monitor" value="$(arg monitor)"/>
            <arg name="stale_timeout" value="1"/>
            <arg name="clusters" value="$(eval 1)"/>
          </include>
        </launch>"#;
        std::fs::write(folder.path().join(LAUNCH_FILE), launch).unwrap();
        let name = folder.path().to_str().unwrap();
        let expected = |monitor: &str| {
            let config = format!("{name}/scene.rviz");
            let monitor = format!("--monitor={monitor}");
            ["doctor", "--viewer=projector_window", &monitor, "-d", &config, "_stale_timeout:=1"].map(str::to_owned)
        };
        assert_eq!(words(&["doctor", name], Some(folder.path())), expected("HDMI-1"));
        assert_eq!(words(&["doctor", name, "monitor:=DP-1"], Some(folder.path())), expected("DP-1"));
        std::fs::write(folder.path().join(LAUNCH_FILE), "<launch>").unwrap();
        assert!(node_arguments([], Some(folder.path())).unwrap_err().to_string().contains(LAUNCH_FILE));
        let error = node_arguments([], Some(Path::new("/nowhere"))).unwrap_err().to_string();
        assert!(
            error.starts_with("cannot read /nowhere/projection.launch: ") && error.contains("; name a folder"),
            "{error}"
        );
    }

    #[test]
    fn every_argument_of_the_launch_files_is_known_with_its_default() {
        let parameters = parameter_names::<Cli>();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch");
        for file in ["projection.launch", "fetch.launch"] {
            let text = std::fs::read_to_string(folder.join(file)).unwrap();
            let document = roxmltree::Document::parse(&text).unwrap();
            let arguments: Vec<_> =
                document.root_element().children().filter(|child| child.has_tag_name("arg")).collect();
            let default = |name: &str| {
                let found = arguments.iter().find(|argument| argument.attribute("name") == Some(name));
                found.and_then(|argument| argument.attribute("default")).unwrap_or_default()
            };
            for argument in &arguments {
                let name = argument.attribute("name").unwrap();
                assert!(is_launch_argument(name, &parameters), "{file}: {name}");
            }
            for (name, value) in DEFAULTS.iter().chain(&[(VIEWER, DEFAULT_VIEWER)]) {
                assert_eq!(default(name), *value, "{file}: {name}");
            }
            let held: Vec<String> = HELD.iter().map(|topic| format!("{{topic: {topic}, limit: held}}")).collect();
            assert_eq!(default("stale_timeouts"), format!("[{}]", held.join(", ")), "{file}");
        }
    }
}
