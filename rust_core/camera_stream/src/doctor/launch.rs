//! The node that is examined where none is described: the one that runs, or that of a launch file as roslaunch starts
//! it.
//!
//! `camera_stream doctor` starts again with the arguments of the running node; where none runs, with those of
//! `projection.launch` in the current folder. `camera_stream doctor FOLDER` and `camera_stream doctor NAME:=VALUE…`
//! start again with the node's arguments and remappings (`roslaunch --args`), its parameters as `_name:=value`
//! (`roslaunch --dump-params`), the projector's file and the viewer.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::io;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{anyhow, bail, Result};
use serde_json::Value;

use super::running::{self, RunningNode};
use crate::cli::DoctorArgs;

/// The launch file in a folder of `setup`, and the package's.
const LAUNCH_FILE: &str = "projection.launch";
const PACKAGE: &str = "rviz_camera_stream";

const NODE: &str = "/camera_stream";
/// The node that places the window of `image_view`.
const PLACE_NODE: &str = "/image_view_place";

const ROSLAUNCH: &str = "roslaunch";
const ROSLAUNCH_TIMEOUT_SECS: &str = "60";

/// Parameters of all nodes of a launch file by their whole names.
type Parameters = BTreeMap<String, Value>;

/// This process started again with other arguments.
#[derive(Debug)]
pub(crate) struct Restart {
    arguments: Vec<OsString>,
    folder: Option<PathBuf>,
    namespace: Option<String>,
}

/// The process's arguments, without the program's name, with those of the node that is to be examined; `None` where
/// they describe it already: with `-d`, all arguments are the node's.
///
/// # Errors
/// There is no node and no launch file, there are several nodes; what roslaunch refuses, or why it cannot be run.
pub(crate) fn node_arguments(
    arguments: impl IntoIterator<Item = OsString>,
    args: &DoctorArgs,
) -> Result<Option<Restart>> {
    let (given, words): (Vec<_>, Vec<_>) = arguments.into_iter().partition(is_launch_argument);
    if args.node.display_config.is_some() {
        return Ok(None);
    }
    if args.folder.is_some() || !given.is_empty() {
        return of_launch_file(words, given, args.folder.as_deref()).map(Some);
    }
    match running::nodes().as_slice() {
        [RunningNode { arguments, folder, namespace, .. }] => Ok(Some(Restart {
            arguments: words.into_iter().chain(arguments.iter().cloned()).collect(),
            folder: Some(folder.clone()),
            namespace: namespace.clone(),
        })),
        [] if Path::new(LAUNCH_FILE).is_file() => of_launch_file(words, given, Some(Path::new("."))).map(Some),
        [] => bail!(
            "no camera_stream runs on this computer, and there is no {LAUNCH_FILE} in this folder; start the projection \
             (roslaunch FOLDER/{LAUNCH_FILE}), or name its folder: camera_stream doctor FOLDER"
        ),
        several => {
            let pids: Vec<String> = several.iter().map(|node| node.pid.to_string()).collect();
            bail!("several camera_stream run (processes {}); name a folder, or one's config: -d FILE", pids.join(", "))
        }
    }
}

/// The words with a launch file in them, the folder's or the package's, replaced by what it gives the node.
fn of_launch_file(mut words: Vec<OsString>, given: Vec<OsString>, folder: Option<&Path>) -> Result<Restart> {
    let mut file: Vec<OsString> = vec![PACKAGE.into(), LAUNCH_FILE.into()];
    if let Some(folder) = folder {
        file = vec![folder.join(LAUNCH_FILE).into()];
        if let Some(place) = words.iter().rposition(|word| word.as_os_str() == folder.as_os_str()) {
            words.remove(place);
        }
    }
    file.extend(given);
    let roslaunch = |asked: &[&str]| {
        let asked = asked.iter().map(OsStr::new).chain(file.iter().map(OsString::as_os_str));
        output(ROSLAUNCH, asked, ROSLAUNCH_TIMEOUT_SECS)
    };
    let mut node = words_of(&roslaunch(&["--args", NODE])?, NODE);
    let dumped = roslaunch(&["--dump-params"])?;
    let dumped: Parameters =
        serde_yaml_ng::from_str(&dumped).map_err(|error| anyhow!("{ROSLAUNCH} --dump-params: {error}"))?;
    node.extend(private_arguments(&dumped));
    let projector_file = dumped.get("/projector/file").and_then(Value::as_str);
    node.extend(projector_file.map(|file| format!("--projector-file={file}")));
    let place = if is_image_view(&dumped) { roslaunch(&["--args", PLACE_NODE])? } else { String::new() };
    node.extend(viewer(&dumped, &words_of(&place, "/projector_window")));
    let arguments = words.into_iter().chain(node.into_iter().map(OsString::from)).collect();
    Ok(Restart { arguments, folder: None, namespace: None })
}

/// Replaces the process by the same program with other arguments, because remappings and private parameters are read
/// from the process's. Returns only if that fails.
pub(crate) fn restart(with: Restart) -> io::Error {
    let program = match std::env::current_exe() {
        Ok(program) => program,
        Err(error) => return error,
    };
    #[expect(clippy::disallowed_methods, reason = "this program again, without a shell")]
    let mut command = Command::new(program);
    // The file may hold several programs, chosen by this name.
    command.arg0(std::env::args_os().next().unwrap_or_default()).args(with.arguments);
    command.envs(with.namespace.map(|namespace| ("ROS_NAMESPACE", namespace)));
    if let Some(folder) = with.folder {
        command.current_dir(folder);
    }
    command.exec()
}

/// `true` for `NAME:=VALUE` of a launch file, no private parameter and no remapping of an absolute name.
fn is_launch_argument(word: &OsString) -> bool {
    let text = word.to_string_lossy();
    text.split_once(":=").is_some_and(|(name, _)| !name.starts_with(['_', '~', '/']))
}

/// Runs a program and returns its standard output.
fn output<'a>(program: &str, arguments: impl Iterator<Item = &'a OsStr>, timeout_secs: &str) -> Result<String> {
    #[expect(clippy::disallowed_methods, reason = "roslaunch with a limit, without a shell")]
    let mut command = Command::new("timeout");
    command.args([timeout_secs, program]).args(arguments).stdin(Stdio::null());
    // Nodes are named without it, whatever the namespace of this one.
    command.env_remove("ROS_NAMESPACE");
    let output = command.output().map_err(|error| anyhow!("cannot run {program}: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    match output.status.code() {
        // A launch file that cannot be read has no other sign of it with --dump-params.
        Some(0) if !text.trim().is_empty() => Ok(text),
        Some(124) => bail!("{program} has not ended within {timeout_secs} s"),
        Some(127) => {
            bail!("cannot run {program}: not found; source ROS's setup.bash, or name the config with -d FILE.rviz")
        }
        _ => bail!("{program} failed: {}", without_traceback(&output.stderr)),
    }
}

/// The error message of a Python program in one line, without colours and traceback.
fn without_traceback(printed: &[u8]) -> String {
    let text = String::from_utf8_lossy(printed).replace("\x1b[31m", "").replace("\x1b[0m", "");
    let is_trace = |line: &&str| line.starts_with("  ") || line.to_lowercase().contains("traceback");
    rcs_logging::flat(&text.lines().filter(|line| !is_trace(line)).collect::<Vec<_>>().join("\n"))
}

/// A node's arguments and remappings, which stand behind its program in the command line that roslaunch prints.
fn words_of(command_line: &str, program: &str) -> Vec<String> {
    let words = command_line.split_whitespace().skip_while(|word| !word.ends_with(program)).skip(1);
    words.map(str::to_owned).collect()
}

/// The node's parameters as `_name:=value`. JSON is YAML in one line.
fn private_arguments(parameters: &Parameters) -> impl Iterator<Item = String> + '_ {
    let own = |(name, value): (&String, &Value)| {
        let name = name.strip_prefix(NODE)?.strip_prefix('/')?;
        Some(format!("_{name}:={value}"))
    };
    parameters.iter().filter_map(own)
}

fn is_image_view(parameters: &Parameters) -> bool {
    parameters.contains_key("/image_view/window_name")
}

/// The viewer and its monitor as options. `place` are the arguments of the node that places the window of `image_view`.
fn viewer(parameters: &Parameters, place: &[String]) -> Vec<String> {
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    if let Some(monitor) = parameters.get("/projector_window/monitor") {
        return vec!["--viewer=projector_window".to_owned(), format!("--monitor={}", text(monitor))];
    }
    if is_image_view(parameters) {
        let monitor = place.iter().skip_while(|word| *word != "--monitor").take(2).cloned();
        return std::iter::once("--viewer=image_view".to_owned()).chain(monitor).collect();
    }
    match parameters.get("/camera_stream/window").filter(|value| *value != "none") {
        None => vec!["--viewer=none".to_owned()],
        // `~window` has them all.
        Some(Value::Array(_)) => Vec::new(),
        Some(monitor) => vec![format!("--window={}", text(monitor))],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_of_a_launch_file_are_told_from_remappings_and_private_parameters() {
        let is_given = |word: &str| is_launch_argument(&word.into());
        assert!(is_given("monitor:=HDMI-1") && is_given("rviz_config:=/a/scene.rviz"));
        for word in ["doctor", "--listen", "-d", "/a:=/b", "~a:=b", "_web:=8080", "__name:=x"] {
            assert!(!is_given(word), "{word}");
        }
    }

    #[test]
    fn the_nodes_arguments_and_remappings_follow_its_program() {
        let printed = "ROS_MASTER_URI=\"http://robot:11311/\" nice /opt/lib/rviz_camera_stream/camera_stream \
                       -d /a/camera_stream /proj_view/image:=/wall/image __name:=camera_stream\n";
        let expected = ["-d", "/a/camera_stream", "/proj_view/image:=/wall/image", "__name:=camera_stream"];
        assert_eq!(words_of(printed, NODE), expected);
    }

    #[test]
    fn parameters_keep_their_types() {
        let dumped = "/camera_stream/blend_gamma: 2.2\n/camera_stream/lazy: true\n/camera_stream/stale_timeouts:\n\
                      - limit: held\n  topic: /plan\n/camera_stream/web: '8080'\n/camera_streams/a: 1\n/projector/a: 1";
        let parameters: Parameters = serde_yaml_ng::from_str(dumped).unwrap();
        let expected = [
            "_blend_gamma:=2.2",
            "_lazy:=true",
            r#"_stale_timeouts:=[{"limit":"held","topic":"/plan"}]"#,
            r#"_web:="8080""#,
        ];
        assert_eq!(private_arguments(&parameters).collect::<Vec<_>>(), expected);
        let (_, text) = expected[2].split_once(":=").unwrap();
        let read: Value = serde_yaml_ng::from_str(text).unwrap();
        assert_eq!(Some(&read), parameters.get("/camera_stream/stale_timeouts"), "arguments are read as YAML");
    }

    #[test]
    fn the_viewer_is_the_one_that_the_launch_file_starts() {
        let viewer_of = |dumped: &str| {
            let place = words_of("/a/projector_window --place title --monitor DP-1 __name:=x", "/projector_window");
            viewer(&serde_yaml_ng::from_str(dumped).unwrap(), &place).join(" ")
        };
        let none = "/camera_stream/window: none\n";
        let with = |other: &str| viewer_of(&format!("{none}{other}"));
        assert_eq!(with("/projector_window/monitor: 1"), "--viewer=projector_window --monitor=1");
        assert_eq!(with("/image_view/window_name: title"), "--viewer=image_view --monitor DP-1");
        assert_eq!(with(""), "--viewer=none");
        assert_eq!(viewer_of("/camera_stream/window: HDMI-1"), "--window=HDMI-1");
        assert_eq!(viewer_of("/camera_stream/window: [{camera: A, monitor: DP-1}]"), "");
    }

    #[test]
    fn a_program_that_is_missing_hangs_or_fails_is_an_error_with_its_reason() {
        let run = |program: &str, arguments: &[&str], timeout_secs: &str| {
            let printed = output(program, arguments.iter().map(OsStr::new), timeout_secs);
            printed.unwrap_or_else(|error| error.to_string())
        };
        assert_eq!(run("echo", &["words"], "10"), "words\n");
        assert!(run("/nowhere/roslaunch", &[], "10").starts_with("cannot run /nowhere/roslaunch: not found; source"));
        assert_eq!(run("sleep", &["10"], "0.1"), "sleep has not ended within 0.1 s");
        let failing = "printf 'Traceback:\\n  in line 1\\n\\033[31mno such\\n file\\033[0m' >&2; exit 1";
        assert_eq!(run("sh", &["-c", failing], "10"), "sh failed: no such file");
        assert_eq!(run("sh", &["-c", "echo 'cannot load' >&2"], "10"), "sh failed: cannot load", "nothing is printed");
    }
}
