//! `camera_stream new-camera` as a user runs it: what it prints, and what it does to a config.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::os::unix::fs::{symlink, PermissionsExt};
use std::path::Path;
use std::process::{Command, Output};

const CONFIG: &str =
    "# kept\nVisualization Manager:\n  Displays:\n    - Class: rviz/Grid\n      Name: Grid\n  Tools: []\n";

fn camera_stream(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_camera_stream")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn the_printed_block_is_a_display_to_paste() {
    let folder = tempfile::tempdir().unwrap();
    let output = camera_stream(folder.path(), &["new-camera", "--name", "Left", "--image-topic", "/left/image"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let block = text(&output.stdout);
    let pasted = CONFIG.replace("  Displays:\n", &format!("  Displays:\n{block}"));
    fs::write(folder.path().join("a.rviz"), pasted).unwrap();
    let checked = camera_stream(folder.path(), &["check", "a.rviz"]);
    let printed = text(&checked.stdout);
    assert!(checked.status.success() && printed.contains("Left") && printed.contains("/left/image"), "{printed}");
    assert!(block.contains("Display namespace: left\n"), "{block}");
}

#[test]
fn a_camera_is_added_to_a_config_and_all_else_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz");
    fs::write(&file, CONFIG).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("scene.rviz", folder.path().join("link.rviz")).unwrap();
    let output = camera_stream(folder.path(), &["new-camera", "-d", "link.rviz"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).starts_with("link.rviz: added camera Projector in line 4"),
        "{}",
        text(&output.stdout)
    );

    let extended = fs::read_to_string(&file).unwrap();
    let (head, tail) = CONFIG.split_at(CONFIG.find("    - Class").unwrap());
    assert!(extended.starts_with(head) && extended.ends_with(tail), "{extended}");
    assert!(fs::symlink_metadata(folder.path().join("link.rviz")).unwrap().is_symlink());
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no other file is left");
    assert!(camera_stream(folder.path(), &["check", "scene.rviz"]).status.success());

    // The same again is refused, and the file is as it was.
    for (arguments, option) in [(&[][..], "--name"), (&["--name", "Other"], "--image-topic")] {
        let arguments = [&["new-camera", "-d", "scene.rviz"], arguments].concat();
        let output = camera_stream(folder.path(), &arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.lines().count() == 1 && error.contains("line 4") && error.contains(option), "{error}");
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), extended);
}

#[test]
fn what_is_no_config_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("other.yaml"), "just: this\n").unwrap();
    for (file, word, status) in [("other.yaml", "Visualization Manager", 1), ("missing.rviz", "no config", 2)] {
        let output = camera_stream(folder.path(), &["new-camera", "-d", file]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{error}");
        assert!(error.lines().count() == 1 && error.contains(file) && error.contains(word), "{error}");
    }
    assert_eq!(camera_stream(folder.path(), &["new-camera", "--name", ""]).status.code(), Some(2));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
