//! All programs in one: a package holds one binary, and a link to it for each program, named as the program.
//!
//! Nine programs that each hold the same libraries are three times as large as one that holds all nine. Which one is
//! meant is the name by which it is started (`argv[0]`), as with busybox.

use std::ffi::OsStr;
use std::path::Path;
use std::process::ExitCode;

/// A program's `main`.
pub type Main = fn() -> ExitCode;

/// Every program, with its name.
pub const PROGRAMS: [(&str, Main); 9] = [
    ("camera_stream", rcs_camera_stream::main),
    ("line_of_sight", rcs_samples::line_of_sight::main),
    ("nav_path_markers", rcs_samples::nav_path_markers::main),
    ("projector", crate::projector::main),
    ("projector_blend", crate::projector_blend::main),
    ("projector_calibrate", rcs_calibrate::main),
    ("projector_window", crate::projector_window::main),
    ("publish_cloud", rcs_samples::publish_cloud::main),
    ("turret_aim", rcs_samples::turret_aim::main),
];

/// The exit status where no program has the name.
const UNKNOWN: u8 = 2;

/// Runs the program by whose name the process was started.
pub fn main() -> ExitCode {
    let path = std::env::args_os().next().unwrap_or_default();
    match called(&path) {
        Some(program) => program(),
        None => {
            let names: Vec<&str> = PROGRAMS.iter().map(|(name, _)| *name).collect();
            eprintln!(
                "{}: this file holds all programs; start it through a link with the name of one: {}",
                Path::new(&path).display(),
                names.join(", ")
            );
            ExitCode::from(UNKNOWN)
        }
    }
}

/// The program that `path`, the first of a process's arguments, names.
fn called(path: &OsStr) -> Option<Main> {
    let name = Path::new(path).file_name()?;
    PROGRAMS.iter().find(|(program, _)| name == *program).map(|(_, main)| *main)
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
        assert_eq!(names, PROGRAMS.map(|(name, _)| name));
    }
}
