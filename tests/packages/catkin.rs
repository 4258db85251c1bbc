//! The catkin package: built by each of the three tools, found by rosrun, and clear about what is missing.
//!
//! All build into the test's own cargo folder, where everything is built already.

use std::fs;
use std::os::unix::fs::{symlink, PermissionsExt as _};
use std::path::Path;

use rcs_tests::programs::repository;

use crate::files::pixels;
use crate::{bash, printed_by, processors, succeed, target};

pub(crate) const PROGRAMS: [&str; 10] = [
    "camera_stream",
    "line_of_sight",
    "nav_path_markers",
    "projector",
    "projector_blend",
    "projector_calibrate",
    "projector_window",
    "publish_cloud",
    "simulate_scan",
    "turret_aim",
];

/// A catkin workspace with the repository in it.
fn workspace() -> tempfile::TempDir {
    let workspace = tempfile::tempdir().unwrap();
    fs::create_dir(workspace.path().join("src")).unwrap();
    symlink(repository(), workspace.path().join("src/rviz_camera_stream")).unwrap();
    workspace
}

/// `./test` has compiled the plugin; ccache finds it again if paths below the folder of this build do not count.
fn compiled_once_below(folder: &Path) -> String {
    format!("export CCACHE_BASEDIR={}", folder.display())
}

fn cmake_argument() -> String {
    format!("-DRVIZ_CAMERA_STREAM_TARGET_DIR={}", target().display())
}

/// Prints nodes' commands as `roslaunch --args=NODE rviz_camera_stream FILE` does, each given as `NODE FILE ARGS`:
/// one Python for all of them, because roslaunch takes longer to start than to find a node.
const PRINT_NODES: &str = "import sys, roslaunch
for line in sys.argv[1:]:
    node, *launched = line.split()
    sys.argv = ['roslaunch', '--args=' + node, 'rviz_camera_stream'] + launched
    roslaunch.main(sys.argv)";

/// After `source SETUP`: rosrun starts the program and roslaunch finds all that the launch files name.
fn is_found_after(setup: &Path) {
    let version = env!("CARGO_PKG_VERSION");
    let nodes = [
        "/projector projection.launch",
        "/clusters projection.launch",
        "/desired_object projection.launch",
        "/projector_window projection.launch",
        "/rviz demo.launch",
        "/image_view projection.launch viewer:=image_view",
        "/camera_stream fetch.launch",
        "/simulated_turret paper.launch",
        "/paper_scene paper.launch",
        "/nav_path_markers paper.launch",
        "/turret_aim paper.launch",
        "/line_of_sight paper.launch",
    ];
    let printed = succeed(&format!(
        "unset ROS_PACKAGE_PATH CMAKE_PREFIX_PATH; set +u; source {}; set -u
         rosrun rviz_camera_stream camera_stream --version
         roslaunch --args=/camera_stream rviz_camera_stream projection.launch
         /usr/bin/python3 -c \"{PRINT_NODES}\" '{}'",
        setup.display(),
        nodes.join("' '"),
    ));
    assert!(printed.contains(&format!("camera_stream {version}")), "{printed}");
    assert!(printed.contains("/rviz/fetch.rviz"), "{printed}");
    assert_eq!(printed.lines().count(), 2 + nodes.len(), "one line for each: {printed}");
}

/// After `source SETUP`: rviz loads the plugin from this library, and the plugin publishes an image.
fn rviz_loads_the_plugin_after(setup: &Path, library: &Path) {
    let printed = succeed(&format!(
        "unset ROS_PACKAGE_PATH CMAKE_PREFIX_PATH; set +u; source {}; set -u
         cd tests/rviz && PYTHONPATH=..:$PYTHONPATH python3 -B -W ignore -m rviz_plugin.loads",
        setup.display()
    ));
    let library = fs::canonicalize(library).unwrap();
    assert!(printed.contains("picture 64x48, ") && !printed.contains(" 1 colours"), "{printed}");
    assert!(printed.contains(&format!("from {}", library.display())), "{printed}");
}

#[test]
fn catkin_make_builds_what_rosrun_and_rviz_find() {
    let _processors = processors();
    let workspace = workspace();
    let at = workspace.path();
    succeed(&format!("{} && cd {} && catkin_make {}", compiled_once_below(at), at.display(), cmake_argument()));
    is_found_after(&at.join("devel/setup.bash"));
    rviz_loads_the_plugin_after(&at.join("devel/setup.bash"), &at.join("devel/lib/librviz_camera_stream.so"));
    the_scripts_work_after(&at.join("devel/setup.bash"), at);
}

/// After `source SETUP`, which on Debian leaves the ROS in /usr out of all paths: `./demo` finds everything built, and
/// renders the sample scene.
fn the_scripts_work_after(setup: &Path, folder: &Path) {
    let shown = folder.join("shown.png");
    let printed = succeed(&format!(
        "set +u; source {}; set -u; ./demo --offline --renderer cpu --output {} 2>&1",
        setup.display(),
        shown.display()
    ));
    assert!(!printed.contains("Compiling"), "{printed}");
    assert!(pixels(&shown) == pixels(&repository().join("docs/images/demo.png")), "{printed}");
}

#[test]
#[ignore = "the same build by another tool: ./test full"]
fn catkin_build_installs_what_rosrun_and_rviz_find() {
    let _processors = processors();
    let workspace = workspace();
    let at = workspace.path();
    let cmake_argument = cmake_argument();
    succeed(&format!(
        "{} && cd {} && catkin config --init --install --cmake-args {cmake_argument} && catkin build --no-status --no-notify",
        compiled_once_below(at),
        at.display()
    ));
    is_found_after(&at.join("install/setup.bash"));
    rviz_loads_the_plugin_after(&at.join("install/setup.bash"), &at.join("install/lib/librviz_camera_stream.so"));
}

#[test]
fn plain_cmake_installs_programs_launch_files_and_configs() {
    let _processors = processors();
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeed(&format!(
        "{3} && mkdir {0}/build && cd {0}/build
         cmake {1} {2} -DCMAKE_INSTALL_PREFIX={0}/prefix && make && make install",
        at.display(),
        repository().join("ros_pkg").display(),
        cmake_argument(),
        compiled_once_below(at)
    ));
    let prefix = at.join("prefix");
    for program in PROGRAMS {
        let mode = fs::metadata(prefix.join("lib/rviz_camera_stream").join(program)).unwrap().permissions().mode();
        assert_eq!(mode & 0o111, 0o111, "{program}");
    }
    let share = prefix.join("share/rviz_camera_stream");
    let mut installed = 0;
    for folder in ["launch", "launch/viewers", "rviz", "config", "config/demo", "urdf"] {
        for entry in fs::read_dir(repository().join("ros_pkg").join(folder)).unwrap() {
            let name = entry.unwrap().file_name();
            assert!(share.join(folder).join(&name).exists(), "{folder}/{} is not installed", name.to_string_lossy());
            installed += 1;
        }
    }
    assert!(installed > 10);
    for file in ["man/man1/camera_stream-render.1", "zsh/site-functions/_camera_stream", "fish/vendor_completions.d"] {
        assert!(prefix.join("share").join(file).exists(), "{file} is not installed");
    }
    let completed = succeed(&format!(
        "source {}/share/bash-completion/completions/camera_stream
         COMP_WORDS=(camera_stream render --seq) COMP_CWORD=2
         _camera_stream camera_stream --seq render && echo \"${{COMPREPLY[@]}}\"",
        prefix.display()
    ));
    assert_eq!(completed.trim(), "--sequence");
    for file in ["package.xml", "plugin_description.xml", "icons/classes/CameraPub.svg"] {
        assert!(share.join(file).is_file(), "{file} is not installed");
    }
    rviz_loads_the_plugin_after(&prefix.join("setup.bash"), &prefix.join("lib/librviz_camera_stream.so"));
}

#[test]
fn without_rviz_cmake_says_in_one_line_that_the_plugin_is_left_out() {
    let configure = |arguments: &str| {
        let folder = tempfile::tempdir().unwrap();
        let output =
            bash(&format!("cmake -S ros_pkg -B {} {} {arguments} 2>&1", folder.path().display(), cmake_argument()));
        (output.status.success(), printed_by(&output))
    };
    let (succeeded, printed) = configure("-DCMAKE_DISABLE_FIND_PACKAGE_rviz=ON");
    let about: Vec<_> = printed.lines().filter(|line| line.contains("the rviz plugin")).collect();
    assert!(succeeded && about.len() == 1, "{printed}");
    assert!(about[0].ends_with("the rviz plugin is not built, as these were not found: rviz"), "{printed}");
    let (succeeded, printed) = configure("-DCMAKE_DISABLE_FIND_PACKAGE_rviz=ON -DRVIZ_CAMERA_STREAM_PLUGIN=ON");
    assert!(!succeeded && printed.contains("The rviz plugin needs rviz"), "{printed}");
    let (succeeded, printed) = configure("-DRVIZ_CAMERA_STREAM_PLUGIN=OFF");
    assert!(
        succeeded && printed.contains("the rviz plugin is not built (RVIZ_CAMERA_STREAM_PLUGIN is OFF)"),
        "{printed}"
    );
}

#[test]
fn cargo_and_cmake_read_the_same_message_packages() {
    let between = |file: &str, begin: &str, end: &str| {
        let text = fs::read_to_string(repository().join(file)).unwrap();
        text.split_once(begin).unwrap().1.split_once(end).unwrap().0.to_owned()
    };
    let folders = between(".cargo/config.toml", "value = \"", "\"");
    let mut of_cargo: Vec<_> = folders
        .split(':')
        .map(|folder| folder.strip_prefix("/usr/share/").unwrap().split('/').next().unwrap())
        .collect();
    of_cargo.sort_unstable();
    let packages = between("ros_pkg/cmake/messages.cmake", "set(message_packages ", ")");
    assert_eq!(of_cargo, packages.split_whitespace().collect::<Vec<_>>());
    // Of Debian's packages, or of another ROS, which is then sourced.
    assert!(folders.split(':').all(|folder| Path::new(folder).is_dir()) || std::env::var_os("ROS_DISTRO").is_some());
}

#[test]
fn catkin_finds_one_package_in_the_repository() {
    let printed =
        succeed("python3 -c 'from catkin_pkg.packages import find_package_paths; print(find_package_paths(\".\"))'");
    assert_eq!(printed.trim(), "['ros_pkg']");
}

/// The output of cmake, in one line, when PATH and HOME have only these programs.
fn cmake_output(tools: &[(&str, &str)]) -> String {
    let folder = tempfile::tempdir().unwrap();
    for (name, script) in tools {
        let path = folder.path().join(name);
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    // The system's programs without a cargo that may be among them.
    let output = bash(&format!(
        "mkdir {0}/build {0}/bin && cd {0}/build
         ln -s /usr/bin/* {0}/bin/
         rm -f {0}/bin/cargo* {0}/bin/rust*
         env -u CARGO_HOME HOME={0} PATH={0}:{0}/bin cmake {1}",
        folder.path().display(),
        repository().join("ros_pkg").display()
    ));
    assert!(!output.status.success());
    let words = printed_by(&output);
    assert_eq!(words.matches("CMake Error").count(), 1, "{words}");
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn a_missing_rust_toolchain_is_one_clear_error() {
    let words = cmake_output(&[]);
    assert!(words.contains("No Rust toolchain") && words.contains("https://sh.rustup.rs"), "{words}");
}

#[test]
fn an_old_rust_toolchain_is_one_clear_error_with_both_versions() {
    let words =
        cmake_output(&[("cargo", "echo cargo 1.63.0"), ("rustc", "echo 'rustc 1.63.0 (4b91a6ea7 2022-08-08)'")]);
    let manifest = fs::read_to_string(repository().join("Cargo.toml")).unwrap();
    let needed = manifest.split("rust-version = \"").nth(1).unwrap().split('"').next().unwrap();
    assert!(words.contains("too old") && words.contains("is 1.63.0;"), "{words}");
    assert!(words.contains(&format!("needs Rust {needed} or newer")), "{words}");
}

#[test]
fn a_broken_rust_toolchain_is_reported_with_its_own_error() {
    let broken = "echo 'error: rustup could not choose a version of rustc to run' >&2; exit 1";
    let words = cmake_output(&[("cargo", broken), ("rustc", broken)]);
    assert!(words.contains("does not work: error: rustup could not choose"), "{words}");
}
