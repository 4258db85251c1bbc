//! `scripts/environment`: a workspace that the shell has sourced does not reach what the scripts build with.

use std::fs;
use std::process::Command;

use rcs_tests::programs::repository;

use crate::options::scripts;
use crate::{bash_command, printed_by};

/// What a script sees, with these folders of a sourced workspace in front of what there is.
fn seen(workspace: Option<&str>) -> String {
    let print = "for name in PATH CMAKE_PREFIX_PATH ROS_PACKAGE_PATH ROSRUST_MSG_PATH PKG_CONFIG_PATH; do\n\
                 echo \"$name=${!name-not set}\"\ndone";
    let mut command = bash_command(print);
    if let Some(at) = workspace {
        // As `devel/setup.bash` has them.
        for (name, folder) in [
            ("CMAKE_PREFIX_PATH", "devel"),
            ("ROS_PACKAGE_PATH", "src"),
            ("ROSRUST_MSG_PATH", "src"),
            ("PKG_CONFIG_PATH", "devel/lib/pkgconfig"),
        ] {
            let before = std::env::var(name).map_or(String::new(), |value| format!(":{value}"));
            command.env(name, format!("{at}/{folder}{before}"));
        }
    }
    let output = command.output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{}", printed_by(&output));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_sourced_workspace_changes_nothing_for_the_scripts() {
    let folder = tempfile::tempdir().unwrap();
    for made in ["devel/lib/pkgconfig", "devel/share", "src"] {
        fs::create_dir_all(folder.path().join(made)).unwrap();
    }
    let workspace = folder.path().to_str().unwrap();
    let with = seen(Some(workspace));
    assert!(!with.contains(workspace), "{with}");
    assert_eq!(with, seen(None));
}

#[test]
fn of_the_installed_ros_the_last_of_ros_1_counts_whatever_its_name_is() {
    let folder = tempfile::tempdir().unwrap();
    for (name, version) in [("melodic", "1"), ("noetic", "1"), ("novel", "2"), ("zest", "2"), ("zero", "")] {
        fs::create_dir_all(folder.path().join(name)).unwrap();
        let setup = format!("export SEEN=\"$SEEN {name}\"\n[ -z '{version}' ] || export ROS_VERSION={version}\n");
        fs::write(folder.path().join(name).join("setup.bash"), setup).unwrap();
    }
    let text = fs::read_to_string(repository().join("scripts/environment")).unwrap();
    let here = folder.path().to_str().unwrap();
    let script = format!("set -eu\nSEEN=\n{}\necho \"$SEEN${{ros_version-}}\"", text.replace("/opt/ros", here));
    let command = |script: &str| {
        let mut command = Command::new("bash");
        command.args(["-c", script]).env_remove("ROS_DISTRO").env_remove("ROS_PACKAGE_PATH").env("ROS_VERSION", "2");
        String::from_utf8(command.output().unwrap().stdout).unwrap()
    };
    assert_eq!(command(&script), " melodic noetic\n");
}

#[test]
fn every_script_that_builds_or_installs_sources_the_environment() {
    let builds = |line: &str| {
        ["cargo ", "cmake ", "scripts/install_dependencies", "scripts/build_rviz_plugin"]
            .iter()
            .any(|start| line.trim_start().starts_with(start))
    };
    let mut checked = 0;
    for script in scripts(&repository()) {
        let text = fs::read_to_string(repository().join(&script)).unwrap();
        if text.starts_with("#!/bin/bash") && text.lines().any(builds) {
            assert!(
                text.lines().any(|line| line.starts_with("source ") && line.contains("scripts/environment")),
                "{script}"
            );
            checked += 1;
        }
    }
    assert!(checked >= 8, "{checked} scripts");
}
