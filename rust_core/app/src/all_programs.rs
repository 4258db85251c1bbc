//! All programs in one: a package holds one binary, and a link to it for each program, named as the program.
//!
//! Programs that each hold the same libraries are three times as large as one that holds all. Which one is
//! meant is the name by which it is started (`argv[0]`), as with busybox.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::ExitCode;

use clap::Command;
use rcs_node_support::ros_names::RosName;
use rcs_samples::{line_of_sight, nav_path_markers, publish_cloud, simulate_scan, turret_aim};

use crate::{help_files, projector, projector_blend, projector_window};

/// A program.
pub struct Program {
    /// Its name.
    pub name: &'static str,
    /// Runs it with the process's arguments.
    pub main: fn() -> ExitCode,
    /// Its command line.
    pub command: fn() -> Command,
    /// Topics, services and parameters that it uses.
    pub ros_names: &'static [RosName],
    /// Whether its options are private parameters, too.
    pub has_parameters: bool,
}

/// A node, whose options are private parameters, too.
const fn node(
    name: &'static str,
    main: fn() -> ExitCode,
    command: fn() -> Command,
    ros_names: &'static [RosName],
) -> Program {
    Program { name, main, command, ros_names, has_parameters: true }
}

/// Every program.
pub static PROGRAMS: [Program; 10] = [
    node("camera_stream", rcs_camera_stream::main, rcs_camera_stream::cli::command, rcs_camera_stream::cli::ROS_NAMES),
    node("line_of_sight", line_of_sight::main, line_of_sight::command, line_of_sight::ROS_NAMES),
    node("nav_path_markers", nav_path_markers::main, nav_path_markers::command, nav_path_markers::ROS_NAMES),
    node("projector", projector::main, projector::command, projector::ROS_NAMES),
    Program {
        name: "projector_blend",
        main: projector_blend::main,
        command: projector_blend::command,
        ros_names: projector_blend::ROS_NAMES,
        has_parameters: false,
    },
    Program {
        name: "projector_calibrate",
        main: rcs_projector_calibrate::main,
        command: rcs_projector_calibrate::command,
        ros_names: rcs_projector_calibrate::ROS_NAMES,
        has_parameters: false,
    },
    node("projector_window", projector_window::main, projector_window::command, projector_window::ROS_NAMES),
    node("publish_cloud", publish_cloud::main, publish_cloud::command, publish_cloud::ROS_NAMES),
    Program {
        name: "simulate_scan",
        main: simulate_scan::main,
        command: simulate_scan::command,
        ros_names: simulate_scan::ROS_NAMES,
        has_parameters: false,
    },
    node("turret_aim", turret_aim::main, turret_aim::command, turret_aim::ROS_NAMES),
];

/// The exit status where no program has the name.
const UNKNOWN: u8 = 2;

/// Runs the program by whose name the process was started; by another name, it only writes man pages and completions.
pub fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let path = arguments.first().map_or(OsStr::new(""), OsString::as_os_str);
    if let Some(program) = called(path) {
        return (program.main)();
    }
    if let [_, option, share] = arguments.as_slice() {
        if option == "--write-help" {
            let programs = PROGRAMS.iter().map(|program| (program.name, (program.command)()));
            return help_files::main(Path::new(share), programs);
        }
    }
    let names: Vec<&str> = PROGRAMS.iter().map(|program| program.name).collect();
    eprintln!(
        "{}: this file holds all programs; start it through a link with the name of one: {}",
        Path::new(path).display(),
        names.join(", ")
    );
    ExitCode::from(UNKNOWN)
}

/// The program that `path`, the first of a process's arguments, names.
fn called(path: &OsStr) -> Option<&'static Program> {
    let name = Path::new(path).file_name()?;
    PROGRAMS.iter().find(|program| name == program.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_is_found_by_the_last_part_of_its_path() {
        for path in ["turret_aim", "./turret_aim", "/opt/ros/noetic/lib/rviz_camera_stream/turret_aim"] {
            assert!(called(OsStr::new(path)).is_some(), "{path}");
        }
        for path in ["", "/", "programs", "turret_aim/x", "turret_aim.old"] {
            assert!(called(OsStr::new(path)).is_none(), "{path}");
        }
    }

    #[test]
    fn every_program_of_its_own_is_among_them() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/bin");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut names: Vec<String> = files.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
        names.retain(|name| name != "all_programs");
        names.sort();
        assert!(names.iter().eq(PROGRAMS.iter().map(|program| program.name)), "{names:?}");
    }
}
