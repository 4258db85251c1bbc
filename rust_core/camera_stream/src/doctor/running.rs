//! The nodes `camera_stream` that run on this computer, from the processes in `/proc`, so that `doctor` without
//! arguments examines the one that runs.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::OsStringExt as _;
use std::path::{Path, PathBuf};

const PROGRAM: &str = "camera_stream";
const MASTER: &str = "ROS_MASTER_URI";
const DEFAULT_MASTER: &str = "http://localhost:11311";
const NAMESPACE: &str = "ROS_NAMESPACE";

/// A running node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RunningNode {
    pub(super) pid: u32,
    /// Its arguments and remappings.
    pub(super) arguments: Vec<OsString>,
    /// The folder to which its relative paths belong.
    pub(super) folder: PathBuf,
    /// Its ROS_NAMESPACE.
    pub(super) namespace: Option<String>,
}

/// The nodes of this process's master whose processes this user may inspect.
pub(super) fn nodes() -> Vec<RunningNode> {
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let master = std::env::var(MASTER).unwrap_or_else(|_| DEFAULT_MASTER.to_owned());
    processes.filter_map(|process| node(&process.path(), &master)).collect()
}

/// The node of a process; `None` for other programs and masters, and for commands such as `camera_stream doctor`.
fn node(process: &Path, master: &str) -> Option<RunningNode> {
    let pid = process.file_name()?.to_str()?.parse().ok()?;
    let mut words = texts(&process.join("cmdline"))?.into_iter();
    let program = words.next()?;
    if Path::new(&program).file_name() != Some(OsStr::new(PROGRAM)) {
        return None;
    }
    // The log file is the node's own.
    let arguments: Vec<OsString> = words.filter(|word| !word.to_string_lossy().starts_with("__log:=")).collect();
    let command = crate::cli::command();
    let is_command = |word: &OsString| command.get_subcommands().any(|known| word.to_str() == Some(known.get_name()));
    // A node has options and remappings alone; the child with a node's black window has a word.
    let is_word = |word: &OsString| !word.to_string_lossy().starts_with('-') && !word.to_string_lossy().contains(":=");
    if arguments.first().is_none_or(is_word) || arguments.iter().any(is_command) {
        return None;
    }
    let environment = texts(&process.join("environ"))?;
    let variable = |name: &str| {
        let value = |text: &OsString| Some(text.to_str()?.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        environment.iter().find_map(value)
    };
    if variable(MASTER).as_deref().unwrap_or(DEFAULT_MASTER) != master {
        return None;
    }
    let (folder, namespace) = (fs::read_link(process.join("cwd")).ok()?, variable(NAMESPACE));
    Some(RunningNode { pid, arguments, folder, namespace })
}

/// The texts of a file of `/proc`, each of which ends with a zero byte.
fn texts(file: &Path) -> Option<Vec<OsString>> {
    let bytes = fs::read(file).ok()?;
    let texts = bytes.split(|byte| *byte == 0).map(|text| OsString::from_vec(text.to_vec()));
    let mut texts: Vec<OsString> = texts.collect();
    texts.pop();
    Some(texts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_told_from_commands_and_other_programs() {
        let folder = tempfile::tempdir().unwrap();
        let process = folder.path().join("17");
        fs::create_dir(&process).unwrap();
        fs::write(process.join("environ"), "HOME=/root\0ROS_NAMESPACE=/left\0ROS_MASTER_URI=http://a:1\0").unwrap();
        std::os::unix::fs::symlink("/home/robot", process.join("cwd")).unwrap();
        let node_of = |cmdline: &str| {
            fs::write(process.join("cmdline"), cmdline).unwrap();
            node(&process, "http://a:1")
        };
        let expected = RunningNode {
            pid: 17,
            arguments: ["-d", "a.rviz", "__name:=x"].map(OsString::from).to_vec(),
            folder: "/home/robot".into(),
            namespace: Some("/left".to_owned()),
        };
        let found = node_of("/opt/lib/camera_stream\0-d\0a.rviz\0__name:=x\0__log:=/tmp/x.log\0");
        assert_eq!(found, Some(expected));
        for other in [
            "/opt/lib/camera_stream\0doctor\0",
            "/opt/lib/camera_stream\0__black-window\0--monitor\0",
            "/opt/lib/projector\0-d\0a.rviz\0",
            "",
        ] {
            assert_eq!(node_of(other), None, "{other:?}");
        }
        fs::write(process.join("cmdline"), "camera_stream\0-d\0a.rviz\0").unwrap();
        assert_eq!(node(&process, DEFAULT_MASTER), None, "of another master");
    }
}
