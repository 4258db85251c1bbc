//! The folder that `camera_stream setup` writes, started by `roslaunch`.

use std::path::Path;
use std::process::{Command, Stdio};

use rcs_tests::programs::program;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, PATIENCE};

use crate::launch::{image, Launched};

/// Writes a folder from flags alone.
fn setup(folder: &Path, options: &[&str]) {
    let mut command = Command::new(program("camera_stream"));
    // Nobody answers at this address, and there is no display.
    command.env("ROS_MASTER_URI", "http://127.0.0.1:9").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let output = command.arg("setup").arg(folder).args(options).stdin(Stdio::null()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_first_image_appears_without_perception() {
    let folder = tempfile::tempdir().unwrap();
    setup(folder.path(), &["--profile", "fixed", "--size", "640x400", "--try"]);
    let master = RosMaster::start().unwrap();
    let file = folder.path().join("projection.launch");
    let launched = Launched::run(&master, &format!("{} viewer:=none renderer:=cpu", file.display()));
    let image = image(&master, "/proj_view/image", &launched);
    assert!(image.contains("height: 400\nwidth: 640") && image.contains("frame_id: \"proj_view\""), "{image}");
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run("view = Viewer('/proj_view/image')").unwrap();
    let lit = "view.last is not None and sum(view.pixel(u, 100)[2] > 200 for u in range(640)) > 20";
    assert!(python.wait_for(PATIENCE, lit), "{:?}", launched.roslaunch.errors());
    // Nothing ages out, though no data ever come.
    std::thread::sleep(std::time::Duration::from_secs(3));
    assert!(python.wait_for(PATIENCE, lit), "{:?}", launched.roslaunch.errors());
}

#[test]
fn the_launch_files_of_all_profiles_are_accepted_by_roslaunch() {
    let options: [&[&str]; 3] = [
        &["--profile", "fetch"],
        &["--profile", "mobile", "--mount", "arm", "--image", "none", "--show", "/a=PointCloud2"],
        &["--profile", "two-computers", "--mount", "arm", "--try"],
    ];
    for options in options {
        let folder = tempfile::tempdir().unwrap();
        setup(folder.path(), &[options, &["--size", "640x400"]].concat());
        let master = RosMaster::start().unwrap();
        let file = folder.path().join("projection.launch");
        let launched = Launched::run(&master, &format!("{} viewer:=none renderer:=cpu", file.display()));
        let errors = || launched.roslaunch.errors();
        let is_drawing = || errors().iter().any(|line| line.contains("drawing CameraPub of "));
        assert!(wait_until(PATIENCE, is_drawing), "{options:?}: {:?} {:?}", launched.roslaunch.lines(), errors());
    }
}
