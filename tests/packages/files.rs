//! The files that a user runs and copies are valid: configs, projector files, the sample scene, the README.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use rcs_files::projector::ProjectorFile;
use rcs_rviz_config::DisplaySettings;
use rcs_tests::programs::{program, repository};

use crate::{printed_by, succeed};

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(repository().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let found: Vec<_> = entries.filter(|path| path.extension().is_some_and(|found| found == extension)).collect();
    assert!(!found.is_empty(), "{folder} has no .{extension}");
    found
}

#[test]
fn the_programs_have_the_packages_version() {
    let package = fs::read_to_string(repository().join("ros_pkg/package.xml")).unwrap();
    let version = package.split("<version>").nth(1).unwrap().split("</version>").next().unwrap();
    for name in crate::catkin::PROGRAMS {
        let printed = printed_by(&Command::new(program(name)).arg("--version").output().unwrap());
        assert_eq!(printed.trim(), format!("rviz_camera_stream {version}"), "{name}");
    }
}

#[test]
fn rosdep_installs_neither_rviz_nor_image_view_unless_the_plugin_is_asked_for() {
    let package = fs::read_to_string(repository().join("ros_pkg/package.xml")).unwrap();
    for name in ["rviz", "image_view", "image_transport", "qtbase5-dev", "opengl"] {
        let hard = ["build_depend", "exec_depend", "depend"].map(|kind| format!("<{kind}>{name}</{kind}>"));
        assert!(hard.iter().all(|dependency| !package.contains(dependency)), "{name}");
    }
    // rviz finds the plugin by it.
    assert!(package.contains("<build_depend condition=\"$RVIZ_CAMERA_STREAM_PLUGIN == ON\">rviz</build_depend>"));
}

#[test]
fn every_config_is_understood() {
    for config in [files("config", "rviz"), files("rviz", "rviz")].concat() {
        let output = Command::new(program("camera_stream")).arg("check").arg(&config).output().unwrap();
        let printed = printed_by(&output);
        if config.ends_with("demo_window.rviz") {
            // It is for rviz's window, which shows the cameras' images: that it has none is all there is to report.
            let reports =
                printed.lines().skip(1).filter(|line| !line.trim().is_empty() && !line.starts_with("  line "));
            let reports: Vec<&str> = reports.collect();
            assert!(matches!(reports[..], [one] if one.contains("no CameraPub display")), "{printed}");
        } else {
            assert!(output.status.success(), "{printed}");
        }
    }
}

#[test]
fn the_old_packages_config_has_its_cameras_and_displays() {
    let config = rcs_rviz_config::load(&repository().join("config/rviz_camera_stream.rviz")).unwrap();
    let placed = config.placed_displays();
    let cameras: Vec<_> = placed
        .iter()
        .filter_map(|placed| match &placed.display.settings {
            DisplaySettings::CameraPub(camera) => Some((&*camera.image_topic, &*camera.camera_info_topic)),
            _ => None,
        })
        .collect();
    let expected = [("/rviz1/camera1/image", "/camera1/camera_info"), ("/rviz1/camera2/image", "/camera2/camera_info")];
    assert_eq!(cameras, expected);
    for class in ["rviz/Grid", "rviz/Axes", "rviz/TF"] {
        assert!(placed.iter().any(|placed| placed.enabled && placed.display.class == class), "{class}");
    }
}

#[test]
fn every_key_of_the_projector_files_is_read() {
    for file in files("config", "yaml") {
        let projector = ProjectorFile::read(&file).unwrap();
        assert_eq!(projector.ignored_keys, Vec::<String>::new(), "{}", file.display());
        assert!(!projector.camera_info.header.frame_id.is_empty(), "{}", file.display());
        let frame_id = &projector.camera_info.header.frame_id;
        if file.ends_with("turret_projector.yaml") {
            // Its frames are those of the robots' descriptions.
            assert_eq!(projector.frames.len(), 0);
            let is_turret = |robot: &PathBuf| robot.to_string_lossy().contains("turret");
            for robot in files("ros_pkg/urdf", "urdf").into_iter().filter(is_turret) {
                assert!(fs::read_to_string(robot).unwrap().contains(&format!("<link name=\"{frame_id}\"")));
            }
        } else {
            let placed = projector.frames.last().map(|frame| frame.child.clone());
            assert_eq!(placed.as_ref(), Some(frame_id), "{}", file.display());
        }
    }
}

#[test]
fn the_demos_cameras_are_those_of_the_old_package() {
    for (file, size, focal_length) in [("camera1.yaml", (640, 480), 500.0), ("camera2.yaml", (1280, 720), 300.0)] {
        let info = ProjectorFile::read(&repository().join("config").join(file)).unwrap().camera_info;
        assert_eq!((info.width, info.height), size);
        assert_eq!((info.P[0], info.P[5]), (focal_length, focal_length));
    }
}

#[test]
fn the_fetch_projector_is_mounted_on_its_torso() {
    let projector = ProjectorFile::read(&repository().join("config/fetch_projector.yaml")).unwrap();
    let frames: Vec<_> = projector.frames.iter().map(|frame| (&*frame.parent, &*frame.child)).collect();
    assert_eq!(frames, [("torso_lift_link", "proj_link"), ("proj_link", "proj_view")]);
}

#[test]
fn the_sample_scene_is_what_its_script_makes() {
    let folder = tempfile::tempdir().unwrap();
    succeed(&format!("scripts/make_demo_scene {}", folder.path().display()));
    let committed = repository().join("config/demo");
    for entry in fs::read_dir(&committed).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap();
        let made = fs::read(folder.path().join(name)).unwrap();
        assert!(made == fs::read(&path).unwrap(), "{} is not what scripts/make_demo_scene writes", path.display());
    }
}

#[test]
fn the_readmes_image_is_what_the_demo_draws() {
    let folder = tempfile::tempdir().unwrap();
    let drawn = folder.path().join("demo.png");
    succeed(&format!("./demo --offline --renderer cpu --output {}", drawn.display()));
    assert!(pixels(&drawn) == pixels(&repository().join("docs/images/demo.png")), "draw it again: ./demo --offline");
}

/// Width, height and RGB of a PNG.
pub(crate) fn pixels(path: &Path) -> (u32, u32, Vec<u8>) {
    let image = image::open(path).unwrap().into_rgb8();
    (image.width(), image.height(), image.into_raw())
}

#[test]
fn the_robots_descriptions_are_what_their_xacro_files_expand_to() {
    let folder = repository().join("ros_pkg/urdf");
    for name in ["fetch_turret", "arm_turret"] {
        let (source, expanded) = (folder.join(format!("{name}.urdf.xacro")), folder.join(format!("{name}.urdf")));
        let compare = repository().join("tests/packages/expand_xacro.py");
        succeed(&format!("/usr/bin/python3 {} {} {}", compare.display(), source.display(), expanded.display()));
        // Where xacro itself is installed, it decides.
        let installed = "command -v xacro >/dev/null || exit 0";
        succeed(&format!("{installed}; cd {}; xacro {name}.urdf.xacro | diff - {name}.urdf", folder.display()));
    }
}
