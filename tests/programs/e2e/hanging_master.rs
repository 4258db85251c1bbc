//! Programs at a master that hangs: a signal ends them, and a second one at once.

use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, CLOUD};
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::time::Duration;

use crate::viewers::{window, Screen};

const PROJECTOR: &str = "header: {frame_id: proj}\nwidth: 64\nheight: 48\nK: [50, 0, 32, 0, 50, 24, 0, 0, 1]\n";
const POINT: &str = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n";
const SIGNALS: [&str; 2] = ["TERM", "INT"];

/// The screen of a window and the files that the programs read.
struct Stage {
    screen: Screen,
    folder: tempfile::TempDir,
}

impl Stage {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("scene.rviz", &config(&[CLOUD], &[CameraPub::default()]));
        write("projector.yaml", PROJECTOR);
        write("points.pcd", POINT);
        Self { screen: Screen::start(), folder }
    }

    /// Starts the programs, each with the name of its node.
    fn start(&self, master: &RosMaster) -> [(&'static str, Running); 4] {
        let folder: &Path = self.folder.path();
        let start =
            |name: &str, args: &[&str]| Running::start(master.program(name).current_dir(folder).args(args)).unwrap();
        [
            ("camera_stream", start("camera_stream", &["-d", "scene.rviz", "--renderer", "cpu"])),
            ("projector", start("projector", &["--file", "projector.yaml"])),
            ("publish_cloud", start("publish_cloud", &["points.pcd", "--rate", "5"])),
            ("projector_window", window(master, &self.screen, &["image:=/view/image"])),
        ]
    }

    /// The same, with everything registered; then the master hangs, for longer than the time between two questions.
    fn running(&self, master: &RosMaster) -> [(&'static str, Running); 4] {
        let programs = self.start(master);
        let mut nodes = String::new();
        let are_known = || {
            nodes = master.output("rosnode", &["list"]).unwrap();
            programs.iter().all(|(name, _)| nodes.lines().any(|node| node == format!("/{name}")))
        };
        assert!(wait_until(PATIENCE, are_known), "{nodes}");
        master.signal("STOP");
        std::thread::sleep(Duration::from_secs(2));
        programs
    }
}

/// Ends programs one after the other.
fn end_with(signal: &str, programs: [(&str, Running); 4]) {
    for (name, mut program) in programs {
        let status = program.end(signal).unwrap();
        assert_eq!(status.code(), Some(0), "{name}: {:?}", program.errors());
    }
}

#[test]
fn a_signal_ends_programs_while_the_master_hangs() {
    let stage = Stage::new();
    for signal in SIGNALS {
        let master = RosMaster::start().unwrap();
        end_with(signal, stage.running(&master));
        master.signal("CONT");
    }
}

#[test]
fn a_signal_ends_programs_that_start_while_the_master_hangs() {
    let stage = Stage::new();
    let master = RosMaster::start().unwrap();
    master.signal("STOP");
    for signal in SIGNALS {
        let programs = stage.start(&master);
        std::thread::sleep(Duration::from_secs(2));
        end_with(signal, programs);
    }
    master.signal("CONT");
}

#[test]
fn a_second_signal_ends_programs_at_once_while_the_master_hangs() {
    let stage = Stage::new();
    let master = RosMaster::start().unwrap();
    for (name, mut program) in stage.running(&master) {
        let status = program.end_at_once("TERM", "INT").unwrap();
        assert!(status.signal().is_some(), "{name}: {status} {:?}", program.errors());
    }
    master.signal("CONT");
}
