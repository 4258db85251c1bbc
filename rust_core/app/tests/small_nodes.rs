//! The programs `projector`, `projector_window` and `publish_cloud` as a user runs them, as far as no ROS master and no
//! display is needed: help, exit codes, errors that name the file, and an orderly end while waiting for a master.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::Write;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const PROJECTOR: &str = env!("CARGO_BIN_EXE_projector");
const WINDOW: &str = env!("CARGO_BIN_EXE_projector_window");
const CLOUD: &str = env!("CARGO_BIN_EXE_publish_cloud");

const PROJECTOR_FILE: &str = "header: {frame_id: proj}\nwidth: 64\nheight: 48\nK: [50, 0, 32, 0, 50, 24, 0, 0, 1]\n";
const CLOUD_FILE: &str = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n";

/// A program with a master that does not exist and without a display.
fn program(path: &str) -> Command {
    let mut command = Command::new(path);
    // Port 9 (discard) answers nowhere.
    command.env("ROS_MASTER_URI", "http://127.0.0.1:9").env("ROS_HOSTNAME", "127.0.0.1");
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
    for (path, topic) in [(PROJECTOR, "/tf_static"), (WINDOW, "/proj_view/image"), (CLOUD, "cloud:=")] {
        let output = program(path).arg("--help").output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(help.contains(topic) && help.contains("Exit codes"), "{help}");
    }
}

#[test]
fn wrong_arguments_exit_with_2() {
    let cases: [(&str, &[&str]); 4] = [
        (PROJECTOR, &["a.yaml", "--file", "b.yaml"]),
        (WINDOW, &["--no-such-option"]),
        (CLOUD, &[]),
        (CLOUD, &["a.pcd", "--rate", "-1"]),
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
fn without_a_display_the_window_says_so_and_exits_with_1() {
    for arguments in [&["--list-monitors"][..], &[]] {
        let output = program(WINDOW).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        let message = stderr(&output);
        assert!(message.contains("DISPLAY"), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    }
}

#[test]
fn waiting_for_a_master_is_said_once_and_signals_end_it_with_0() {
    let (_folder, projector) = file("projector.yaml", PROJECTOR_FILE);
    let (_other, cloud) = file("cloud.pcd", CLOUD_FILE);
    ends_in_order(program(PROJECTOR).args(["--file", &projector, "__name:=other"]), "-INT");
    ends_in_order(program(CLOUD).args([&cloud, "cloud:=/objects"]), "-TERM");
}

/// Runs a program that waits for a master, ends it with a signal, and looks at what it said.
fn ends_in_order(command: &mut Command, signal: &str) {
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    sleep(Duration::from_millis(700));
    assert!(child.try_wait().unwrap().is_none(), "the program waits");
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let deadline = Instant::now() + Duration::from_secs(10);
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > deadline {
            child.kill().unwrap();
            panic!("the program does not end after {signal}");
        }
        sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let message = stderr(&output);
    let said = message.matches("http://127.0.0.1:9").count();
    assert_eq!(said, 1, "{message}");
}
