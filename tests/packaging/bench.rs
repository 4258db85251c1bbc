//! The command `./bench`, without measuring: its arguments, and the programs that it would measure.

use std::fs;
use std::path::Path;

use crate::{bash, printed_by, succeed};

#[test]
fn unusable_arguments_are_refused_and_nothing_is_installed() {
    for (arguments, word) in [
        ("--nope", "unrecognized arguments: --nope"),
        ("--only colours", "there is no colours"),
        ("--seconds 0", "0 is not a positive number"),
    ] {
        let output = bash(&format!("./bench {arguments}"));
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", printed_by(&output));
        assert!(output.stdout.is_empty() && printed_by(&output).contains(word), "{}", printed_by(&output));
    }
}

/// A package with nothing but its description.
fn write_package(folder: &Path, name: &str, rest: &str) {
    let head = format!("<name>{name}</name><version>1.0.0</version><description>{name}</description>");
    let people = "<maintainer email=\"nobody@example.org\">nobody</maintainer><license>BSD</license>";
    fs::create_dir_all(folder.join(name)).unwrap();
    let file = folder.join(name).join("package.xml");
    fs::write(file, format!("<package format=\"2\">{head}{people}{rest}</package>")).unwrap();
}

#[test]
fn the_plugin_of_a_sourced_workspace_is_found() {
    let folder = tempfile::tempdir().unwrap();
    // Stands for rviz where that is not installed.
    write_package(folder.path(), "rviz", "");
    fs::copy("/bin/true", folder.path().join("rviz/rviz")).unwrap();
    let rest = r#"<depend>rviz</depend><export><rviz plugin="${prefix}/plugin.xml"/></export>"#;
    write_package(folder.path(), "camera_plugin", rest);
    let plugin = r#"<library path="lib/camera"><class name="rviz_camera_stream/CameraPub" type="Camera"/></library>"#;
    fs::write(folder.path().join("camera_plugin/plugin.xml"), plugin).unwrap();

    let workspace = folder.path().display();
    let sourced =
        format!("ROS_PACKAGE_PATH={workspace}${{ROS_PACKAGE_PATH:+:$ROS_PACKAGE_PATH}} PATH=$PATH:{workspace}/rviz");
    assert_eq!(succeed(&format!("{sourced} ./bench --list --renderers cpu")), "camera_stream, cpu\nrviz\n");
}
