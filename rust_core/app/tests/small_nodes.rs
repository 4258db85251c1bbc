//! The programs `projector`, `projector_window`, `publish_cloud` and the samples as a user runs them, as far as no ROS
//! master and no display is needed: help, exit codes, errors that name the file, and an orderly shutdown while waiting
//! for a master.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

const PROJECTOR: &str = env!("CARGO_BIN_EXE_projector");
const WINDOW: &str = env!("CARGO_BIN_EXE_projector_window");
const CLOUD: &str = env!("CARGO_BIN_EXE_publish_cloud");
const PATH_MARKERS: &str = env!("CARGO_BIN_EXE_nav_path_markers");
const TURRET: &str = env!("CARGO_BIN_EXE_turret_aim");
const SIGHT: &str = env!("CARGO_BIN_EXE_line_of_sight");

const PROJECTOR_FILE: &str = "header: {frame_id: proj}\nwidth: 64\nheight: 48\nK: [50, 0, 32, 0, 50, 24, 0, 0, 1]\n";
const CLOUD_FILE: &str = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n";

/// A master that does not exist: port 9 (discard) answers nowhere.
const MASTER: &str = "http://127.0.0.1:9";
/// How long something may take that takes milliseconds on an idle machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A program with a master that does not exist and without a display.
fn program(path: &str) -> Command {
    let mut command = Command::new(path);
    command.env("ROS_MASTER_URI", MASTER).env("ROS_HOSTNAME", "127.0.0.1");
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    command
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A file with this name and content, in a folder that lives as long as the first value.
fn file(name: &str, content: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::File::create(&path).unwrap().write_all(content.as_bytes()).unwrap();
    let path = path.to_str().unwrap().to_owned();
    (folder, path)
}

#[test]
fn help_names_topics_and_exit_codes() {
    for (path, topic) in [
        (PROJECTOR, "/tf_static"),
        (WINDOW, "/proj_view/image"),
        (CLOUD, "cloud:="),
        (PATH_MARKERS, "nav_msgs/Path"),
        (TURRET, "/joint_states"),
        (SIGHT, "/collision_object"),
    ] {
        let output = program(path).arg("--help").output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(help.contains(topic) && help.contains("Exit codes"), "{help}");
    }
}

#[test]
fn help_and_version_name_the_program() {
    let camera_stream = env!("CARGO_BIN_EXE_camera_stream");
    for path in [camera_stream, PROJECTOR, WINDOW, CLOUD, PATH_MARKERS, TURRET, SIGHT] {
        let name = path.rsplit('/').next().unwrap();
        let text = |option| String::from_utf8(program(path).arg(option).output().unwrap().stdout).unwrap();
        assert_eq!(text("--version"), format!("rviz_camera_stream {}\n", env!("CARGO_PKG_VERSION")));
        assert!(text("--help").contains(&format!("Usage: {name} ")), "{}", text("--help"));
    }
}

#[test]
fn wrong_arguments_exit_with_2() {
    let cases: [(&str, &[&str]); 9] = [
        (PROJECTOR, &["a.yaml", "--file", "b.yaml"]),
        (WINDOW, &["--no-such-option"]),
        (CLOUD, &[]),
        (CLOUD, &["a.pcd", "--rate", "-1"]),
        (PATH_MARKERS, &["--color", "reddish"]),
        (TURRET, &["--target-frame", "cup", "--target-pose", "/cup"]),
        (TURRET, &["--target-frame", "cup", "--pan-joint", "pan"]),
        (TURRET, &["--target-frame", "cup", "--pixel", "1"]),
        (SIGHT, &["--target-frame", "cup", "--radius", "0"]),
    ];
    for (path, arguments) in cases {
        let output = program(path).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{path} {arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn a_wrong_file_is_one_line_that_names_it_and_exits_with_1_without_a_master() {
    let (_folder, projector) = file("projector.yaml", &PROJECTOR_FILE.replace("50, 24, 0, 0, 1", "50, 24"));
    let (_other, cloud) = file("cloud.pcd", &CLOUD_FILE.replace("1 2 3", "1 two 3"));
    let cases = [
        (PROJECTOR, projector, "line 4"),
        (PROJECTOR, "missing.yaml".to_owned(), "No such file"),
        (CLOUD, cloud, "line 7"),
        (CLOUD, "missing.pcd".to_owned(), "No such file"),
    ];
    for (path, file, reason) in cases {
        let output = program(path).arg(&file).output().unwrap();
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains(&file) && message.contains(reason), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    }
}

#[test]
fn a_projector_without_a_frame_is_refused_and_an_option_gives_one() {
    let (_folder, path) = file("projector.yaml", &PROJECTOR_FILE.replace("header: {frame_id: proj}\n", ""));
    let output = program(PROJECTOR).arg(&path).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = stderr(&output);
    assert!(message.contains(&path) && message.contains("--frame-id"), "{message}");
    ends_in_order(program(PROJECTOR).args([&path, "--frame-id", "proj"]), "-TERM");
}

#[test]
fn without_a_display_the_window_reports_that_and_exits_with_1() {
    for arguments in [&["--list-monitors"][..], &[]] {
        let output = program(WINDOW).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        let message = stderr(&output);
        assert!(message.contains("DISPLAY"), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    }
}

#[test]
fn signals_end_a_node_that_waits_for_a_master_with_0() {
    let (_folder, projector) = file("projector.yaml", PROJECTOR_FILE);
    let (_other, cloud) = file("cloud.pcd", CLOUD_FILE);
    ends_in_order(program(PROJECTOR).args(["--file", &projector, "__name:=other"]), "-INT");
    ends_in_order(program(CLOUD).args([&cloud, "cloud:=/objects"]), "-TERM");
    ends_in_order(&mut program(PATH_MARKERS), "-INT");
    ends_in_order(program(TURRET).args(["--target-frame", "cup"]), "-TERM");
    ends_in_order(program(SIGHT).args(["--target-frame", "cup"]), "-TERM");
}

#[test]
fn a_missing_master_is_logged_once() {
    let (_folder, projector) = file("projector.yaml", PROJECTOR_FILE);
    let mut node = Waiting::start(program(PROJECTOR).arg(&projector));
    node.wait_for_log(MASTER);
    node.wait_for_retries();
    assert_eq!(node.end("-TERM").code(), Some(0), "{}", node.log);
    assert_eq!(node.log.matches(MASTER).count(), 1, "{}", node.log);
}

/// Runs a program until it waits for a master, and ends it with a signal.
fn ends_in_order(command: &mut Command, signal: &str) {
    let mut node = Waiting::start(command);
    node.wait_for_log(MASTER);
    assert_eq!(node.end(signal).code(), Some(0), "{}", node.log);
}

/// A running program, with the lines of its standard error as they come.
struct Waiting {
    child: Child,
    lines: Receiver<String>,
    /// All lines so far.
    log: String,
}

impl Waiting {
    fn start(command: &mut Command) -> Self {
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let (sender, lines) = std::sync::mpsc::channel();
        let stderr = child.stderr.take().unwrap();
        std::thread::spawn(move || {
            for line in BufReader::new(stderr).lines() {
                if sender.send(line.unwrap()).is_err() {
                    return;
                }
            }
        });
        Self { child, lines, log: String::new() }
    }

    /// The next line, if one comes in time.
    fn next_line(&mut self, patience: Duration) -> Option<String> {
        let line = self.lines.recv_timeout(patience).ok()?;
        self.log += &format!("{line}\n");
        Some(line)
    }

    /// Waits for a line with this text.
    fn wait_for_log(&mut self, text: &str) {
        let deadline = Instant::now() + PATIENCE;
        while let Some(line) = self.next_line(deadline.saturating_duration_since(Instant::now())) {
            if line.contains(text) {
                return;
            }
        }
        panic!("{text} is not in the log: {}", self.log);
    }

    /// Waits until the node has looked for the master a few times more. A thread of its own does that and sleeps in
    /// between, and Linux counts how often a thread slept.
    fn wait_for_retries(&self) {
        let process = self.child.id().to_string();
        let sleeps = || -> u64 {
            let threads = std::fs::read_dir(format!("/proc/{process}/task")).unwrap().map(|thread| thread.unwrap());
            let others = threads.filter(|thread| *thread.file_name() != *process);
            let status = others.map(|thread| std::fs::read_to_string(thread.path().join("status")).unwrap());
            let count = |status: String| {
                let line = status.lines().find_map(|line| line.strip_prefix("voluntary_ctxt_switches:"));
                line.unwrap().trim().parse::<u64>().unwrap()
            };
            status.map(count).sum()
        };
        let (before, deadline) = (sleeps(), Instant::now() + PATIENCE);
        // A try may sleep once itself, so these are three tries at least.
        while sleeps() < before + 6 {
            assert!(Instant::now() < deadline, "the node does not look for the master again: {}", self.log);
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Sends a signal, and waits until the program has ended and all of its log is read.
    fn end(&mut self, signal: &str) -> ExitStatus {
        assert!(self.child.try_wait().unwrap().is_none(), "the program ended by itself: {}", self.log);
        let sent = Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let deadline = Instant::now() + PATIENCE;
        // The end of the log is the end of the program.
        while self.next_line(deadline.saturating_duration_since(Instant::now())).is_some() {}
        assert!(Instant::now() < deadline, "the program does not end after {signal}: {}", self.log);
        self.child.wait().unwrap()
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        // Only a test that fails leaves it running.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
