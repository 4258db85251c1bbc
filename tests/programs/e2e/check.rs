//! `camera_stream check`: its lines and exit codes.

use rcs_tests::programs::{program, repository};
use rcs_tests::ros_fixture::{config, CameraPub, CLOUD};
use std::path::Path;
use std::process::{Command, Output};

fn check(file: &Path) -> Output {
    Command::new(program("camera_stream")).arg("check").arg(file).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn file(content: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.rviz");
    std::fs::write(&path, content).unwrap();
    (folder, path)
}

#[test]
fn a_valid_config_is_listed_with_class_topic_and_line_and_exits_with_0() {
    let disabled = "{Class: rviz/Axes, Name: off, Enabled: false}";
    let later = "{Class: rviz/InteractiveMarkers, Name: robot, Enabled: true, Update Topic: /robot/update}";
    let (_folder, path) = file(&config(&[CLOUD, disabled, later], &[CameraPub::default()]));
    let output = check(&path);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{printed}");
    let line = |words: &[&str]| printed.lines().filter(|line| words.iter().all(|word| line.contains(word))).count();
    assert_eq!(line(&["line    3", "rviz/PointCloud2", "drawn", "cloud", "/cloud"]), 1, "{printed}");
    assert_eq!(line(&["line    4", "rviz/Axes", "disabled", "off"]), 1, "{printed}");
    assert_eq!(line(&["line    6", "CameraPub", "camera", "/view/image"]), 1, "{printed}");
    assert_eq!(line(&["line    5", "rviz/InteractiveMarkers", "robot"]), 1, "{printed}");
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}

#[test]
fn a_file_that_cannot_be_read_is_one_line_and_exits_with_2() {
    let (_folder, broken) = file("Visualization Manager:\n  Displays: [\n");
    let (_other, none) = file("just: this\n");
    let (_new, ros_2) = file(
        "Panels: [{Class: rviz_common/Displays}]\n\
         Visualization Manager: {Displays: [{Class: rviz_default_plugins/Grid}]}\n",
    );
    for path in [broken.as_path(), none.as_path(), ros_2.as_path(), Path::new("/nowhere/scene.rviz"), &repository()] {
        let output = check(path);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.contains(&path.display().to_string()), "{error}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn what_changes_no_image_is_a_note_and_exits_with_0() {
    let off = "{Class: fancy_plugins/Hologram, Name: h, Enabled: false}";
    // As another version of rviz saved it.
    let odometry = "{Class: rviz/Odometry, Name: odom, Enabled: true, Topic: /odom, Length: 1}";
    for (view, note) in [("jsk_rviz_plugin/View", "jsk_rviz_plugin/View"), ("rviz/Orbit, Sparkle: 1", "Sparkle")] {
        let view = format!("  Views: {{Current: {{Class: {view}}}}}\n");
        let (_folder, path) = file(&(config(&[CLOUD, off, odometry], &[CameraPub::default()]) + &view));
        let output = check(&path);
        let printed = text_of_notes(&output);
        assert_eq!(output.status.code(), Some(0), "{printed:?}");
        let notes = ["fancy_plugins/Hologram", "odom / Length", note];
        assert!(printed.len() == 3 && printed.iter().zip(notes).all(|(line, note)| line.contains(note)), "{printed:?}");
    }
}

fn text_of_notes(output: &Output) -> Vec<String> {
    text(&output.stdout).lines().filter(|line| line.contains(": note: ")).map(str::to_owned).collect()
}

#[test]
fn cameras_and_displays_that_do_not_work_are_reported_and_exit_with_1() {
    let lost = CameraPub { info: "", ..CameraPub::default() };
    let other = CameraPub { image: "/other", ..CameraPub::default() };
    let misspelt = config(&[CLOUD], &[CameraPub::default()])
        .replace("Visibility: {Value: true}", "Visibility: {Value: true, clowd: false}");
    let with = |display: &str| config(&[CLOUD, display], &[CameraPub::default()]);
    let cases = [
        (config(&[CLOUD], &[]), "no CameraPub display"),
        (with("{Class: rviz/Grid, Name: g, Enabled: true, Sparkle: 3}"), "line 4: Displays / g / Sparkle"),
        (with("{Class: fancy_plugins/Hologram, Name: h, Enabled: true}"), "line 4: Displays / h: unknown class fancy_"),
        (config(&[CLOUD], &[lost]), "Camera Info Topic: empty"),
        (config(&[CLOUD], &[CameraPub::default(), CameraPub { namespace: "other", ..other }]), "same name"),
        (
            config(&[CLOUD], &[CameraPub::default()]) + SYNCHRONIZED,
            "Time / SyncMode: synchronization \"Exact\" to cloud",
        ),
        (config(&["{Class: rviz/PointCloud2, Name: it, Enabled: true, Topic: ''}"], &[other]), "its topic is empty"),
        (misspelt, "Visibility / clowd: no display has this name; there are: cloud"),
    ];
    for (content, word) in cases {
        let (_folder, path) = file(&content);
        let output = check(&path);
        let printed = text(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{printed}");
        let findings = printed.lines().filter(|line| line.starts_with(&*path.display().to_string()));
        let findings: Vec<&str> = findings.filter(|line| !line.contains("fixed frame")).collect();
        assert!(findings.len() == 1 && findings[0].contains(word), "{word}: {printed}");
    }
}

/// A window's panel that looks frames up at the times of a display's messages.
const SYNCHRONIZED: &str = "Panels:\n- {Class: rviz/Time, Name: Time, SyncMode: 1, SyncSource: cloud}\n";

#[test]
fn a_config_is_found_by_its_name_in_the_users_folder() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join(".rviz");
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(folder.join("scene.rviz"), config(&[CLOUD], &[CameraPub::default()])).unwrap();
    let check = |name: &str| {
        let mut command = Command::new(program("camera_stream"));
        command.current_dir(home.path()).env("HOME", home.path()).args(["check", name]).output().unwrap()
    };
    let output = check("scene");
    let named = folder.join("scene.rviz").display().to_string();
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).starts_with(&named), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains(&format!("config 'scene': reading {named}")), "{}", text(&output.stderr));
    let output = check("other");
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    let places = [format!("{}/other, ", folder.display()), format!("{}/other.rviz; ", folder.display())];
    assert!(error.contains("no file other, ") && places.iter().all(|place| error.contains(place)), "{error}");
}

#[test]
fn a_reader_that_has_read_enough_is_no_failure() {
    let (_folder, path) = file(&config(&[CLOUD; 5], &[CameraPub::default()]));
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = Command::new(program("camera_stream"));
    let output = command.arg("check").arg(&path).stdout(writer).output().unwrap();
    assert_eq!((output.status.code(), &*text(&output.stderr)), (Some(0), ""));
}
