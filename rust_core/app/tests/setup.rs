//! `camera_stream setup` as a user runs it without a ROS master, a display or a terminal.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const FIXED: [&str; 5] = ["--profile", "fixed", "--size", "1280x800", "--try"];

fn setup(folder: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camera_stream"));
    // Nobody answers at this address.
    command.env("ROS_MASTER_URI", "http://127.0.0.1:9").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command.arg("setup").arg(folder).args(options).stdin(Stdio::null()).output().unwrap()
}

/// The error, which is one line, with the exit status.
fn refusal(folder: &Path, options: &[&str]) -> (Option<i32>, String) {
    let output = setup(folder, options);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.stdout.is_empty() && errors.trim_end().lines().count() == 1, "{errors}");
    (output.status.code(), errors)
}

#[test]
fn flags_alone_are_enough() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("deep/first");
    let output = setup(&folder, &FIXED);
    let warnings = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && warnings.lines().count() == 2, "{warnings}");
    assert!(warnings.contains("no ROS master answers") && warnings.contains("no display is open"), "{warnings}");
    let printed = String::from_utf8(output.stdout).unwrap();
    let names = ["projector.yaml", "scene.rviz", "projection.launch", "README.md"];
    let expected: String = names.iter().map(|name| format!("{}\n", folder.join(name).display())).collect();
    assert_eq!(printed, format!("{expected}next: roslaunch {}\n", folder.join("projection.launch").display()));
    assert_eq!(fs::read_dir(&folder).unwrap().count(), names.len());
    let checked =
        Command::new(env!("CARGO_BIN_EXE_camera_stream")).arg("check").arg(folder.join("scene.rviz")).output();
    let checked = checked.unwrap();
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
}

#[test]
fn nothing_is_written_until_all_answers_are_valid() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("first");
    let fixed = &FIXED[..4];
    for (options, part) in [
        (
            &fixed[..2],
            "answers missing: --size WxH, --image TOPIC|none, --depth TOPIC|none, --show TOPIC[=TYPE] or --try; ",
        ),
        (&[fixed, &["--image", "none", "--show", "/a", "/b"]].concat(), "write /a=TYPE; /b is published by nobody"),
    ] {
        let (status, error) = refusal(&folder, options);
        assert!(status == Some(2) && error.contains(part), "{part}: {error}");
    }
    for options in [["--show", "/a=Joy"], ["--mount", "a b"], ["--size", "wide"], ["--profile", "pr2"]] {
        assert_eq!(setup(&folder, &options).status.code(), Some(2), "{options:?}");
    }
    assert!(!folder.exists());
    let (status, error) = refusal(&folder.with_file_name("my first"), &FIXED);
    assert!(status == Some(2) && error.contains("contains ' '"), "{error}");
}

#[test]
fn files_are_replaced_only_when_that_is_wanted_and_a_calibration_never() {
    let folder = tempfile::tempdir().unwrap();
    assert!(setup(folder.path(), &FIXED).status.success());
    let (status, error) = refusal(folder.path(), &FIXED);
    assert_eq!(status, Some(1));
    assert!(error.contains("has files; choose another folder or give --overwrite"), "{error}");
    let calibrated = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/projector.yaml");
    fs::copy(calibrated, folder.path().join("projector.yaml")).unwrap();
    let output = setup(folder.path(), &[&FIXED[..], &["--fixed-frame", "odom", "--overwrite"]].concat());
    assert!(String::from_utf8(output.stdout).unwrap().contains("projector.yaml: kept, it is calibrated\n"));
    assert!(fs::read_to_string(folder.path().join("scene.rviz")).unwrap().contains("Fixed Frame: \"odom\""));
    fs::write(folder.path().join("projector.yaml"), "# A calibration that lost its end.\n").unwrap();
    let (status, error) = refusal(folder.path(), &[&FIXED[..], &["--overwrite"]].concat());
    assert!(status == Some(1) && error.contains("projector.yaml: "), "{error}");
}
