//! The programs `projector`, `projector_window`, `publish_cloud` and the samples as a user runs them, as far as no ROS
//! master and no display is needed: help, exit codes, errors that name the file, and an orderly shutdown while waiting
//! for a master.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::ExitStatusExt as _;
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
const PATIENCE: Duration = Duration::from_secs(300);
/// A program that takes longer to end hangs: ten times what a slow machine needs.
const PROMPT: Duration = Duration::from_secs(20);

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
    let cases: [(&str, &[&str]); 8] = [
        (PROJECTOR, &["a.yaml", "--file", "b.yaml"]),
        (WINDOW, &["--no-such-option"]),
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
        (PROJECTOR, "missing.yaml".to_owned(), "no such file; relative to the folder"),
        (CLOUD, cloud, "line 7"),
        (CLOUD, "missing.pcd".to_owned(), "no such file; relative to the folder"),
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
    // The file may be a parameter.
    ends_in_order(&mut program(CLOUD), "-TERM");
    ends_in_order(&mut program(PATH_MARKERS), "-INT");
    ends_in_order(program(TURRET).args(["--target-frame", "cup"]), "-TERM");
    ends_in_order(program(SIGHT).args(["--target-frame", "cup"]), "-TERM");
}

#[test]
fn windows_that_wait_for_a_display_server_that_hangs_end() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("wayland-0");
    // Connections are taken by the system, and nobody answers.
    let _compositor = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    let x_server = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let display = format!("127.0.0.1:{}", x_server.local_addr().unwrap().port() - 6000);
    let calibrate = env!("CARGO_BIN_EXE_projector_calibrate");
    let cases: [(&str, &[&str], bool); 5] = [
        (WINDOW, &[], true),
        (WINDOW, &[], false),
        (WINDOW, &["--place", "any"], false),
        (calibrate, &["show", "--test", "grid"], true),
        (calibrate, &["show", "--test", "grid"], false),
    ];
    for (path, arguments, is_wayland) in cases {
        let mut command = program(path);
        match is_wayland {
            true => command.env("WAYLAND_DISPLAY", &socket),
            false => command.env("DISPLAY", &display),
        };
        let mut window = Waiting::start(command.current_dir(folder.path()).args(arguments));
        window.wait_for_thread("window-watch");
        assert_eq!(window.end("-TERM").code(), Some(0), "{path} {arguments:?}: {}", window.log);
        assert!(window.log.contains("the display server does not respond"), "{path} {arguments:?}: {}", window.log);
    }
}

/// A master that answers `getPid` and hangs in everything else, of which the channel is told.
fn hanging_master() -> (String, Receiver<()>) {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let uri = format!("http://{}", listener.local_addr().unwrap());
    let (hangs, is_hanging) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let mut silent = Vec::new();
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let (mut request, mut buffer) = (String::new(), [0; 4096]);
            while !request.contains("</methodCall>") {
                let count = std::io::Read::read(&mut stream, &mut buffer).unwrap();
                assert!(count > 0, "{request}");
                request += &String::from_utf8_lossy(&buffer[..count]);
            }
            if request.contains("getPid") {
                let values = "<value><int>1</int></value><value></value><value><int>1</int></value>";
                let array = format!("<value><array><data>{values}</data></array></value>");
                let xml = format!("<methodResponse><params><param>{array}</param></params></methodResponse>");
                write!(stream, "HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n{xml}", xml.len()).unwrap();
            } else {
                silent.push(stream);
                // Fails once the test has heard enough.
                let _ = hangs.send(());
            }
        }
    });
    (uri, is_hanging)
}

#[test]
fn programs_that_ask_a_master_that_hangs_are_ended_by_a_signal() {
    let (_folder, config) = file("scene.rviz", "Visualization Manager: {Displays: []}\n");
    let (_left, projector) = file("projector.yaml", PROJECTOR_FILE);
    let (_right, other) = file("other.yaml", PROJECTOR_FILE);
    let (_points, cloud) = file("cloud.pcd", CLOUD_FILE);
    let camera_stream = env!("CARGO_BIN_EXE_camera_stream");
    let cases: [(&str, &[&str]); 5] = [
        (camera_stream, &["check", "--live", &config]),
        (camera_stream, &["-d", &config, "--renderer", "cpu"]),
        (CLOUD, &[&cloud]),
        (env!("CARGO_BIN_EXE_projector_blend"), &[&projector, &other, "--topic", "/cloud"]),
        (PROJECTOR, &["--file", &projector]),
    ];
    for (path, arguments) in cases {
        let (uri, is_hanging) = hanging_master();
        let mut node = Waiting::start(program(path).env("ROS_MASTER_URI", uri).args(arguments));
        is_hanging.recv_timeout(PATIENCE).unwrap();
        std::thread::sleep(Duration::from_millis(500));
        assert!(node.end("-INT").code().is_some(), "{path}: {}", node.log);
    }
}

#[test]
fn a_second_signal_ends_a_program_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("wayland-0");
    let _compositor = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    for (path, arguments) in [(WINDOW, &[][..]), (env!("CARGO_BIN_EXE_projector_calibrate"), &["show"])] {
        let mut window = Waiting::start(program(path).env("WAYLAND_DISPLAY", &socket).args(arguments));
        window.wait_for_thread("window-watch");
        // Signals that wait at the same time are one.
        while window.child.try_wait().unwrap().is_none() {
            window.signal("-INT");
            std::thread::sleep(Duration::from_millis(100));
        }
        assert_eq!(window.child.wait().unwrap().signal(), Some(2), "{path}: {}", window.log);
    }
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

    /// Waits until the program has a thread of this name.
    fn wait_for_thread(&self, name: &str) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let threads = std::fs::read_dir(format!("/proc/{}/task", self.child.id())).unwrap();
            let mut names = threads.filter_map(|thread| std::fs::read_to_string(thread.ok()?.path().join("comm")).ok());
            if names.any(|found| found.trim_end() == name) {
                return;
            }
            assert!(Instant::now() < deadline, "no thread {name}: {}", self.log);
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn signal(&mut self, signal: &str) {
        assert!(self.child.try_wait().unwrap().is_none(), "the program ended by itself: {}", self.log);
        let sent = Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }

    /// Sends a signal, and waits until the program has ended and all of its log is read.
    fn end(&mut self, signal: &str) -> ExitStatus {
        let begin = Instant::now();
        self.signal(signal);
        // The end of the log is the end of the program.
        while self.next_line(PROMPT.saturating_sub(begin.elapsed())).is_some() {}
        println!("ends {:.1?} after {signal}", begin.elapsed());
        assert!(begin.elapsed() < PROMPT, "the program does not end after {signal}: {}", self.log);
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
